// The picture so far; over it the tiles that are being traced, or what each tile took.
import { duration, workerColor } from "./format.js";

const RAMP = [[44, 63, 115], [47, 127, 134], [127, 179, 106], [240, 210, 100], [226, 112, 58]];
const PENDING = 0, ASSIGNED = 1, DONE = 2, GIVEN_UP = 3;

function rampColor(share) {
  const at = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1);
  const low = Math.min(Math.floor(at), RAMP.length - 2);
  const mixed = RAMP[low].map((value, i) => Math.round(value + (RAMP[low + 1][i] - value) * (at - low)));
  return `rgb(${mixed.join(" ")} / .82)`;
}

export class Picture {
  constructor(element) {
    this.element = element;
    this.film = element.querySelector("#film");
    this.overlay = element.querySelector("#tiles");
    this.note = element.querySelector("#tile-note");
    this.clear();
    new ResizeObserver(() => this.draw()).observe(element);
    element.addEventListener("pointermove", (event) => this.tell(event));
    element.addEventListener("pointerleave", () => { this.note.hidden = true; });
  }

  clear(width = 16, height = 9) {
    this.rect = null;
    this.tiles = [];
    this.workers = [];
    this.names = new Map();
    this.film.width = this.film.height = 1;
    this.fit(width, height);
    this.draw();
  }

  fit(width, height) {
    this.element.style.aspectRatio = `${width} / ${height}`;
    this.element.style.maxWidth = `calc(74vh * ${width / height})`;
  }

  showBitmap(bitmap) {
    this.film.width = bitmap.width;
    this.film.height = bitmap.height;
    this.film.getContext("2d").drawImage(bitmap, 0, 0);
  }

  /// `tiles`: the answer of /tiles. Of a frame that has ended there are none: those seen last stay.
  showTiles(tiles) {
    if (tiles.preview) this.rect = tiles.preview.rect;
    if (tiles.tiles.length > 0) {
      this.tiles = tiles.tiles;
      this.workers = tiles.workers;
      this.live = true;
    } else {
      this.live = false;
    }
    if (!this.rect && this.tiles.length > 0) this.rect = boundsOf(this.tiles);
    this.draw();
  }

  /// { least, most } seconds of the tiles that are done, or null.
  costs() {
    const seconds = this.tiles.filter((tile) => tile[4] === DONE && tile[6] > 0).map((tile) => tile[6]);
    return seconds.length ? { least: Math.min(...seconds), most: Math.max(...seconds) } : null;
  }

  draw() {
    const scale = window.devicePixelRatio || 1;
    const width = Math.round(this.element.clientWidth * scale), height = Math.round(this.element.clientHeight * scale);
    if (this.overlay.width !== width || this.overlay.height !== height) {
      this.overlay.width = width;
      this.overlay.height = height;
    }
    const pen = this.overlay.getContext("2d");
    pen.clearRect(0, 0, width, height);
    if (!this.rect || this.tiles.length === 0) return;
    const ground = getComputedStyle(this.element).backgroundColor;
    const costs = this.showCost ? this.costs() : null;
    const line = Math.max(1, Math.round(1.5 * scale));
    for (const tile of this.tiles) {
      const [x, y, w, h] = this.place(tile, width, height);
      const state = tile[4];
      if (this.live && !tile[8]) {
        pen.fillStyle = ground;
        pen.fillRect(x, y, w, h);
      }
      if (costs && state === DONE && tile[6] > 0) {
        const span = Math.log(costs.most / costs.least) || 1;
        pen.fillStyle = rampColor(Math.log(tile[6] / costs.least) / span);
        pen.fillRect(x, y, w, h);
      }
    }
    if (!this.live || !this.showInFlight) return;
    for (const tile of this.tiles) {
      if (tile[7] === 0 && tile[4] !== GIVEN_UP) continue;
      const [x, y, w, h] = this.place(tile, width, height);
      const color = tile[4] === GIVEN_UP ? "#b03a2e" : workerColor(this.workers[tile[5]] ?? "");
      pen.strokeStyle = pen.fillStyle = color;
      pen.globalAlpha = 0.16;
      if (tile[4] !== DONE) pen.fillRect(x, y, w, h);
      pen.globalAlpha = 1;
      pen.lineWidth = line;
      pen.strokeRect(x + line / 2, y + line / 2, w - line, h - line);
    }
  }

  /// In pixels of the overlay, its edges shared with the neighbours'.
  place(tile, width, height) {
    const [x0, y0, x1, y1] = this.rect;
    const across = (x) => Math.round((x - x0) / (x1 - x0) * width);
    const down = (y) => Math.round((y - y0) / (y1 - y0) * height);
    const left = across(tile[0]), top = down(tile[1]);
    return [left, top, across(tile[2]) - left, down(tile[3]) - top];
  }

  tell(event) {
    if (!this.rect || this.tiles.length === 0) return;
    const box = this.element.getBoundingClientRect();
    const [x0, y0, x1, y1] = this.rect;
    const x = x0 + (event.clientX - box.left) / box.width * (x1 - x0);
    const y = y0 + (event.clientY - box.top) / box.height * (y1 - y0);
    const tile = this.tiles.find((t) => t[0] <= x && x < t[2] && t[1] <= y && y < t[3]);
    this.note.hidden = !tile;
    if (!tile) return;
    const by = this.names.get(this.workers[tile[5]]) ?? (tile[4] === DONE ? "kept from an earlier run" : "");
    const what = ["waiting", "being traced", "done", "given up"][tile[4]];
    this.note.textContent = [`${Math.floor(x)}, ${Math.floor(y)}`, what, by, tile[6] > 0 ? duration(tile[6]) : ""]
      .filter(Boolean).join(" · ");
  }
}

function boundsOf(tiles) {
  return [Math.min(...tiles.map((t) => t[0])), Math.min(...tiles.map((t) => t[1])),
          Math.max(...tiles.map((t) => t[2])), Math.max(...tiles.map((t) => t[3]))];
}

/// The tiles of a frame that has ended, from its timeline.
export function tilesOfTrace(trace) {
  const rows = trace.traceEvents.filter((event) => event.cat === "tile")
    .map((event) => [...event.args.rect.split(",").map(Number), DONE, -1, event.dur / 1e6, 0, 1]);
  return { tiles: rows, workers: [], preview: null };
}
