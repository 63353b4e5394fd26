// The animation that is played in the view.

import { effect, signal } from "@preact/signals";
import * as state from "../state.js";
import * as frames from "./frames.js";

export const first = signal(0);
export const last = signal(47);
export const perSecond = signal(24);
export const playing = signal(false);
export const looping = signal(true);

/** Takes over what the scene says of its animation, whenever that changes, and plays it, whichever panel is seen. */
export function watchAnimation(): void {
  effect(play);
  let known = "";
  effect(() => {
    const said = state.summary.value?.animation;
    const text = JSON.stringify([state.summary.value?.file, said]);
    if (!said || text === known) return;
    known = text;
    first.value = said.first;
    last.value = Math.max(said.first, said.last);
    if (said.per_second) perSecond.value = said.per_second;
  });
}

/** The frame that is played, which the view itself shows once playing ends or no picture of it is there. */
export const at = signal(0);

export function step(by: number): void {
  let next = Math.max(first.peek(), at.peek() + by);
  if (next > last.peek()) {
    const length = last.peek() - first.peek() + 1;
    if (!looping.peek()) playing.value = false;
    next = looping.peek() ? first.peek() + ((next - first.peek()) % length) : last.peek();
  }
  show(next);
}

export function show(frame: number): void {
  at.value = frame;
  const image = playing.peek() ? frames.imageOf(frame) : undefined;
  frames.shown.value = image;
  if (!image) state.frame.value = frame;
}

export function playOrPause(): void {
  playing.value = !playing.peek();
  if (playing.peek()) at.value = state.frame.peek();
  else show(at.peek());
}

/** Plays in the right time: frames that cannot be shown are left out. */
function play(): (() => void) | undefined {
  if (!playing.value) return undefined;
  const rate = perSecond.value;
  const began = performance.now();
  let told = 0;
  const timer = setInterval(() => {
    const due = Math.floor(((performance.now() - began) * rate) / 1000);
    if (due > told) step(due - told);
    told = due;
  }, 1000 / rate / 2);
  return () => clearInterval(timer);
}
