// Pictures of the animation's frames, which the program makes while it has nothing better to do: all of
// them coarse first, then as large as the view.

import { effect, signal } from "@preact/signals";
import * as program from "../program.js";
import * as state from "../state.js";
import { HiddenPane } from "./hidden_pane.js";

const MOST_BYTES = 256 * 2 ** 20;
/** From the largest pictures: each is made of so many times fewer pixels a side. */
const SCALES = [4, 1];

export type FrameState = "none" | "coarse" | "whole" | "failed";

interface Frame {
  image?: ImageData;
  state: FrameState;
}

export const isCaching = signal(false);
/** Changes whenever a frame has another state. */
export const revision = signal(0);
/** The frame that is shown from here, in place of the view's own picture. */
export const shown = signal<ImageData | undefined>(undefined);

let range: [first: number, last: number] = [0, -1];
let frames = new Map<number, Frame>();
let look = "";
export const pane = new HiddenPane<{ frame: number; scale: number }>(state.PANES_ASIDE.frames, settle);

export function stateOf(frame: number): FrameState {
  return frames.get(frame)?.state ?? "none";
}

export function imageOf(frame: number): ImageData | undefined {
  return frames.get(frame)?.image;
}

/** Has the frames of that range made; those of another look are forgotten. */
export function cache(first: number, last: number): void {
  range = [first, last];
  isCaching.value = true;
  next();
}

export function stopCaching(): void {
  isCaching.value = false;
  if (pane.asked) program.send("stop", { pane: state.PANES_ASIDE.frames });
  pane.forget();
}

/** All that decides the pictures beside frame and size. */
function currentLook(): string {
  return JSON.stringify([
    state.sceneFile.value, state.summary.value?.version, state.viewSize.value, state.camera.value, state.overrides.value,
    state.channel.value, state.tone.value, state.hidden.value, state.solo.value,
  ]);
}

export function watchFrames(): void {
  effect(() => {
    const now = currentLook();
    if (now === look) return;
    look = now;
    frames = new Map();
    pane.forget();
    shown.value = undefined;
    revision.value = revision.peek() + 1;
    if (isCaching.peek()) next();
  });
}

/** Asks a program anew that does not know of the frame that was asked for. */
export function resumeCaching(): void {
  pane.forget();
  next();
}

function next(): void {
  if (!isCaching.peek() || pane.asked) return;
  const file = state.sceneFile.peek();
  const [width, height] = state.viewSize.peek();
  if (file === undefined || width < 1) return;
  for (const scale of SCALES) {
    const size: [number, number] = [Math.ceil(width / scale), Math.ceil(height / scale)];
    if (4 * size[0] * size[1] * (range[1] - range[0] + 1) > MOST_BYTES) continue;
    for (let frame = range[0]; frame <= range[1]; ++frame) {
      const known = stateOf(frame);
      if (known === "whole" || known === "failed" || (known === "coarse" && scale > 1)) continue;
      pane.ask({ frame, scale }, {
        file, size, frame, camera: state.camera.peek(), mode: "typing",
        overrides: state.overrides.peek(), channel: state.channel.peek(), tone: state.tone.peek(),
        hidden: state.hidden.peek(), solo: state.solo.peek(),
      });
      return;
    }
  }
}

function settle({ frame, scale }: { frame: number; scale: number }, image: ImageData | null): void {
  frames.set(frame, image ? { image, state: scale > 1 ? "coarse" : "whole" } : { state: "failed" });
  revision.value = revision.peek() + 1;
  next();
}
