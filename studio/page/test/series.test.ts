import assert from "node:assert/strict";
import { test } from "node:test";
import { nearest } from "../src/core/series.js";

test("the value that is told is the one next to the pointer", () => {
  const points = [0, 10, 20].map((at) => ({ at, value: at + 1 }));
  assert.equal(nearest(points, -5)?.value, 1);
  assert.equal(nearest(points, 14)?.value, 11);
  assert.equal(nearest(points, 16)?.value, 21);
  assert.equal(nearest([], 3), undefined);
});
