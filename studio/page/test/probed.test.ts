import assert from "node:assert/strict";
import { test } from "node:test";
import { hexOf, probedNumber, probedRows } from "../src/core/probed.js";

test("channels are gathered in their layers", () => {
  const rows = probedRows(["R", "G", "B", "albedo.R", "albedo.G", "albedo.B", "N.X", "Z", "id"], [1, 2, 3, 4, 5, 6, 7, 8, 9]);
  assert.deepEqual(rows, [
    { name: "light", values: [1, 2, 3] },
    { name: "albedo", values: [4, 5, 6] },
    { name: "normal", values: [7] },
    { name: "depth", values: [8] },
    { name: "id", values: [9] },
  ]);
});

test("numbers are short, and what is none is said", () => {
  assert.deepEqual([0.123456, 12345678, 0, NaN, Infinity].map(probedNumber), ["0.12346", "12346000", "0", "NaN", "Infinity"]);
  assert.equal(hexOf([0, 10, 255]), "#000aff");
});
