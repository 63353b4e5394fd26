import assert from "node:assert/strict";
import { test } from "node:test";
import { fitScale, frameAt, panned, pictureAt, scaledTo, scaleWords, showing, shown, transformOf, WHOLE, zoomed, type Zoom } from "../src/core/zoom.js";

/** Of pictures as large as their panes, much larger, and much smaller. */
const FITS = [1, 275 / 1600, 9.375];

test("what is under the pointer stays there", () => {
  for (const fit of FITS) {
    const before = scaledTo(WHOLE, fit, 16, 0.4, 0.6);
    const after = zoomed(before, fit, 2, 0.7, 0.2);
    assert.deepEqual([before.scale, after.scale], [16, 32]);
    const [old, now] = [pictureAt(shown(before, fit), 0.7, 0.2), pictureAt(shown(after, fit), 0.7, 0.2)];
    for (const side of [0, 1]) assert.ok(Math.abs(old[side]! - now[side]!) < 1e-12);
    const [right, down] = frameAt(shown(after, fit), ...now);
    assert.ok(Math.abs(right - 0.7) < 1e-12 && Math.abs(down - 0.2) < 1e-12);
  }
});

test("scales are points of the screen for a pixel of the picture", () => {
  assert.equal(fitScale([600, 400], [600, 400]), 1);
  assert.equal(fitScale([600.4, 399.6], [600, 400]), 1, "a pane is no whole number of pixels");
  assert.equal(fitScale([700, 299.5], [700, 300]), 1);
  assert.equal(fitScale([275, 300], [1600, 900]), 275 / 1600);
  assert.equal(fitScale([600, 400], [64, 36]), 600 / 64);
  assert.equal(fitScale([300, 200], [600, 400]), 0.5, "of a screen that has two pixels a point");
  assert.equal(fitScale([275.6, 300], [1600, 900]), 275 / 1600, "whole points wide");
  assert.equal(fitScale([300, 100], [10, 1000]), 1 / 10, "and a point at least");
  assert.equal(fitScale([0, 0], [600, 400]), 1);
  assert.equal(fitScale([600, 400], [0, 0]), 1);
  // The frame is 275 points wide, and the sheet as wide as 1600 pixels of one point.
  assert.equal(shown(scaledTo(WHOLE, 275 / 1600, 1), 275 / 1600).factor * 275, 1600);
});

/** The scales that so many steps lead to, from one after the other. */
function ladder(fit: number): Zoom["scale"][] {
  const scales: Zoom["scale"][] = [];
  for (let zoom = zoomed(WHOLE, fit, -99); ; zoom = zoomed(zoom, fit, 1)) {
    if (scales.includes(zoom.scale)) return scales;
    scales.push(zoom.scale);
  }
}

test("steps lead from what fits, or 1:1 if that is smaller, to 64:1", () => {
  assert.deepEqual(ladder(1), ["fit", 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64]);
  assert.deepEqual(ladder(275 / 1600), ["fit", 1 / 4, 1 / 3, 1 / 2, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64]);
  assert.deepEqual(ladder(9.375), [1, 2, 3, 4, 6, 8, "fit", 12, 16, 24, 32, 48, 64]);
  assert.deepEqual(ladder(75), [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, "fit"]);
  assert.deepEqual(zoomed(zoomed(WHOLE, 1, 100, 0, 0), 1, -100), WHOLE);
});

test("a pane that has changed leaves the scale as it is, and steps go on from there", () => {
  const zoom = scaledTo(WHOLE, 0.2, 2);
  assert.equal(zoomed(zoom, 0.7, 1).scale, 3);
  assert.equal(zoomed({ ...WHOLE, scale: 1 / 4 }, 0.4, 1).scale, 1 / 2);
});

test("a picture that is 1:1 fits where its frame is as large", () => {
  assert.deepEqual(scaledTo(WHOLE, 1, 1), WHOLE);
});

test("no side of the frame is left empty, and what is smaller is in its middle", () => {
  const corner = panned(zoomed(WHOLE, 1, 3), 1, 100, -100);
  assert.deepEqual(pictureAt(shown(corner, 1), 0, 1), [0, 1]);
  assert.deepEqual(panned(WHOLE, 1, 3, 3), WHOLE);
  assert.deepEqual(scaledTo(scaledTo(WHOLE, 8, 64, 0, 0), 8, 2), { scale: 2, x: 0.5, y: 0.5 });
});

test("a point that is not seen is brought into the frame, and no further", () => {
  const corner = zoomed(WHOLE, 1, 3, 0, 0);
  assert.deepEqual(showing(corner, 1, 0.1, 0.1), corner);
  assert.equal(frameAt(shown(showing(corner, 1, 0.5, 0.1), 1), 0.5, 0.1)[0], 1);
});

test("the sheet is moved and enlarged from its corner", () => {
  assert.equal(transformOf(shown(WHOLE, 1)), "translate(0%, 0%) scale(1)");
  assert.equal(transformOf(shown(zoomed(WHOLE, 1, 1), 1)), "translate(-50%, -50%) scale(2)");
});

test("scales have names", () => {
  assert.deepEqual([1, 64, 9.375, 1 / 3, 275 / 1600].map(scaleWords), ["1:1", "64:1", "9.38:1", "1:3", "1:5.82"]);
});
