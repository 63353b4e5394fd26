import assert from "node:assert/strict";
import { test } from "node:test";
import { WORKER_COLOURS, WorkerMarks } from "../src/core/worker_colours.js";

test("a worker keeps its number and colour, and no other has both", () => {
  const marks = new WorkerMarks();
  const first = marks.of(7);
  const others = Array.from({ length: 20 }, (_, index) => marks.of(100 + index));
  assert.deepEqual(first, { number: 1, colour: WORKER_COLOURS[0] });
  assert.deepEqual(marks.of(7), first);
  assert.equal(new Set([first, ...others].map((each) => each.number)).size, 21);
  assert.equal(new Set([first, ...others.slice(0, 7)].map((each) => each.colour)).size, 8);
});
