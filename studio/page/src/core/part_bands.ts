// A part picture, which may come in bands of rows.

import type { PixelFrame } from "./pixel_frame.js";

export class PartBands {
  serial = -1;
  width = 0;
  height = 0;
  parts = new Uint32Array(0);

  /** Takes a band; one of another picture begins that anew. */
  add(frame: PixelFrame, rows: Uint8Array): this {
    const { serial, pictureWidth: width, pictureHeight: height } = frame;
    if (serial !== this.serial || width !== this.width || height !== this.height) {
      this.parts = new Uint32Array(width * height);
      [this.serial, this.width, this.height] = [serial, width, height];
    }
    // Rows may begin at any byte, which no array of words can.
    const numbers = new Uint32Array(rows.slice(0, frame.width * frame.height * 4).buffer);
    for (let y = 0; y < frame.height; ++y) {
      const row = numbers.subarray(y * frame.width, (y + 1) * frame.width);
      this.parts.set(row, (frame.y + y) * width + frame.x);
    }
    return this;
  }
}
