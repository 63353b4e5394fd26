import assert from "node:assert/strict";
import { test } from "node:test";
import { frameAt, panned, pictureAt, showing, transformOf, WHOLE, zoomed } from "../src/core/zoom.js";

test("what is under the pointer stays there", () => {
  const before = zoomed(WHOLE, 3, 0.4, 0.6);
  const after = zoomed(before, 2, 0.7, 0.2);
  assert.deepEqual([before.factor, after.factor], [4, 8]);
  const [old, now] = [pictureAt(before, 0.7, 0.2), pictureAt(after, 0.7, 0.2)];
  for (const side of [0, 1]) assert.ok(Math.abs(old[side]! - now[side]!) < 1e-12);
  const [right, down] = frameAt(after, ...now);
  assert.ok(Math.abs(right - 0.7) < 1e-12 && Math.abs(down - 0.2) < 1e-12);
});

test("it ends at 1:1, where all of the picture is seen, and at 64", () => {
  assert.deepEqual(zoomed(WHOLE, -5, 0.1, 0.9), WHOLE);
  assert.equal(zoomed(WHOLE, 100).factor, 64);
  assert.deepEqual(zoomed(zoomed(WHOLE, 100, 0, 0), -100), WHOLE);
});

test("no side of the frame is left empty", () => {
  const corner = panned(zoomed(WHOLE, 3), 100, -100);
  assert.deepEqual(pictureAt(corner, 0, 1), [0, 1]);
  assert.deepEqual(panned(WHOLE, 3, 3), WHOLE);
});

test("a point that is not seen is brought into the frame, and no further", () => {
  const corner = zoomed(WHOLE, 3, 0, 0);
  assert.deepEqual(showing(corner, 0.1, 0.1), corner);
  assert.equal(frameAt(showing(corner, 0.5, 0.1), 0.5, 0.1)[0], 1);
});

test("the sheet is moved and enlarged from its corner", () => {
  assert.equal(transformOf(WHOLE), "translate(0%, 0%) scale(1)");
  assert.equal(transformOf(zoomed(WHOLE, 1)), "translate(-50%, -50%) scale(2)");
});
