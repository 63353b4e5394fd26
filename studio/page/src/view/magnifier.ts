// The picture enlarged on the screen, and the cross-hair that keys move over it. Nothing is rendered for these.

import { panned, scaledTo, showing, WHOLE, zoomed } from "../core/zoom.js";
import * as state from "../state.js";

/** Larger by some steps; what is seen at that point of the frame, by shares, stays there. */
export function zoom(pane: state.Pane, steps: number, at?: [number, number]): void {
  pane.zoom.value = zoomed(pane.zoom.peek(), pane.fit.peek(), steps, ...(at ?? []));
}

/** A pixel of the picture is a point of the screen. */
export function zoomToPixels(pane: state.Pane): void {
  pane.zoom.value = scaledTo(pane.zoom.peek(), pane.fit.peek(), 1);
}

export function zoomOut(pane: state.Pane): void {
  pane.zoom.value = WHOLE;
}

export function pan(pane: state.Pane, right: number, down: number): void {
  pane.zoom.value = panned(pane.zoom.peek(), pane.fit.peek(), right, down);
}

/** The cross-hair comes where the pointer was, or into the middle, and goes again. */
export function toggleCrossHair(pane = state.activePane.peek()): void {
  pane.hasCrossHair.value = !pane.hasCrossHair.peek();
  if (pane.hasCrossHair.peek()) moveCrossHair(pane, 0, 0);
}

export function moveCrossHair(pane: state.Pane, right: number, down: number): void {
  const [width, height] = pane.size.peek();
  const [x, y] = pane.pointer.peek() ?? [width >> 1, height >> 1];
  const at: [number, number] = [Math.min(width - 1, Math.max(0, x + right)), Math.min(height - 1, Math.max(0, y + down))];
  pane.pointer.value = at;
  pane.zoom.value = showing(pane.zoom.peek(), pane.fit.peek(), (at[0] + 0.5) / width, (at[1] + 0.5) / height);
}
