import assert from "node:assert/strict";
import { test } from "node:test";
import { keptWorkspace } from "../src/core/workspace.js";

const camera = { eye: [0, 1, 5], target: [0, 0, 0], up: [0, 1, 0], fov: 40 };

test("what was kept comes back", () => {
  const kept = {
    open: ["a.crt", "b.tessera"],
    active: "b.tessera",
    scene: "a.crt",
    selections: { "a.crt": [4, 0] },
    views: { "a.crt": { cameras: [camera, null, { name: "side" }], pivot: [1, 2, 3] } },
  };
  assert.deepEqual(keptWorkspace(kept), kept);
});

test("what makes no sense is left out", () => {
  const nothing = { open: [], selections: {}, views: {} };
  for (const wrong of [undefined, null, 1, "open", [], { open: "a", selections: [], views: 1 }, { open: [1, null], active: 1 }]) {
    assert.deepEqual(keptWorkspace(wrong), nothing);
  }
  assert.deepEqual(keptWorkspace({ open: ["a", "a"], active: "b", scene: "b" }), { ...nothing, open: ["a"] });
  const selections = { a: [1], b: [-1, 0], c: [0.5, 1], d: "x", e: [0, 7] };
  assert.deepEqual(keptWorkspace({ selections }).selections, { e: [0, 7] });
  const cameras = [{ ...camera, fov: 180 }, { ...camera, eye: [0, 1] }, { ...camera, up: [0, null, 0] }, { name: 1 }, 5, camera];
  assert.deepEqual(keptWorkspace({ views: { a: { cameras, pivot: "x" }, b: {} } }).views, { a: { cameras: [null, null, null, null, null, camera] } });
});
