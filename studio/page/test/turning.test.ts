import assert from "node:assert/strict";
import { test } from "node:test";
import type { Field, FreeCamera } from "../src/core/protocol.js";
import { draggable, draggedText, movedPosition, turnedDirection, type PictureDrag } from "../src/core/turning.js";

const camera: FreeCamera = { eye: [0, 0, 5], target: [0, 0, 0], up: [0, 1, 0], fov: 60 };
const drag = (right: number, down: number): PictureDrag => ({ right, down, width: 200, height: 100 });
const field = (name: string, kind: string, text: string): Field => ({ name, kind, text, from: 0, to: 0 });

test("what is lit follows the pointer", () => {
  // Light that goes along the view lights the front of a ball.
  const right = turnedDirection([0, 0, -1], camera, 40, 0);
  assert.ok(right[0] < 0 && Math.abs(right[1]) < 1e-12, "it comes from the right");
  const down = turnedDirection([0, 0, -2], camera, 0, 40);
  assert.ok(down[1] > 0, "it comes from below");
  assert.ok(Math.abs(Math.hypot(...down) - 1) < 1e-12);
});

test("a light stays under the pointer that drags it", () => {
  // The view's height spans 60 degrees: at a distance of d it is 2 d tan 30 degrees high, in 100 pixels.
  const perPixel = (distance: number) => (2 * distance * Math.tan(Math.PI / 6)) / 100;
  const near = (found: number[], expected: number[]) => found.forEach((each, index) => assert.ok(Math.abs(each - expected[index]!) < 1e-12, `${found}`));
  near(movedPosition([1, 2, 0], camera, drag(10, 0)), [1 + 10 * perPixel(5), 2, 0]);
  near(movedPosition([1, 2, 3], camera, drag(0, 20)), [1, 2 - 20 * perPixel(2), 3]);
  near(movedPosition([0, 0, 9], camera, drag(10, 0)), [10 * perPixel(5), 0, 9]);
  const parallel: FreeCamera = { ...camera, orthographic: 4 };
  near(movedPosition([0, 0, 3], parallel, drag(25, 0)), [1, 0, 3]);
  // From the side what is right of the picture is nearer to the first eye.
  near(movedPosition([0, 0, 0], { ...camera, eye: [5, 0, 0] }, drag(10, 0)), [0, 0, -10 * perPixel(5)]);
});

test("a light is moved where it has a place, or else turned; backgrounds are turned", () => {
  const of = (fields: Field[], isLight = true, turns = false) => draggable({ fields, isLight, turns });
  const direction = field("directional.direction", "vector", "0 0 -1");
  const position = field("spot.position", "vector", "0 1 0");
  assert.equal(of([field("color", "color", "1 1 1"), direction]), direction);
  assert.equal(of([direction, position]), position);
  assert.equal(of([direction, position], true, true), direction);
  assert.equal(of([position], true, true), position);
  assert.equal(of([position], false), undefined, "not of a light");
  for (const name of ["origin", "location"]) assert.equal(of([field(name, "vector", "0 0 0")])?.name, name);
  assert.equal(of([field("sun_and_sky.sun_direction", "vector", "0 1 0")], false)?.name, "sun_and_sky.sun_direction");
  assert.equal(of([field("panorama.angle", "number", "30")], false)?.name, "panorama.angle");
  assert.equal(of([{ ...direction, locked: "computed" }, { ...position, locked: "computed" }]), undefined);
});

test("a light in other axes follows the pointer, too", () => {
  // A quarter of a turn about y, in inches, 2 metres to the right: x is the world's -z, and z its x.
  const axes = [0, 0, 0.0254, 2, 0, 0.0254, 0, 0, -0.0254, 0, 0, 0];
  const position = field("location", "vector", "0 0 0");
  // The view's height spans 60 degrees at 5 metres: 10 pixels are .57735 metres.
  assert.equal(draggedText(position, camera, drag(10, 0), axes), "0 0 22.7303");
  assert.equal(draggedText(position, camera, drag(0, 10), axes), "0 -22.7303 0");
  const turned = draggedText(field("direction", "vector", "1 0 0"), camera, drag(90 / 0.35, 0), axes)!.split(" ").map(Number);
  assert.deepEqual(turned.map((each) => Math.round(each * 0.0254 * 100) / 100), [0, 0, -1], "it came from the front, and now comes from the right");
  assert.equal(draggedText(position, camera, drag(10, 0), [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0]), undefined, "flat axes");
});

test("texts are short, and what is no number stays", () => {
  assert.equal(draggedText(field("panorama.angle", "number", "30"), camera, drag(20, 5)), "23");
  assert.equal(draggedText(field("direction", "vector", "0 0 -1"), camera, drag(0, 0)), "0 0 -1");
  assert.equal(draggedText(field("point.position", "vector", "1 2 0"), camera, drag(10, 0)), "1.5774 2 0");
  assert.equal(draggedText(field("direction", "vector", "a b c"), camera, drag(1, 1)), undefined);
});
