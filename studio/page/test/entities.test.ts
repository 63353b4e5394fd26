import assert from "node:assert/strict";
import { test } from "node:test";
import { hexOf, linearOf } from "../src/core/colours.js";
import { entityAt, pathTo, rowsOf, timesOf } from "../src/core/entities.js";
import type { Entity } from "../src/core/protocol.js";
import { areaPath, linePath, quantile, roundedUp } from "../src/core/series.js";

function entity(id: number, parent: number | null, kind: string, from: number, to: number): Entity {
  return { id: String(id), parent: parent === null ? null : String(parent), kind, name: "", line: 1, column: 1, end_line: 1, end_column: 1, from, to };
}
const entities = [entity(0, null, "scene", 0, 100), entity(1, 0, "lights", 10, 40), entity(2, 1, "sun", 12, 20), entity(3, 0, "camera", 50, 60)];

test("a tree has the rows that are open", () => {
  const kinds = (closed: string[], search = "") => rowsOf(entities, new Set(closed), search).map((each) => `${each.level} ${each.entity.kind}`);
  assert.deepEqual(kinds([]), ["1 scene", "2 lights", "3 sun", "2 camera"]);
  assert.deepEqual(kinds(["1"]), ["1 scene", "2 lights", "2 camera"]);
  assert.deepEqual(kinds(["1"], "SUN"), ["1 scene", "2 lights", "3 sun"]);
  assert.deepEqual(kinds([], "nothing"), []);
});

test("a row tells how many stand in it", () => {
  const inside = (search: string) => rowsOf(entities, new Set(["1"]), search).map((each) => each.children);
  assert.deepEqual(inside(""), [2, 1, 0]);
  assert.deepEqual(inside("sun"), [1, 1, 0]);
});

test("parents that are not there, or are oneself, do not hide a row", () => {
  assert.equal(rowsOf([entity(1, 9, "a", 0, 1), entity(2, 2, "b", 1, 2)], new Set()).length, 2);
});

test("how many things a text makes is told of its parts too, and of macros", () => {
  const script = [entity(0, null, "scene", 0, 100), entity(1, 0, "macro", 10, 60), entity(2, 1, "shape", 12, 30), entity(3, 2, "step", 20, 25), entity(4, 1, "variable", 40, 50), entity(5, 0, "shape", 70, 80)];
  const made = new Map([["0", 0], ["2", 5], ["4", 0], ["5", 1]]);
  assert.deepEqual(script.map((each) => timesOf(script, each.id, (id) => made.get(id))), [1, 5, 5, 5, 5, 1]);
  assert.equal(timesOf(script, "2", () => 0), 1, "how many is not known");
});

test("ten thousand rows", () => {
  const many = Array.from({ length: 10_000 }, (_, index) => entity(index, index === 0 ? null : 0, "node", index, index + 1));
  assert.equal(rowsOf(many, new Set()).length, 10_000);
});

test("the cursor stands in the innermost", () => {
  assert.equal(entityAt(entities, 15, 15)?.kind, "sun");
  assert.equal(entityAt(entities, 15, 30)?.kind, "lights");
  assert.equal(entityAt(entities, 70, 70)?.kind, "scene");
  assert.equal(entityAt(entities, 200, 200), undefined);
  assert.deepEqual(pathTo(entities, "2").map((each) => each.kind), ["scene", "lights", "sun"]);
});

test("colours go to bytes and back", () => {
  assert.equal(hexOf([0, 0.2159, 1]), "#0080ff");
  assert.equal(hexOf([5, -1, 0.001]), "#ff0003");
  for (const hex of ["#000000", "#ffffff", "#123456", "#808080"]) assert.equal(hexOf(linearOf(hex)), hex);
});

test("graphs stay in their box", () => {
  assert.equal(linePath([{ at: 0, value: 0 }, { at: 10, value: 10 }], 0, 10, 10), "M0.00 39.00L100.00 1.00");
  assert.ok(areaPath([{ at: 0, value: 1 }], 0, 0, 1).endsWith("Z"));
  assert.deepEqual([0, 0.3, 1, 3, 70, 100].map(roundedUp), [1, 0.5, 1, 5, 100, 100]);
  assert.equal(quantile([5, 1, 3], 0.5), 3);
  assert.equal(quantile([], 0.5), 0);
});
