// Every command with its keys. The palette lists them; the key map is made of them and of the keys that were changed.

import { redo, undo } from "@codemirror/commands";
import { findNext, findPrevious, gotoLine, openSearchPanel } from "@codemirror/search";
import { foldAll, unfoldAll } from "@codemirror/language";
import { startCompletion } from "@codemirror/autocomplete";
import type { EditorView } from "@codemirror/view";
import { computed, signal } from "@preact/signals";
import { maximise, PANELS, zoneOf, type PanelName } from "./core/layout.js";
import { keyMap, nameOfKey, withKeys } from "./core/keys.js";
import * as documents from "./documents.js";
import { chooseFiles } from "./drops.js";
import { fixNearest } from "./editor/problem_marks.js";
import { choosePreset, focusedPanel, layout, movePanel, narrow, showPanel } from "./layout/layout_state.js";
import * as program from "./program.js";
import { orderRenderOfPage, stopActive } from "./renders.js";
import * as state from "./state.js";
import * as compare from "./view/compare.js";
import { showAll } from "./view/filter.js";
import { zoom, zoomOut, zoomToPixels } from "./view/magnifier.js";
import { expose } from "./view/exposure.js";
import { walkChain } from "./view/picking.js";
import { VIEW_COMMANDS } from "./view/view_commands.js";
import { toggleProbe } from "./view/probe.js";
import { moveCamera, pauseOrResume, refresh, stop } from "./view/wish.js";
import { copyCameraText, writeViewCamera } from "./view/write_camera.js";
import { toggleWorkerTiles } from "./view/worker_tiles.js";

export interface Command {
  name: string;
  keys: readonly string[];
  run: () => void;
  /** Whether a text field with the focus does the same by the same keys to its own text. */
  inFields?: boolean;
  /** Keys that it has while the picture has the focus; such a command has no others. */
  inView?: readonly string[];
}

/** A file that is asked about before it is closed. */
export const closing = signal<string | undefined>(undefined);

export function closeFile(file: string): void {
  if (documents.find(file)?.dirty) closing.value = file;
  else documents.close(file);
}

function withActive(run: (file: string) => void): () => void {
  return () => {
    const file = state.activeFile.peek();
    if (file !== undefined) run(file);
  };
}

function inEditor(run: (view: EditorView) => unknown): () => void {
  return () => {
    const view = documents.editorView();
    if (!view) return;
    if (!view.dom.contains(document.activeElement)) showPanel("Script", true);
    run(view);
  };
}

export function saveActive(): void {
  const file = state.activeFile.peek();
  const document = documents.find(file);
  if (document) documents.save(document.file);
}

function renderFull(): void {
  if (orderRenderOfPage()) showPanel("Farm");
}

/** The focus goes to the next panel that is seen, or the one before. */
function cycle(step: number): void {
  const regions = [...document.querySelectorAll<HTMLElement>("section[aria-label]")];
  const at = regions.findIndex((each) => each.contains(document.activeElement));
  const next = regions[at < 0 && step < 0 ? regions.length - 1 : (at + step + regions.length) % regions.length];
  const panel = next?.getAttribute("aria-label") as PanelName | undefined;
  if (panel) showPanel(panel, true);
}

function nextFile(step: number): void {
  const all = documents.documents.peek();
  const at = all.findIndex((each) => each.file === state.activeFile.peek());
  const next = all[(at + step + all.length) % all.length];
  if (next) documents.activate(next.file);
}

const COMMANDS = [
  { name: "Save", keys: ["Ctrl-S", "Alt-S"], run: saveActive },
  { name: "Save as…", keys: ["Ctrl-Shift-S"], run: () => (state.dialog.value = "save_as") },
  { name: "Open: list of files", keys: ["Ctrl-O", "Alt-O"], run: () => showPanel("Files", true) },
  { name: "New: empty scene", keys: ["Alt-N"], run: () => void program.send("create", { template: "empty" }) },
  { name: "New: LUX", keys: [], run: () => void program.send("create", { template: "lux" }) },
  { name: "New: CRT script", keys: [], run: () => void program.send("create", { template: "crt" }) },
  { name: "Copy files into the folder…", keys: [], run: chooseFiles },
  { name: "Close file", keys: ["Alt-W"], run: withActive(closeFile) },
  { name: "Reload file from the disk", keys: [], run: withActive(documents.loadTheirs) },
  { name: "Next file", keys: ["Alt-PageDown"], run: () => nextFile(1) },
  { name: "Previous file", keys: ["Alt-PageUp"], run: () => nextFile(-1) },
  { name: "Undo", keys: ["Ctrl-Z"], inFields: true, run: inEditor(undo) },
  { name: "Redo", keys: ["Ctrl-Y", "Ctrl-Shift-Z"], inFields: true, run: inEditor(redo) },
  { name: "Find", keys: ["Ctrl-F"], run: inEditor(openSearchPanel) },
  { name: "Find next", keys: ["F3", "Ctrl-G"], run: inEditor(findNext) },
  { name: "Find previous", keys: ["Shift-F3", "Ctrl-Shift-G"], run: inEditor(findPrevious) },
  { name: "Replace", keys: ["Ctrl-H"], run: inEditor(openSearchPanel) },
  { name: "Go to line", keys: ["Alt-G"], run: inEditor(gotoLine) },
  { name: "Complete", keys: ["Ctrl-Space"], run: inEditor(startCompletion) },
  { name: "Fold everything", keys: [], run: inEditor(foldAll) },
  { name: "Unfold everything", keys: [], run: inEditor(unfoldAll) },
  { name: "Fix the nearest problem", keys: ["Ctrl-."], run: () => fixNearest() },
  { name: "Render: full picture", keys: ["Ctrl-Enter", "Alt-R"], run: renderFull },
  { name: "Render: full picture with options…", keys: ["Ctrl-Shift-Enter"], run: () => (state.dialog.value = "render") },
  { name: "Render: stop the full picture", keys: [], run: stopActive },
  { name: "Render: this view now", keys: ["Alt-P"], run: refresh },
  { name: "Render: pause or resume the view", keys: [], inView: ["Space"], run: pauseOrResume },
  { name: "Render: stop the view", keys: [], inView: ["Escape"], run: stop },
  { name: "Render: as I type", keys: [], run: () => (state.renderMode.value = "typing") },
  { name: "Render: on save", keys: [], run: () => (state.renderMode.value = "save") },
  { name: "Render: by hand", keys: [], run: () => (state.renderMode.value = "hand") },
  { name: "Camera: the scene’s", keys: [], inView: ["Home", "0"], run: () => moveCamera(null, false, state.activePane.peek()) },
  { name: "Write camera", keys: [], run: writeViewCamera },
  { name: "Camera: copy", keys: [], run: () => void copyCameraText() },
  { name: "Picked: outwards", keys: [], inView: ["Alt-Up"], run: () => walkChain(1) },
  { name: "Picked: inwards", keys: [], inView: ["Alt-Down"], run: () => walkChain(-1) },
  { name: "Probe: values under the pointer, on or off", keys: [], inView: ["P"], run: toggleProbe },
  { name: "Compare: pin this picture", keys: [], inView: ["C"], run: () => compare.pin("shown") },
  { name: "Compare: with the picture before the last change", keys: [], run: compare.compareWithBefore },
  { name: "Compare: the pinned picture, or the other", keys: [], inView: ["B"], run: () => compare.toggle("pinned") },
  { name: "Compare: wipe", keys: [], inView: ["V"], run: () => compare.toggle("wipe") },
  { name: "Compare: difference", keys: [], inView: ["N"], run: () => compare.toggle("difference") },
  { name: "Compare: unpin", keys: [], run: () => compare.pin("none") },
  { name: "View: 1 pane", keys: [], run: () => (state.paneCount.value = 1) },
  { name: "View: 2 panes", keys: [], run: () => (state.paneCount.value = 2) },
  { name: "View: 4 panes", keys: [], run: () => (state.paneCount.value = 4) },
  { name: "View: outline tiles by worker, on or off", keys: [], run: toggleWorkerTiles },
  { name: "View: show all of the scene", keys: [], run: showAll },
  { name: "Zoom: enlarge the picture", keys: [], inView: ["Z"], run: () => zoom(state.activePane.peek(), 1) },
  { name: "Zoom: reduce the picture", keys: [], inView: ["Shift-Z"], run: () => zoom(state.activePane.peek(), -1) },
  { name: "Zoom: 1:1, a point of the screen for each pixel", keys: [], inView: ["O"], run: () => zoomToPixels(state.activePane.peek()) },
  { name: "Zoom: fit, all of the picture", keys: [], inView: ["Shift-O"], run: () => zoomOut(state.activePane.peek()) },
  { name: "Exposure: half a stop more", keys: [], inView: ["]"], run: () => expose(0.5) },
  { name: "Exposure: half a stop less", keys: [], inView: ["["], run: () => expose(-0.5) },
  { name: "Export picture or scene…", keys: ["Alt-E"], run: () => (state.dialog.value = "export") },
  { name: "Theme: dark", keys: [], run: () => (state.themeChoice.value = "dark") },
  { name: "Theme: light", keys: [], run: () => (state.themeChoice.value = "light") },
  { name: "Theme: as the system", keys: [], run: () => (state.themeChoice.value = "system") },
  { name: "Contrast: high", keys: [], run: () => (state.contrastChoice.value = "high") },
  { name: "Contrast: normal", keys: [], run: () => (state.contrastChoice.value = "normal") },
  { name: "Contrast: as the system", keys: [], run: () => (state.contrastChoice.value = "system") },
  { name: "Font: larger", keys: [], run: () => (state.fontSize.value = Math.min(40, state.fontSize.peek() + 1)) },
  { name: "Font: smaller", keys: [], run: () => (state.fontSize.value = Math.max(8, state.fontSize.peek() - 1)) },
  { name: "Layout: default", keys: [], run: () => choosePreset("Default") },
  { name: "Layout: CRT", keys: [], run: () => choosePreset("CRT") },
  { name: "Layout: LUX", keys: [], run: () => choosePreset("LUX") },
  { name: "Layout: maximise the zone, or back", keys: ["Ctrl-M"], run: () => {
    const focused = focusedPanel();
    const zone = layout.peek().maximised ?? (focused && zoneOf(layout.peek(), focused));
    if (!zone || narrow.peek()) return;
    layout.value = maximise(layout.peek(), zone);
    const shown = layout.peek().zones[zone];
    if (shown.shown) showPanel(shown.shown, true);
  } },
  { name: "Layout: move the panel to the next zone", keys: ["Ctrl-Alt-Right"], run: () => movePanel(1) },
  { name: "Layout: move the panel to the zone before", keys: ["Ctrl-Alt-Left"], run: () => movePanel(-1) },
  { name: "Full screen", keys: ["F11", "Alt-F"], run: () => void (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen()) },
  { name: "Next panel", keys: ["F6"], run: () => cycle(1) },
  { name: "Previous panel", keys: ["Shift-F6"], run: () => cycle(-1) },
  { name: "Settings", keys: ["Ctrl-,"], run: () => (state.dialog.value = "settings") },
  { name: "Keys…", keys: [], run: () => (state.dialog.value = "keys") },
  { name: "Commands", keys: ["F1"], run: () => (state.dialog.value = "commands") },
  { name: "About", keys: ["Alt-A"], run: () => (state.dialog.value = "about") },
] as const satisfies readonly Command[];

export type CommandName = (typeof COMMANDS)[number]["name"];

const ALL: readonly Command[] = [...COMMANDS, ...VIEW_COMMANDS, ...PANELS.map((panel) => ({ name: `Show ${panel}`, keys: [], run: () => showPanel(panel, true) }))];

/** All commands, with the keys that they have now. */
export const commands = computed<readonly Command[]>(() => {
  const changed = state.changedKeys.value;
  return ALL.map((each) => (Object.hasOwn(changed, each.name) ? withKeys(each, changed[each.name]!) : each));
});

/** The keys of a command, as a button tells them. */
export function keysOf(name: CommandName): string {
  const keys = commands.value.find((each) => each.name === name)!.keys;
  return keys[0] === undefined ? "" : ` (${keys[0]})`;
}

export function runCommand(name: CommandName): void {
  COMMANDS.find((each) => each.name === name)?.run();
}

/** Gives a command other keys, until it is given none again: then it has those of its own. */
export function changeKeys(name: string, keys: string[] | undefined): void {
  const { [name]: _, ...rest } = state.changedKeys.peek();
  state.changedKeys.value = keys === undefined ? rest : { ...rest, [name]: keys };
}

/** Whether the keys are being changed, so that none runs a command. */
export const takesKeys = signal(false);

const byKey = computed(() => keyMap(commands.value));
/** Whose keys they are until they are changed. */
const byOwnKey = keyMap(ALL);

const byViewKey = computed(() => keyMap(commands.value.map(({ name, inView = [] }) => ({ name, keys: inView }))));

/** Runs the command whose key it is while the picture has the focus; false where it is none's. */
export function runInView(event: KeyboardEvent): boolean {
  const key = nameOfKey(event);
  const name = key === undefined ? undefined : byViewKey.value.get(key);
  ALL.find((each) => each.name === name)?.run();
  return name !== undefined;
}

function isField(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.matches("input, textarea, select");
}

/** Listens for the keys of all commands, before whatever has the focus. */
export function watchKeys(): void {
  document.addEventListener(
    "keydown",
    (event) => {
      const key = nameOfKey(event);
      const name = key === undefined ? undefined : (byKey.value.get(key) ?? byOwnKey.get(key));
      if (name === undefined || takesKeys.peek() || event.isComposing) return;
      const command = commands.value.find((each) => each.name === name)!;
      // A dialog has the keys to itself.
      if (document.querySelector("dialog[open]") && name !== "Commands") return;
      if (command.inFields && isField(event.target)) return;
      event.preventDefault();
      event.stopPropagation();
      // A key that was taken from its command is nobody's: the browser would do the same by it.
      if (command.keys.includes(key!)) command.run();
    },
    { capture: true },
  );
}
