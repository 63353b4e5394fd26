// Pictures of the animation's frames, which the program makes while it has nothing better to do: all of
// them coarse first, then as large as the view. Where a text is another, each is asked about, and made anew if its
// scene is another.

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
  /** Of its scene. */
  digest?: string | undefined;
  /** Whether it is of the text as it is now. */
  generation: number;
}

export const isCaching = signal(false);
/** Changes whenever a frame has another state. */
export const revision = signal(0);
/** The frame that is shown from here, in place of the view's own picture. */
export const shown = signal<ImageData | undefined>(undefined);

let range: [first: number, last: number] = [0, -1];
let frames = new Map<number, Frame>();
let look = "";
/** Of the texts that were read last. */
let read: number | undefined;
/** Grows with each. */
let generation = 0;
export const pane = new HiddenPane<{ frame: number; scale: number }>(state.PANES_ASIDE.frames, settle);

/** Nothing where it is not known whether the frame is still right. */
function current(frame: number): Frame | undefined {
  const known = frames.get(frame);
  return known?.generation === generation ? known : undefined;
}

export function stateOf(frame: number): FrameState {
  return current(frame)?.state ?? "none";
}

export function imageOf(frame: number): ImageData | undefined {
  return current(frame)?.image;
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

/** All that decides the pictures beside the frame and its scene. */
function currentLook(): string {
  return JSON.stringify([
    state.sceneFile.value, state.viewSize.value, state.camera.value, state.overrides.value,
    state.channel.value, state.tone.value, state.hidden.value, state.solo.value,
  ]);
}

export function watchFrames(): void {
  effect(() => {
    const now = currentLook();
    const newest = state.summary.value?.revision;
    if (now === look && newest === read) return;
    if (now !== look) frames = new Map();
    look = now;
    read = newest;
    askAnew();
  });
}

/** Whether the frames are right is to be asked: the text is another, or the program, which does not know what it was asked for. */
export function askAnew(): void {
  ++generation;
  pane.forget();
  shown.value = undefined;
  revision.value = revision.peek() + 1;
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
      const digest = known === "none" ? frames.get(frame)?.digest : undefined;
      pane.ask({ frame, scale }, {
        file, size, frame, camera: state.camera.peek(), mode: "typing",
        overrides: state.overrides.peek(), channel: state.channel.peek(), tone: state.tone.peek(),
        hidden: state.hidden.peek(), solo: state.solo.peek(),
        ...(digest === undefined ? {} : { known: digest }),
      }, read);
      return;
    }
  }
}

function settle({ frame, scale }: { frame: number; scale: number }, image: ImageData | null | undefined, digest?: string): void {
  if (image === undefined) frames.set(frame, { ...frames.get(frame)!, generation });
  else frames.set(frame, image ? { image, state: scale > 1 ? "coarse" : "whole", digest, generation } : { state: "failed", generation });
  revision.value = revision.peek() + 1;
  next();
}
