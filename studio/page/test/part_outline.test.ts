import assert from "node:assert/strict";
import { test } from "node:test";
import { eachRimPixel } from "../src/core/part_outline.js";

test("the rim of parts is what touches another part or the edge", () => {
  const parts = new Uint32Array([
    0, 0, 0, 0, 0, 0,
    0, 1, 1, 1, 2, 2,
    0, 1, 1, 1, 2, 2,
    0, 1, 1, 1, 2, 2,
    0, 0, 0, 0, 0, 0,
  ]);
  const rim = (...numbers: number[]) => {
    const marked: string[] = [];
    eachRimPixel({ width: 6, height: 5, parts }, new Set(numbers), (x, y) => marked.push(`${x}${y}`));
    return marked.join(" ");
  };
  assert.equal(rim(1), "11 21 31 12 32 13 23 33");
  assert.equal(rim(1, 2), "11 21 31 41 51 12 52 13 23 33 43 53", "two parts of one thing have one rim");
  assert.equal(rim(3), "");
});
