// What lies under the pointer: asked for while it moves, seldom enough to be no burden, and when the picture changes.

import { effect, signal } from "@preact/signals";
import * as program from "../program.js";
import * as state from "../state.js";

const EVERY_MS = 80;

export const isProbing = signal(false);
let due: ReturnType<typeof setTimeout> | undefined;

export function watchProbe(): void {
  effect(() => {
    const pane = state.activePane.value;
    void pane.painted.value;
    if (!isProbing.value || !pane.pointer.value) return;
    due ??= setTimeout(() => {
      due = undefined;
      const { activePane } = state;
      const { number, pointer } = activePane.peek();
      const at = pointer.peek();
      if (at) program.send("probe", { pane: number, x: at[0], y: at[1] });
    }, EVERY_MS);
  });
}

export function toggleProbe(): void {
  isProbing.value = !isProbing.peek();
  if (!isProbing.peek()) state.probed.value = undefined;
}
