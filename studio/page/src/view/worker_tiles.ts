// Tiles that ended, outlined by the workers that traced them while their pass goes on.

import { effect, signal } from "@preact/signals";
import type { ToPage, WorkerTile } from "../core/protocol.js";
import { WorkerMarks } from "../core/worker_colours.js";
import * as state from "../state.js";

/** How long the outlines of a pass are seen once nothing is traced. */
const AFTER_PASS_MS = 600;
/** A narrower tile does not show the number of its worker. */
const LEAST_WIDTH_OF_NUMBER = 14;

export const showsWorkerTiles = signal(false);
export const workerMarks = new WorkerMarks();

export interface PaneTiles {
  serial: number;
  scale: number;
  list: readonly WorkerTile[];
}

const tilesOf = state.panes.map(() => signal<PaneTiles | undefined>(undefined));

export function toggleWorkerTiles(): void {
  showsWorkerTiles.value = !showsWorkerTiles.peek();
}

export function workerTilesCame({ pane, serial, scale, list }: ToPage["tiles"]): void {
  const tiles = tilesOf[pane];
  if (!tiles || !showsWorkerTiles.peek()) return;
  const before = tiles.peek();
  if (before && before.serial > serial) return;
  tiles.value = { serial, scale, list: before?.serial === serial ? [...before.list, ...list] : list };
}

/** The tiles of the pass that is traced, or just was. */
export function workerTiles(pane: state.Pane): PaneTiles | undefined {
  return tilesOf[pane.number]!.value;
}

/** Takes the outlines away when they are not wanted any more, and when nothing has been traced for a while. */
export function watchWorkerTiles(): void {
  for (const pane of state.panes) {
    const tiles = tilesOf[pane.number]!;
    let due: ReturnType<typeof setTimeout> | undefined;
    effect(() => {
      const job = pane.job.value;
      clearTimeout(due);
      if (!showsWorkerTiles.value || !job) tiles.value = undefined;
      else if (job.state !== "tracing") due = setTimeout(() => (tiles.value = undefined), AFTER_PASS_MS);
    });
  }
}

/** Draws the outline of each tile, and its worker's number in it. */
export function drawWorkerTiles(pane: state.Pane, canvas: HTMLCanvasElement): void {
  effect(() => {
    const [width, height] = pane.size.value;
    const tiles = workerTiles(pane);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, width, height);
    if (!tiles) return;
    context.font = "bold 9px sans-serif";
    context.textBaseline = "top";
    for (const [x, y, w, h, worker] of tiles.list) {
      const [left, top, across, down] = [x, y, w, h].map((each) => each * tiles.scale) as [number, number, number, number];
      const { number, colour } = workerMarks.of(worker);
      for (const [stroke, line] of [["rgb(0 0 0 / 60%)", 3], [colour, 1]] as const) {
        context.strokeStyle = stroke;
        context.lineWidth = line;
        context.strokeRect(left + 1.5, top + 1.5, across - 3, down - 3);
      }
      if (across < LEAST_WIDTH_OF_NUMBER || down < LEAST_WIDTH_OF_NUMBER) continue;
      context.strokeStyle = "black";
      context.lineWidth = 3;
      context.strokeText(String(number), left + 4, top + 4);
      context.fillStyle = colour;
      context.fillText(String(number), left + 4, top + 4);
    }
  });
}
