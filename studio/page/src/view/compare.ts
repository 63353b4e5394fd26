// A pinned picture held against the one that is shown: in its place, beside it along a line, or as their difference.

import { effect, signal } from "@preact/signals";
import type { ToPage, ToProgram } from "../core/protocol.js";
import * as program from "../program.js";
import * as state from "../state.js";

export type CompareMode = "off" | "pinned" | "wipe" | "difference";

/** The size of the pinned picture; nothing: none is. */
export const pinned = signal<[number, number] | undefined>(undefined);
export const mode = signal<CompareMode>("off");
/** Where the line is, by the share of the frame's width that is left of it, where the pinned one is. */
export const wipe = signal(0.5);
export const numbers = signal<ToPage["compared"] | undefined>(undefined);

const AGAIN_MS = 100;
const PANE = state.main;
/** What is to be shown of a picture that is about to be pinned. */
let next: CompareMode = "off";
let isAsking = false;

export function pin(what: ToProgram["pin"]["what"], show = mode.peek()): void {
  next = show;
  program.send("pin", { pane: PANE.number, what });
}

/** Shows it so, or as it was where it is shown so already. */
export function toggle(wanted: CompareMode): void {
  if (pinned.peek() === undefined) state.notify("Pin a picture first (C).");
  else mode.value = mode.peek() === wanted ? "off" : wanted;
}

/** Holds the picture against the one of the scene as it was before the last change. */
export function compareWithBefore(): void {
  pin("before", "wipe");
}

export function moveWipe(share: number): void {
  wipe.value = Math.min(1, Math.max(0, share));
}

export function pinnedCame(message: ToPage["pinned"]): void {
  pinned.value = message.size;
  numbers.value = undefined;
  mode.value = message.size ? next : "off";
}

/** Pictures are pinned for as long as a connection lasts. */
export function forget(): void {
  pinned.value = undefined;
  numbers.value = undefined;
  mode.value = "off";
  isAsking = false;
}

function ask(): void {
  if (!isAsking) isAsking = program.send("compare", { pane: PANE.number });
}

export function comparedCame(message: ToPage["compared"]): void {
  isAsking = false;
  if (pinned.peek() === undefined) return;
  numbers.value = message;
  const isOld = message.serial !== undefined && message.serial !== PANE.painted.peek()?.serial && PANE.painted.peek()?.endsPass;
  // A picture that there was no room for is asked for again.
  if (isOld || message.drawn === false) setTimeout(askWhereSeen, AGAIN_MS);
}

function askWhereSeen(): void {
  if (mode.peek() === "difference") ask();
}

/** The difference follows the passes of the picture. */
export function watchComparison(): void {
  effect(() => {
    const painted = PANE.painted.value;
    if (mode.value === "difference" && pinned.value && painted?.endsPass) ask();
  });
}
