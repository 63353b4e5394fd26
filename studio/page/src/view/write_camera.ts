// The view's camera in the text, which the view sees through from then on.

import { effect, signal, untracked } from "@preact/signals";
import { copyText } from "../clipboard.js";
import type { CameraWish } from "../core/protocol.js";
import * as documents from "../documents.js";
import { writeCamera } from "../entities.js";
import { ask } from "../questions.js";
import * as state from "../state.js";
import { currentCamera, moveCamera, pivot, setPivot } from "./wish.js";

/** The camera that was written, until the program has read the text with it. */
const written = signal<{ file: string; version: number; from: CameraWish; name: string | undefined } | undefined>(undefined);

/** The width of the view's picture over its height, by which an angle over one side is another over the other. */
function aspect(): number {
  const [width, height] = state.viewSize.peek();
  return height > 0 ? width / height : 0;
}

/** Writes the numbers of the view's camera to the one that it was moved from, or the first. */
export function writeViewCamera(): void {
  const camera = currentCamera();
  const file = state.sceneFile.peek();
  const from = state.camera.peek();
  if (!camera || file === undefined) return;
  writeCamera(camera, aspect(), camera.name, () => {
    written.value = { file, version: documents.find(file)?.sync.version ?? 0, from, name: camera.name };
  });
}

/** Puts the text of the camera into the clipboard, as writing it would leave it. */
export async function copyCameraText(): Promise<void> {
  const camera = currentCamera();
  const file = state.sceneFile.peek();
  if (!camera || file === undefined) return;
  const told = await ask("camera_text", file, { camera, aspect: aspect(), text: camera.name ?? "" });
  if (told) await copyText(told.text);
  else state.notify(`${file} has no words for this camera; “Write camera” says why.`, "error");
}

/** What was written is shorter than the numbers that the mouse made: the picture is made again of it, so that it is
    that of `tessera render`. Where the camera was moved meanwhile, it stays free. */
export function watchWrittenCamera(): void {
  effect(() => {
    const { value: wish } = written;
    const { value: summary } = state.summary;
    if (!wish || summary?.file !== wish.file || summary.version < wish.version) return;
    untracked(() => {
      written.value = undefined;
      if (state.sceneFile.peek() !== wish.file || state.camera.peek() !== wish.from) return;
      const about = pivot.peek();
      moveCamera(wish.name === undefined ? null : { name: wish.name }, false);
      setPivot(about);
    });
  });
}
