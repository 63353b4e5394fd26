import { useRef, useState } from "preact/hooks";
import type { Placement } from "../core/protocol.js";
import { baseName } from "../core/paths.js";
import { place } from "../entities.js";
import { candidates, wished, type ModelWish } from "../models.js";
import { NumberField } from "../panels/number_field.js";
import { goToWrongField } from "../wrong_field.js";
import { Dialog } from "./dialog.js";

const AXES = ["x", "y", "z"] as const;
type Triple = Placement["position"];

const close = () => (wished.value = undefined);

function replaced<T>(all: [T, T, T], index: number, value: T): [T, T, T] {
  return all.map((each, at) => (at === index ? value : each)) as [T, T, T];
}

function TripleField({ label, unit, value, positive, disabled, set }: { label: string; unit?: string; value: Triple; positive?: boolean; disabled: boolean; set: (value: Triple) => void }) {
  return (
    <div class="field" role="group" aria-label={label}>
      <span>{label}</span>
      <span class="vector">
        {AXES.map((axis, index) => (
          <NumberField
            key={axis} quiet label={`${label} ${axis}`} text={value[index]!} disabled={disabled} unit={unit}
            rules={positive ? { range: [0, Infinity], open: true } : {}} commit={(text) => set(replaced(value, index, text))}
          />
        ))}
      </span>
    </div>
  );
}

/** What is wrong with the name of a file; nothing where it is one of those that can be placed. */
function faultOfFile(name: string, known: readonly string[]): string | undefined {
  if (known.includes(name)) return undefined;
  const found = name.trim() === "" ? "nothing" : `“${name}”, which is no such file`;
  return `found ${found}; expected a model or a scene in the folder of this one`;
}

/** "sphere.obj" is called "Sphere". */
function titleOf(file: string): string {
  const name = baseName(file).replace(/\..*$/, "");
  return name === "" ? "Model" : name.charAt(0).toUpperCase() + name.slice(1);
}

export function ModelDialog({ wish }: { wish: ModelWish }) {
  const [placement, setPlacement] = useState(wish.placement);
  const [isUneven, setUneven] = useState(new Set(wish.placement.scale).size > 1);
  const form = useRef<HTMLFormElement>(null);
  const known = candidates(wish.file);
  const fault = faultOfFile(placement.file, known);
  const isLocked = wish.locked !== undefined;
  const set = (changes: Partial<Placement>) => setPlacement({ ...placement, ...changes });
  const accept = () => {
    if (isLocked || goToWrongField(form.current!) !== undefined) return;
    place(wish.file, wish.entity, placement);
    close();
  };
  return (
    <Dialog title={titleOf(wish.placement.file)} close={close}>
      <form
        ref={form}
        onKeyDown={(event) => {
          if (event.key !== "Enter" || !event.ctrlKey) return;
          event.preventDefault();
          accept();
        }}
        onSubmit={(event) => {
          event.preventDefault();
          accept();
        }}
      >
        <div class="fields">
          <label class={`field ${fault ? "wrong" : ""}`}>
            <span>File</span>
            <input
              type="text" autofocus spellcheck={false} autocomplete="off" list="model-files" value={placement.file} disabled={isLocked}
              aria-invalid={fault !== undefined} aria-describedby={fault ? "model-file-wrong" : undefined}
              onInput={(event) => set({ file: event.currentTarget.value })}
            />
            {fault && <span class="why" id="model-file-wrong">{fault}</span>}
            <datalist id="model-files">{known.map((each) => <option key={each} value={each} />)}</datalist>
          </label>
          <TripleField label="Position" value={placement.position} disabled={isLocked} set={(position) => set({ position })} />
          <TripleField label="Rotation" unit="°" value={placement.rotation} disabled={isLocked} set={(rotation) => set({ rotation })} />
          {isUneven ? (
            <TripleField label="Scale" positive value={placement.scale} disabled={isLocked} set={(scale) => set({ scale })} />
          ) : (
            <NumberField label="Scale" text={placement.scale[0]} rules={{ range: [0, Infinity], open: true }} disabled={isLocked} commit={(text) => set({ scale: [text, text, text] })} />
          )}
          <label class="field">
            <span>Each axis by itself</span>
            <span><input type="checkbox" aria-label="Scale each axis by itself" checked={isUneven} disabled={isLocked} onChange={(event) => {
              setUneven(event.currentTarget.checked);
              const [first] = placement.scale;
              if (!event.currentTarget.checked) set({ scale: [first, first, first] });
            }} /></span>
          </label>
          <div class="field" role="group" aria-label="Flip">
            <span>Flip</span>
            <span class="group">
              {AXES.map((axis, index) => (
                <label key={axis}>
                  <input type="checkbox" aria-label={`Flip ${axis}`} checked={placement.flip[index]} disabled={isLocked} onChange={(event) => set({ flip: replaced(placement.flip, index, event.currentTarget.checked) })} /> {axis}
                </label>
              ))}
            </span>
          </div>
          {wish.materials && (
            <label class="field">
              <span>Material</span>
              <select value={placement.material} disabled={isLocked} onChange={(event) => set({ material: event.currentTarget.value })}>
                <option value="">its own</option>
                {[...new Set([...wish.materials, placement.material])].filter(Boolean).map((each) => <option key={each} value={each}>{each}</option>)}
              </select>
            </label>
          )}
        </div>
        {isLocked && <p class="aside">Nothing is set here: {wish.locked}.</p>}
        <div class="buttons">
          <button type="button" onClick={close}>Cancel</button>
          <button type="submit" class="primary" disabled={isLocked}>Accept</button>
        </div>
      </form>
    </Dialog>
  );
}
