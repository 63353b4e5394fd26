// The picture that a pane shows: what was painted of it, at full size, in the bytes that were sent.

import type { PixelFrame } from "./pixel_frame.js";

export interface Rectangle {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** One pane's pixels. Coarse tiles fill squares; a picture of another size begins as the old one, scaled. */
export class Picture {
  width = 0;
  height = 0;
  pixels = new Uint8ClampedArray(0);
  serial = -1;
  version = 0;
  scale = 0;
  samples = 0;
  /** Whether all of the last pass has been painted. */
  complete = false;

  /** Gives the picture another size, with the old one scaled as what is seen meanwhile. */
  resize(width: number, height: number): void {
    if (width === this.width && height === this.height) return;
    const scaled = new Uint8ClampedArray(width * height * 4);
    if (this.width > 0 && this.height > 0) {
      const source = new Uint32Array(this.pixels.buffer);
      const target = new Uint32Array(scaled.buffer);
      for (let y = 0; y < height; ++y) {
        const row = Math.floor((y * this.height) / height) * this.width;
        for (let x = 0; x < width; ++x) {
          target[y * width + x] = source[row + Math.floor((x * this.width) / width)]!;
        }
      }
    }
    this.pixels = scaled;
    this.width = width;
    this.height = height;
  }

  /** Whether pixels of this serial may still be painted. */
  wants(serial: number): boolean {
    return serial >= this.serial;
  }

  /**
   * Paints one frame, whose rows are `rows`, into a picture of the pane's size; answers what has changed, and nothing
   * where the frame is of a picture that another has already replaced or is short of bytes.
   */
  paint(frame: PixelFrame, rows: Uint8Array, paneWidth: number, paneHeight: number): Rectangle | undefined {
    if (!this.wants(frame.serial) || rows.length < frame.width * frame.height * 4) return undefined;
    const { scale } = frame;
    const [width, height] =
      Math.ceil(paneWidth / scale) === frame.pictureWidth && Math.ceil(paneHeight / scale) === frame.pictureHeight
        ? [paneWidth, paneHeight]
        : [frame.pictureWidth * scale, frame.pictureHeight * scale];
    const sameSize = width === this.width && height === this.height;
    this.resize(width, height);
    this.serial = frame.serial;
    this.version = frame.version;
    this.scale = scale;
    this.samples = frame.samples;
    this.complete = frame.lastPass && frame.endsPass;
    const changed = this.fill(frame, rows);
    return sameSize ? changed : { x: 0, y: 0, width, height };
  }

  private fill(frame: PixelFrame, rows: Uint8Array): Rectangle {
    const { scale } = frame;
    const left = frame.x * scale;
    const top = frame.y * scale;
    const right = Math.min(this.width, (frame.x + frame.width) * scale);
    const bottom = Math.min(this.height, (frame.y + frame.height) * scale);
    if (scale === 1) {
      for (let y = 0; y < bottom - top; ++y) {
        const row = rows.subarray(y * frame.width * 4, (y * frame.width + right - left) * 4);
        this.pixels.set(row, ((top + y) * this.width + left) * 4);
      }
    } else {
      // Rows may begin at any byte, which no array of words can.
      const source = new Uint32Array(rows.slice(0, frame.width * frame.height * 4).buffer);
      const target = new Uint32Array(this.pixels.buffer);
      for (let y = top; y < bottom; ++y) {
        const from = Math.floor((y - top) / scale) * frame.width;
        const to = y * this.width;
        if ((y - top) % scale !== 0) {
          target.copyWithin(to + left, to - this.width + left, to - this.width + right);
          continue;
        }
        for (let x = left; x < right; ++x) target[to + x] = source[from + Math.floor((x - left) / scale)]!;
      }
    }
    return { x: left, y: top, width: right - left, height: bottom - top };
  }

  /** Forgets which serial was last, as another run of the program counts anew. */
  restart(): void {
    this.serial = -1;
  }
}
