// Files from the desktop, dropped onto a panel: they are copied into the folder, and placed, shown or opened there.

import { folderOf, isCompanion, isModelFile, isPicture, isText } from "./core/paths.js";
import * as documents from "./documents.js";
import { addToScene } from "./entities.js";
import * as program from "./program.js";
import * as state from "./state.js";
import { upload } from "./uploads.js";
import { spotAt, type Spot } from "./panels/pane_frame.js";
import { look } from "./view/picking.js";

type Target = "View" | "Scene" | "Models" | "Script" | "Files";
const TARGETS: readonly string[] = ["View", "Scene", "Models", "Script", "Files"] satisfies Target[];

function targetOf(event: DragEvent): Target | undefined {
  const label = (event.target as Element | null)?.closest?.("section[aria-label]")?.getAttribute("aria-label");
  return label && TARGETS.includes(label) ? (label as Target) : undefined;
}

function hasFiles(event: DragEvent): boolean {
  return event.dataTransfer?.types.includes("Files") ?? false;
}

function show(target: Target | undefined): void {
  if (target) document.documentElement.dataset.drop = target;
  else delete document.documentElement.dataset.drop;
}

/** A file that is dropped where nothing takes it would replace the page; the editor would take its text. What else is
    dragged, such as text of the editor, is not for here. */
export function watchDrops(): void {
  const over = (event: DragEvent) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    const target = targetOf(event);
    event.dataTransfer!.dropEffect = target ? "copy" : "none";
    show(target);
    event.stopPropagation();
  };
  window.addEventListener("dragenter", over, { capture: true });
  window.addEventListener("dragover", over, { capture: true });
  window.addEventListener("dragleave", (event) => event.relatedTarget === null && show(undefined), { capture: true });
  window.addEventListener(
    "drop",
    (event) => {
      show(undefined);
      if (!hasFiles(event)) return;
      event.preventDefault();
      event.stopPropagation();
      const target = targetOf(event);
      const files = [...event.dataTransfer!.files];
      if (target) void take(files, target, spotAt(event));
    },
    { capture: true },
  );
}

/** Asks for files, and copies them, for who does not drop any. */
export function chooseFiles(): void {
  const input = document.createElement("input");
  input.type = "file";
  input.multiple = true;
  input.addEventListener("change", () => void take([...(input.files ?? [])], "Files"));
  input.click();
}

/** Copies the files, and does with them what their target is for. */
export async function take(files: readonly File[], target: Target, spot?: Spot): Promise<void> {
  // What lies there is looked for before the first of them changes it.
  const seen = spot && state.sceneFile.peek() !== undefined ? await look(spot) : undefined;
  const beside = target === "Script" || target === "Files" ? state.activeFile.peek() : state.sceneFile.peek();
  // A scene reads a model as soon as it includes it: the files that the model names come before.
  const companions = files.filter(({ name }) => isCompanion(name) || isPicture(name));
  for (const file of [...companions, ...files.filter((each) => !companions.includes(each))]) {
    const name = await upload(file, folderOf(beside ?? ""));
    if (name === undefined) continue;
    if (target === "Files") state.notify(`Copied: ${name}`);
    else if (target === "Script") open(name);
    else if (companions.includes(file) && companions.length < files.length) state.notify(`Copied: ${name}`);
    else if (isCompanion(name)) state.notify(`Copied: ${name}. It belongs to a model, which is what scenes include.`);
    else place(name, seen, spot !== undefined);
  }
}

function open(name: string): void {
  if (isText(name)) documents.open(name);
  else state.notify(`Copied: ${name}. It has no text to edit.`);
}

function place(name: string, seen: Awaited<ReturnType<typeof look>>, onPicture: boolean): void {
  const scene = state.sceneFile.peek();
  if (scene === undefined) {
    if (isModelFile(name)) program.send("create", { model: name });
    else open(name);
    return;
  }
  const text = name.slice(folderOf(scene).length);
  if (!isPicture(name)) return addToScene("include", { text, position: seen?.point });
  // Where nothing is hit, the background is seen.
  if (onPicture && seen && seen.chain.length === 0) return addToScene("panorama", { text });
  state.notify(`Copied: ${name}. Drop it where the background is seen to have it there.`);
}
