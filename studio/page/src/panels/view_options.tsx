import { computed, signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { RenderMode } from "../core/protocol.js";
import { MOST_STOPS } from "../core/looks.js";
import { checkNumber } from "../core/numbers.js";
import { runCommand } from "../commands.js";
import * as documents from "../documents.js";
import { select, writeSettings } from "../entities.js";
import { showPanel } from "../layout/layout_state.js";
import { expose } from "../view/exposure.js";
import * as state from "../state.js";
import { currentCamera } from "../view/wish.js";
import { isProbing, toggleProbe } from "../view/probe.js";
import { showsWorkerTiles, toggleWorkerTiles } from "../view/worker_tiles.js";
import { CameraFields } from "./camera_fields.js";
import { NumberField } from "./number_field.js";

const isOpen = signal(false);

function setTone(name: string, value: unknown): void {
  const tone: Record<string, unknown> = { ...state.tone.peek(), [name]: value };
  if (value === "" || value === undefined) delete tone[name];
  if (tone.transfer !== "gamma") delete tone.gamma;
  // A view of OpenColorIO takes the place of the other three.
  const replaced = name === "ocio-view" ? ["tone-map", "transfer", "gamma"] : name === "exposure" ? [] : ["ocio-view"];
  if (tone[name] !== undefined) for (const each of replaced) delete tone[each];
  state.tone.value = Object.keys(tone).length > 0 ? tone : null;
}

function setOverride(name: string, value: unknown): void {
  const overrides: Record<string, unknown> = { ...state.overrides.peek(), [name]: value };
  if (value === "" || value === undefined) delete overrides[name];
  state.overrides.value = overrides;
}

function setSize(side: "width" | "height", value: number | undefined): void {
  const { [side]: _, ...rest } = state.askedSize.peek();
  state.askedSize.value = value === undefined ? rest : { ...rest, [side]: value };
}

/** All that the view has in place of what the scene says, by what `tessera render` or the scene's settings call it. */
const ownSettings = computed<Record<string, string | number | boolean>>(() => {
  return { ...state.askedSize.value, ...state.overrides.value, ...(state.tone.value ?? {}) } as Record<string, string | number | boolean>;
});

function asTheSceneSays(): void {
  state.askedSize.value = {};
  state.overrides.value = {};
  state.tone.value = null;
}

/** A field of such a setting, which is marked, and leads back, while the view has its own. */
function Setting({ name, children }: { name: string; children: ComponentChildren }) {
  const isOwn = ownSettings.value[name] !== undefined;
  const reset = () => {
    if (name === "width" || name === "height") setSize(name, undefined);
    setOverride(name, undefined);
    setTone(name, undefined);
  };
  return (
    <div class={`setting ${isOwn ? "own" : ""}`}>
      {children}
      {isOwn && <button type="button" class="link" aria-label={`${name} as the scene says`} title="As the scene says" onClick={reset}>↺</button>}
    </div>
  );
}

/** A side of the picture, which is else as large as its pane. */
function Side({ side, other, label }: { side: "width" | "height"; other: "width" | "height"; label: string }) {
  const { value: size } = state.askedSize;
  const beside = size[other] ?? state.summary.value?.size?.[other === "width" ? 0 : 1] ?? 1;
  const most = state.mostOf("pixels");
  const also = (value: number) => (value * beside > most ? `at most ${Math.floor(most / beside)} beside ${beside}` : undefined);
  return (
    <Setting name={side}>
      <NumberField label={label} text={String(size[side] ?? "")} placeholder={size[other] === undefined ? "as the pane" : "scene says"} optional rules={{ whole: true, range: [1, state.mostOf("view_side")], also }} commit={(text) => setSize(side, number(text))} />
    </Setting>
  );
}

/** Over the picture: that the view is not as the scene says, and the way back. */
export function OwnSettings() {
  const names = Object.keys(ownSettings.value);
  if (names.length === 0) return null;
  return <button type="button" class="chip free" title={`The view has its own ${names.join(", ")}: back to what the scene says`} onClick={asTheSceneSays}>own settings</button>;
}

/** What an option takes, or nothing: then the scene says. */
function choicesOrScene(option: string): readonly string[] {
  return ["", ...state.choicesOf(option)];
}

function Choice({ label, value, choices, none, set }: { label: string; value: string; choices: readonly string[]; none?: string; set: (value: string) => void }) {
  return (
    <label class="field">
      <span>{label}</span>
      <select value={value} onChange={(event) => set(event.currentTarget.value)}>
        {choices.map((each) => <option key={each} value={each}>{each === "" ? (none ?? "scene says") : each}</option>)}
      </select>
    </label>
  );
}

function number(text: string): number | undefined {
  const checked = checkNumber(text);
  return checked.ok ? checked.value : undefined;
}

/** Size, depth, shadows and the rest are properties of the scene's own settings. */
function SceneSettings() {
  const outline = state.sceneFile.value === undefined ? undefined : state.outlines.value.get(state.sceneFile.value);
  const settings = outline?.entities.find((each) => each.kind === "settings");
  if (!settings) return null;
  return (
    <button type="button" title="Size, depth, shadows and all else that the scene says" onClick={() => {
      documents.activate(outline!.file);
      select(settings);
      showPanel("Properties", true);
    }}>
      Settings of the scene…
    </button>
  );
}

/** What the view has in place of the scene's settings becomes the scene's own. */
function WriteToSource() {
  const { "ocio-view": _, denoise: __, ...options } = ownSettings.value;  // which no scene says
  const camera = currentCamera();
  const names = Object.keys(options);
  return (
    <div class="buttons">
      <button type="button" disabled={names.length === 0} title={names.length === 0 ? "The view shows what the scene says" : `Writes ${names.join(", ")}`} onClick={() => writeSettings(options)}>
        Write settings to source
      </button>
      <button type="button" disabled={Object.keys(ownSettings.value).length === 0} onClick={asTheSceneSays}>
        As the scene says
      </button>
      <SceneSettings />
      <button type="button" disabled={!camera} onClick={() => runCommand("Write camera")}>Write camera</button>
    </div>
  );
}

/** How the picture is looked at: channel, tone, and what the view sets in place of what the scene says. */
export function ViewOptions() {
  const { value: tone } = state.tone;
  const { value: overrides } = state.overrides;
  const exposure = tone?.exposure ?? 0;
  return (
    <details class="view-options" open={isOpen.value} onToggle={(event) => (isOpen.value = event.currentTarget.open)}>
      <summary>
        Look
        <span class="aside">{state.channel.value}{exposure === 0 ? "" : `, ${exposure > 0 ? "+" : ""}${exposure} stops`}{Object.keys(ownSettings.value).length > 0 ? ", settings overridden" : ""}</span>
      </summary>
      <div class="fields">
        <Choice label="Channel" value={state.channel.value} choices={state.choicesOf("channel")} set={(value) => (state.channel.value = value)} />
        <Setting name="exposure"><label class="field">
          <span>Exposure</span>
          <span class="group">
            <button type="button" aria-label="Half a stop less" onClick={() => expose(-0.5)}>−</button>
            <input type="range" aria-label="Exposure in stops" min={-MOST_STOPS} max={MOST_STOPS} step={0.1} value={exposure} onInput={(event) => setTone("exposure", Number(event.currentTarget.value))} />
            <button type="button" aria-label="Half a stop more" onClick={() => expose(0.5)}>+</button>
            <output>{exposure.toFixed(1)}</output>
          </span>
        </label></Setting>
        <Setting name="tone-map">
          <Choice label="Tone map" value={tone?.["tone-map"] ?? ""} choices={choicesOrScene("tone-map")} set={(value) => setTone("tone-map", value)} />
        </Setting>
        <label class="field">
          <span>Denoise</span>
          <span><input type="checkbox" aria-label="Denoise the last pass" checked={overrides.denoise === true} onChange={(event) => setOverride("denoise", event.currentTarget.checked || undefined)} /> the last pass</span>
        </label>
        <Setting name="transfer">
          <Choice label="Transfer" value={tone?.transfer ?? ""} choices={choicesOrScene("transfer")} set={(value) => setTone("transfer", value)} />
        </Setting>
        {tone?.transfer === "gamma" && <NumberField label="Gamma" text={String(tone.gamma ?? "")} placeholder="scene says" optional rules={{ range: [0.1, 10] }} commit={(text) => setTone("gamma", number(text))} />}
        <Setting name="ocio-view"><label class="field" title="A view of the configuration that $OCIO names, or 'default', in place of tone map and transfer">
          <span>OpenColorIO view</span>
          <input type="text" value={tone?.["ocio-view"] ?? ""} placeholder="none" spellcheck={false} onChange={(event) => setTone("ocio-view", event.currentTarget.value.trim())} />
        </label></Setting>
        <Side side="width" other="height" label="Width" />
        <Side side="height" other="width" label="Height" />
        <Choice label="Render" value={state.renderMode.value} choices={["typing", "save", "hand"]} set={(value) => (state.renderMode.value = value as RenderMode)} />
        <Setting name="integrator">
          <Choice label="Integrator" value={String(overrides.integrator ?? "")} choices={choicesOrScene("integrator")} set={(value) => setOverride("integrator", value)} />
        </Setting>
        <Setting name="max-depth">
          <NumberField label="Maximum depth" text={String(overrides["max-depth"] ?? "")} placeholder="scene says" optional rules={{ whole: true, range: [0, state.mostOf("max-depth")] }} commit={(text) => setOverride("max-depth", number(text))} />
        </Setting>
        <Setting name="shadows">
          <Choice label="Shadows" value={overrides.shadows ?? ""} choices={choicesOrScene("shadows")} set={(value) => setOverride("shadows", value)} />
        </Setting>
        <Setting name="spp">
          <NumberField label="Samples" text={String(overrides.spp ?? "")} placeholder="scene says" optional rules={{ whole: true, range: [1, state.mostOf("spp")] }} commit={(text) => setOverride("spp", number(text))} />
        </Setting>
        <Setting name="target-error">
          <NumberField label="Target error" text={String(overrides["target-error"] ?? "")} placeholder="scene says" optional rules={{ range: [0, Infinity] }} commit={(text) => setOverride("target-error", number(text))} />
        </Setting>
        <Setting name="pattern">
          <Choice label="Pattern" value={overrides.pattern ?? ""} choices={choicesOrScene("pattern")} set={(value) => setOverride("pattern", value)} />
        </Setting>
        <Setting name="filter">
          <Choice label="Filter" value={overrides.filter ?? ""} choices={choicesOrScene("filter")} set={(value) => setOverride("filter", value)} />
        </Setting>
        <label class="field">
          <span>Probe</span>
          <span><input type="checkbox" aria-label="Values under the pointer" checked={isProbing.value} onChange={toggleProbe} /> values under the pointer</span>
        </label>
        <label class="field">
          <span>Tiles</span>
          <span><input type="checkbox" aria-label="Outline tiles by worker" checked={showsWorkerTiles.value} onChange={toggleWorkerTiles} /> outlined by worker</span>
        </label>
        <CameraFields />
        <WriteToSource />
      </div>
    </details>
  );
}
