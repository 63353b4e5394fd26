// Performance measures of the page, which benchmarks read: from a key to its glyph, to pixels, to the last pass.

import type { Painted } from "./worker/messages.js";

/** When which version came to be, of the last edits of each file. */
const keys = new Map<string, { version: number; at: number }[]>();
const MOST_KEYS = 200;
const MOST_MEASURES = 2000;
let lastFinal = -1;
let lastSerial = -1;
/** Milliseconds from a key to the first pixels that show it, and when those came, the newest last. */
export const latencies: { at: number; value: number }[] = [];

export function typed(file: string, version: number): void {
  const at = performance.now();
  const list = keys.get(file) ?? [];
  if (list[list.length - 1]?.version !== version) list.push({ version, at });
  if (list.length > MOST_KEYS) list.shift();
  keys.set(file, list);
  requestAnimationFrame(() => {
    const channel = new MessageChannel();
    // A message of its own runs after the frame was drawn.
    channel.port1.onmessage = () => measure("studio:key", at, { version, serial: lastSerial, scale: 0 });
    channel.port2.postMessage(0);
  });
}

export function shown(file: string | undefined, painted: Painted): void {
  const key = file === undefined ? undefined : keyOf(file, painted.version);
  const detail = { version: painted.version, serial: painted.serial, scale: painted.scale };
  if (painted.serial !== lastSerial) {
    lastSerial = painted.serial;
    if (key && !key.seen) {
      key.seen = true;
      measure("studio:pixels", key.at, detail);
      latencies.push({ at: Date.now(), value: performance.now() - key.at });
      if (latencies.length > 600) latencies.shift();
    }
  }
  if (painted.complete && painted.serial !== lastFinal) {
    lastFinal = painted.serial;
    if (key) measure("studio:final", key.at, detail);
  }
}

function keyOf(file: string, version: number): { at: number; seen?: boolean } | undefined {
  return keys.get(file)?.find((each) => each.version === version);
}

/** How many measures of each name there are. */
const counts = new Map<string, number>();

function measure(name: string, start: number, detail: object): void {
  const count = (counts.get(name) ?? 0) + 1;
  if (count > MOST_MEASURES) performance.clearMeasures(name);
  counts.set(name, count > MOST_MEASURES ? 1 : count);
  performance.measure(name, { start, end: performance.now(), detail });
}
