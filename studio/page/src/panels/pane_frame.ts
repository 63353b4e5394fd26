// The elements that a pane's picture is in, made once: the worker owns the canvas from then on.

import { effect } from "@preact/signals";
import { runInView } from "../commands.js";
import { pictureAt, transformOf } from "../core/zoom.js";
import * as program from "../program.js";
import * as state from "../state.js";
import { main, type Pane } from "../state.js";
import * as compare from "../view/compare.js";
import { crossHairKey, pixelOf, watchPointer } from "../view/navigation.js";
import { drawOutlines } from "../view/parts.js";
import { drawWorkerTiles } from "../view/worker_tiles.js";
import type { Layer } from "../worker/messages.js";

const KEYS = "Arrows orbit, W A S D Q E move, plus and minus dolly, Home is the scene's camera, Z enlarges. Enter shows a cross-hair, which arrows move, Enter picks with and X makes the pivot. Alt, Shift and arrows look around.";
const SIDE_KEYS = "Arrows move it, plus and minus enlarge what is seen, 1 2 3 are top, front and side, Home shows all. Enter shows a cross-hair, which arrows move and Enter picks with.";
const frames = new Map<Pane, HTMLElement>();

function layer(sheet: HTMLElement, name: string): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.className = name;
  sheet.appendChild(canvas);
  return canvas;
}

/** A canvas that the worker paints. */
function painted(sheet: HTMLElement, pane: Pane, name: Layer, label: string): HTMLCanvasElement {
  const canvas = layer(sheet, name);
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", label);
  const offscreen = canvas.transferControlToOffscreen();
  program.toWorker({ kind: "canvas", pane: pane.number, layer: name, canvas: offscreen }, [offscreen]);
  return canvas;
}

/** The layers of the comparison, which are seen as its mode says. */
function addComparison(sheet: HTMLElement, pane: Pane): void {
  const pinned = painted(sheet, pane, "pinned", "Pinned picture");
  const difference = painted(sheet, pane, "difference", "Difference from the pinned picture");
  effect(() => {
    const { value: mode } = compare.mode;
    pinned.hidden = mode !== "pinned" && mode !== "wipe";
    difference.hidden = mode !== "difference";
    const [share] = pictureAt(pane.shown.value, compare.wipe.value, 0);
    pinned.style.clipPath = mode === "wipe" ? `inset(0 ${(1 - share) * 100}% 0 0)` : "";
  });
}

/** A pixel of a pane. */
export interface Spot {
  pane: Pane;
  pixel: [number, number];
}

/** The pixel that an event is over; nothing beside all pictures. */
export function spotAt(event: MouseEvent): Spot | undefined {
  const over = document.elementFromPoint(event.clientX, event.clientY);
  for (const [pane, frame] of frames) {
    if (over && frame.contains(over)) return { pane, pixel: pixelOf(pane, frame.querySelector<HTMLElement>(".view-sheet")!, event) };
  }
  return undefined;
}

export function paneFrame(pane: Pane): HTMLElement {
  const known = frames.get(pane);
  if (known) return known;
  const frame = document.createElement("div");
  frames.set(pane, frame);
  frame.className = "view-frame";
  frame.tabIndex = 0;
  frame.setAttribute("role", "application");
  frame.setAttribute("aria-label", pane === main ? `Picture. ${KEYS}` : `Picture. ${SIDE_KEYS}`);
  const sheet = document.createElement("div");
  sheet.className = "view-sheet";
  frame.appendChild(sheet);
  painted(sheet, pane, "rendered", "Rendered picture").setAttribute("aria-describedby", "view-words");
  if (pane === main) addComparison(sheet, pane);
  const outlines = layer(sheet, "outlines");
  outlines.setAttribute("aria-hidden", "true");
  drawOutlines(pane, outlines);
  const tiles = layer(sheet, "tiles");
  tiles.setAttribute("aria-hidden", "true");
  drawWorkerTiles(pane, tiles);
  effect(() => {
    sheet.style.transform = transformOf(pane.shown.value);
  });
  watchPointer(pane, { frame, sheet });
  frame.addEventListener("keydown", (event) => {
    // A pointer that rests over another pane does not take its keys.
    state.activePane.value = pane;
    if (crossHairKey(pane, event) || runInView(event)) event.preventDefault();
  });
  return frame;
}
