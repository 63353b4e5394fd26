// Small pictures of samples, which the program makes one after another, once they are first seen.

import { effect, signal } from "@preact/signals";
import * as program from "../program.js";
import * as state from "../state.js";
import { HiddenPane } from "./hidden_pane.js";

export const SIZE: [width: number, height: number] = [160, 90];
const SAMPLES = 4;

/** By the names of the samples; null: the program could make none. */
export const pictures = signal<ReadonlyMap<string, ImageData | null>>(new Map());

let waiting: string[] = [];
export const pane = new HiddenPane<string>(state.PANES_ASIDE.samples, settle);

/** Has the picture made, unless it is there or under way. */
export function want(name: string): void {
  if (pictures.peek().has(name) || pane.asked === name || waiting.includes(name)) return;
  waiting.push(name);
  next();
}

/** Nobody looks any more: what waits is forgotten. */
export function stop(): void {
  waiting = [];
  if (pane.asked !== undefined) program.send("close_view", { pane: state.PANES_ASIDE.samples });
  pane.forget();
}

/** A program that is connected anew knows nothing of what was asked for. */
export function watchSmallPictures(): void {
  effect(() => {
    if (state.connection.value !== "open") {
      if (pane.asked !== undefined) waiting.unshift(pane.asked);
      pane.forget();
    } else next();
  });
}

function next(): void {
  const name = waiting[0];
  if (pane.asked !== undefined || name === undefined) return;
  const isAsked = pane.ask(name, {
    file: name, sample: true, size: SIZE, camera: null, frame: 0, mode: "typing",
    overrides: { spp: SAMPLES }, channel: "light", tone: null,
  });
  if (isAsked) waiting.shift();
}

function settle(name: string, image: ImageData | null = null): void {
  pictures.value = new Map(pictures.peek()).set(name, image);
  if (waiting.length === 0) program.send("close_view", { pane: state.PANES_ASIDE.samples });
  next();
}
