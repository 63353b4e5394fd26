// The full picture that is looked at in the page, also while it is being traced.

import { signal } from "@preact/signals";
import type { RenderReport } from "./core/protocol.js";
import * as program from "./program.js";
import { notifyRefusal, orderExport } from "./renders.js";
import * as state from "./state.js";

/** Whose picture it is; undefined: none is looked at. */
export const job = signal<RenderReport["job"] | undefined>(undefined);
export const image = signal<ImageBitmap | undefined>(undefined);

/** How much of it was asked for last. */
let asked = "";
let isWaiting = false;

export function lookAt(number: RenderReport["job"]): void {
  job.value = number;
  image.value = undefined;
  asked = "";
  ask();
}

export function close(): void {
  job.value = undefined;
  image.value = undefined;
}

export function report(): RenderReport | undefined {
  return state.renders.value.find((each) => each.job === job.value);
}

/** Asks for the picture where more of it is there than what was asked for. */
export function ask(): void {
  const of = state.renders.peek().find((each) => each.job === job.peek());
  if (!of || isWaiting || !program.isConnected()) return;
  const much = `${of.job} ${of.frames_done ?? 0} ${of.has_picture ? "whole" : of.tiles_done ?? 0}`;
  if (much === asked || !(of.has_picture || of.tiles_done)) return;
  asked = much;
  isWaiting = true;
  orderExport({ job: of.job, name: "picture.png", download: true, show: true }, (why) => {
    if (why !== undefined) failed();
    notifyRefusal(why);
  });
}

export async function came(file: Blob): Promise<void> {
  isWaiting = false;
  if (job.peek() === undefined) return;
  image.value = await createImageBitmap(file);
  ask();
}

/** What was asked for does not come. */
export function failed(): void {
  isWaiting = false;
}
