// The pointer over the graphs: all of them tell their value there.

import { signal } from "@preact/signals";

/** Where it is, as a share of their width. */
export const hover = signal<number | undefined>(undefined);

/** The properties of what is drawn over time. */
export const followsPointer = {
  onPointerMove(event: PointerEvent): void {
    const box = (event.currentTarget as Element).getBoundingClientRect();
    hover.value = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
  },
  onPointerLeave(): void {
    hover.value = undefined;
  },
};
