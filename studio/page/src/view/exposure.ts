import { MOST_STOPS } from "../core/looks.js";
import * as state from "../state.js";

/** Brightens what is seen by so many stops, or darkens it. */
export function expose(stops: number): void {
  const tone = state.tone.peek() ?? {};
  state.tone.value = { ...tone, exposure: Math.min(MOST_STOPS, Math.max(-MOST_STOPS, (tone.exposure ?? 0) + stops)) };
}
