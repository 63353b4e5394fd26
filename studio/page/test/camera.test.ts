import assert from "node:assert/strict";
import { test } from "node:test";
import * as maths from "../src/core/camera.js";
import type { FreeCamera, Vector } from "../src/core/protocol.js";

const camera: FreeCamera = { eye: [0, 0, 5], target: [0, 0, 0], up: [0, 1, 0], fov: 60, axis: "vertical" };

function near(actual: Vector, expected: Vector, message?: string): void {
  assert.ok(actual.every((each, index) => Math.abs(each - expected[index]!) < 1e-9), `${message ?? ""} ${actual} and ${expected}`);
}

test("a camera that looks down keeps its horizon level", () => {
  const down: FreeCamera = { ...camera, eye: [0, 2, 8], target: [0, 0.5, 0], up: [0, 0.98287, -0.18429] };
  for (const turn of [maths.orbit(down, 60, 0), maths.orbitAbout(down, [1, 0, 0], 60, 0), maths.look(down, 60, 0)]) {
    assert.ok(Math.abs(maths.frameOf(turn).right[1]) < 1e-9);
  }
  const rolled: FreeCamera = { ...camera, up: [0.5, 0.866, 0] };
  assert.deepEqual(maths.uprightOf(rolled), maths.normalised(rolled.up));
});

test("eye, target and up that make no frame say what is expected of them", () => {
  const expected = (changes: Partial<FreeCamera>) => maths.expectedOfPose({ ...camera, ...changes });
  assert.equal(expected({}), undefined);
  assert.equal(expected({ eye: [0, 1e-300, 0] }), "an up that is not along the view");
  assert.equal(expected({ eye: [0, 0, 0] }), "an eye that is not at the target");
  assert.equal(expected({ up: [0, 0, 0] }), "an up that is not 0 0 0");
  for (const up of [[0, 0, 2], [0, 0, -1e-5], [0, 1e-12, 1]] as Vector[]) assert.equal(expected({ up }), "an up that is not along the view");
  assert.equal(expected({ up: [0, 1e-3, 1] }), undefined);
});

test("an orbit keeps the distance and what is looked at", () => {
  const turned = maths.orbit(camera, 37, 21);
  near(turned.target, camera.target);
  assert.ok(Math.abs(maths.length(turned.eye) - 5) < 1e-9);
  near(maths.orbit(maths.orbit(camera, 30, 0), -30, 0).eye, camera.eye);
  assert.ok(turned.eye[1] > 0);
});

test("an orbit stops short of the poles", () => {
  const over = maths.orbit(camera, 0, 500);
  assert.ok(over.eye[1] < 5 && over.eye[1] > 4.9);
  near(maths.frameOf(over).right, [1, 0, 0]);
});

test("looking around leaves the eye", () => {
  const looked = maths.look(camera, 90, 0);
  near(looked.eye, camera.eye);
  assert.ok(Math.abs(maths.length(maths.subtract(looked.target, looked.eye)) - 5) < 1e-9);
});

test("a pan by the view's height moves by what it spans", () => {
  const metres = maths.metresPerPixel(camera, 200, 100);
  assert.ok(Math.abs(100 * metres - 2 * 5 * Math.tan(Math.PI / 6)) < 1e-9);
  near(maths.move(camera, 1, 2, 3).eye, [1, 2, 2]);
});

test("a dolly keeps what is under the pointer", () => {
  const aside: [number, number] = [1, 0.5];
  const nearer = maths.dolly(camera, 0.5, aside);
  assert.ok(Math.abs(maths.length(maths.subtract(nearer.eye, nearer.target)) - 2.5) < 1e-9);
  // The point under the pointer, seen from the new camera in units of its distance, is where it was.
  const point: Vector = [1, 0.5, 0];
  const seen = (from: FreeCamera) => {
    const frame = maths.frameOf(from);
    const to = maths.subtract(point, from.eye);
    return [maths.dot(to, frame.right) / maths.dot(to, frame.forward), maths.dot(to, frame.up) / maths.dot(to, frame.forward)];
  };
  const [before, after] = [seen(camera), seen(nearer)];
  assert.ok(Math.abs(before[0]! - after[0]!) < 1e-9 && Math.abs(before[1]! - after[1]!) < 1e-9);
});

test("the field of view stays within bounds", () => {
  assert.equal(maths.zoom(camera, 1000).fov, 179);
  assert.equal(maths.zoom(camera, -1000).fov, 0.5);
});

test("a point is fitted as a box of the least size, by parallel rays as high as it is", () => {
  const [low, high] = maths.noSmaller([[1, 2, 3], [1, 2, 3]], 2);
  near(maths.times(maths.add(low, high), 0.5), [1, 2, 3]);
  assert.ok(Math.abs(maths.length(maths.subtract(high, low)) - 2) < 1e-12);
  assert.deepEqual(maths.noSmaller([[0, 0, 0], [3, 0, 0]], 2), maths.around([1.5, 0, 0], [3, 0, 0]));
  const parallel = { ...camera, orthographic: 40 };
  const fitted = maths.fit(parallel, [low, high]);
  assert.ok(Math.abs(fitted.orthographic! - 2) < 1e-12);
  near(fitted.target, [1, 2, 3]);
  assert.ok(maths.length(maths.subtract(fitted.eye, fitted.target)) >= maths.length(maths.subtract(camera.eye, camera.target)) - 1e-9);
});

test("a fitted box is seen whole", () => {
  const fitted = maths.fit(camera, [[-1, -1, -1], [1, 1, 1]]);
  near(fitted.target, [0, 0, 0]);
  assert.ok(maths.length(fitted.eye) >= Math.sqrt(3) / Math.sin(Math.PI / 6) - 1e-9);
});

test("views along axes have a right", () => {
  for (const axis of ["top", "front", "side"] as const) {
    const frame = maths.frameOf(maths.along(camera, axis));
    assert.ok(Math.abs(maths.length(frame.right) - 1) < 1e-9, axis);
    assert.ok(Math.abs(maths.dot(frame.right, frame.up)) < 1e-9, axis);
  }
});

test("a box is seen whole by parallel rays, whatever the picture's shape", () => {
  const box: [Vector, Vector] = [[0, 0, 0], [8, 4, 2]];
  const across = { top: [8, 2], front: [8, 4], side: [2, 4] };
  for (const side of maths.SIDES) {
    for (const [width, height] of [[300, 100], [100, 300], [100, 100]] as const) {
      const fitted = maths.fittedAlong(box, side, width, height);
      near(fitted.target, [4, 2, 1]);
      const metres = maths.metresPerPixel(fitted, width, height);
      const [wide, high] = across[side] as [number, number];
      const shares = [wide / (width * metres), high / (height * metres)];
      assert.ok(Math.abs(Math.max(...shares) - 1 / 1.1) < 1e-9, `${side} ${width}x${height} ${shares}`);
      // It begins outside of the box.
      assert.ok(maths.length(maths.subtract(fitted.eye, fitted.target)) > 4);
    }
  }
});

test("a dolly by parallel rays leaves the eye where it is", () => {
  const fitted = maths.fittedAlong([[-1, -1, -1], [1, 1, 1]], "front", 100, 100);
  const nearer = maths.dolly(fitted, 0.5);
  near(nearer.eye, fitted.eye);
  assert.ok(Math.abs(nearer.orthographic! - fitted.orthographic! / 2) < 1e-12);
});

test("an orbit about a pivot keeps where that is seen", () => {
  const pivot: [number, number, number] = [1, 0.5, -2];
  const seen = (each: typeof camera) => {
    const { forward, right, up } = maths.frameOf(each);
    const to = maths.subtract(pivot, each.eye);
    return [maths.dot(to, right), maths.dot(to, up), maths.dot(to, forward)];
  };
  const turned = maths.orbitAbout(camera, pivot, 25, 10);
  seen(turned).forEach((each, index) => assert.ok(Math.abs(each - seen(camera)[index]!) < 1e-9));
  near(maths.orbitAbout(camera, camera.target, 37, 21).eye, maths.orbit(camera, 37, 21).eye);
});
