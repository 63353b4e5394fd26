import assert from "node:assert/strict";
import { test } from "node:test";
import * as measures from "../src/measures.js";
import { rowsOf, WINDOW_MS } from "../src/panels/graphs_table.js";
import * as state from "../src/state.js";

test("no row has what is older than its table says", () => {
  const now = Date.now();
  const points = [{ at: now - WINDOW_MS - 1000, value: 9 }, { at: now, value: 1 }];
  measures.latencies.push(...points);
  state.metrics.value = points.map(({ at, value }) => ({ at, values: { memory: value } }));
  state.workerUse.value = new Map([["local-1", points]]);
  assert.deepEqual(rowsOf(["memory"]).map(({ title, values }) => [title, values]), [
    ["Key to pixels", [1]],
    ["Memory of program and workers", [1]],
    ["Use of local-1", [1]],
  ]);
});
