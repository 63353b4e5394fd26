import assert from "node:assert/strict";
import { test } from "node:test";
import { PartBands } from "../src/core/part_bands.js";
import type { PixelFrame } from "../src/core/pixel_frame.js";

function band(serial: number, y: number, height: number): PixelFrame {
  return {
    kind: 2, deflated: false, pane: 0, scale: 1, serial, x: 0, y, width: 2, height, pictureWidth: 2,
    pictureHeight: 3, version: 1, samples: 1, endsPass: false, lastPass: false, body: new Uint8Array(0),
  };
}

const bytes = (...numbers: number[]): Uint8Array => new Uint8Array(new Uint32Array(numbers).buffer);

test("a part picture is put together of its bands", () => {
  const bands = new PartBands().add(band(7, 0, 2), bytes(1, 2, 3, 4)).add(band(7, 2, 1), bytes(5, 6));
  assert.deepEqual([...bands.parts], [1, 2, 3, 4, 5, 6]);
  assert.deepEqual([bands.serial, bands.width, bands.height], [7, 2, 3]);
  assert.deepEqual([...bands.add(band(8, 2, 1), bytes(9, 9)).parts], [0, 0, 0, 0, 9, 9]);
});
