import "./socket_worker.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import type { Entity, Field } from "../src/core/protocol.js";
import * as state from "../src/state.js";
import { beginDrag, dragTo, endDrag } from "../src/view/turning.js";

const FILE = "a.tessera";
const background: Entity = { id: "background", parent: "scene", kind: "background", name: "", line: 1, column: 1, end_line: 1, end_column: 9, from: 0, to: 8 };
const words = () => state.notices.value.map((each) => each.text);

function know(...fields: Field[]): void {
  state.fields.value = { file: FILE, version: 1, entity: background.id, fields };
}

/** A drag over the picture, during which the program tells the fields of what is selected. */
function drag(...fields: Field[]): void {
  state.notices.value = [];
  state.fields.value = undefined;
  beginDrag(false);
  dragTo(state.main, { right: 4, down: 0, width: 200, height: 100 });
  know(...fields);
  for (const right of [8, 12]) dragTo(state.main, { right, down: 0, width: 200, height: 100 });
  endDrag();
}

test("a background that has no direction says so, once a drag", () => {
  state.activeFile.value = FILE;
  state.outlines.value = new Map([[FILE, { file: FILE, version: 1, entities: [background] }]]);
  const colour: Field = { name: "gradient.sky", kind: "color", text: "0 0 1", from: 0, to: 1 };
  drag(colour);
  assert.equal(state.selectedEntity.value, background.id);
  assert.deepEqual(words(), ["This background has no direction to turn: a colour or a gradient is the same all around."]);
  drag(colour);
  assert.equal(words().length, 1);
  drag({ name: "panorama.angle", kind: "number", text: "10", from: 0, to: 1 });
  assert.deepEqual(words(), []);
});
