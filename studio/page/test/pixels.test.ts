import assert from "node:assert/strict";
import { test } from "node:test";
import { Picture } from "../src/core/picture.js";
import { HEADER_BYTES, decodeFrame, encodeFrame, type PixelFrame } from "../src/core/pixel_frame.js";

function frame(changes: Partial<PixelFrame> = {}): PixelFrame {
  return {
    kind: 0, deflated: false, pane: 0, scale: 1, serial: 7, x: 0, y: 0, width: 2, height: 2, pictureWidth: 4,
    pictureHeight: 3, version: 5, samples: 16, endsPass: false, lastPass: false, body: new Uint8Array(16), ...changes,
  };
}

function rows(...colours: number[]): Uint8Array<ArrayBuffer> {
  return new Uint8Array(colours.flatMap((each) => [each, each, each, 255]));
}

function reds(picture: Picture): number[] {
  return [...picture.pixels].filter((_, index) => index % 4 === 0);
}

test("a frame survives its encoding", () => {
  const made = frame({ scale: 8, x: 1, y: 1, endsPass: true, lastPass: true, deflated: true, body: rows(1, 2, 3, 4) });
  assert.deepEqual(decodeFrame(encodeFrame(made)), made);
});

test("the header is as the program writes it", () => {
  const bytes = new Uint8Array(encodeFrame(frame({ serial: 0x01020304, lastPass: true })));
  assert.equal(String.fromCharCode(...bytes.subarray(0, 4)), "TSPX");
  assert.deepEqual([...bytes.subarray(8, 12)], [4, 3, 2, 1]);
  assert.equal(bytes[30], 2);
  assert.equal(HEADER_BYTES, 32);
});

test("what is no frame, or reaches out of its picture, is none", () => {
  assert.equal(decodeFrame(new ArrayBuffer(31)), undefined);
  assert.equal(decodeFrame(new ArrayBuffer(64)), undefined);
  assert.equal(decodeFrame(encodeFrame(frame({ x: 3 }))), undefined);
  assert.equal(decodeFrame(encodeFrame(frame({ scale: 0 }))), undefined);
});

test("tiles are put where they are", () => {
  const picture = new Picture();
  assert.deepEqual(picture.paint(frame(), rows(1, 2, 3, 4), 4, 3), { x: 0, y: 0, width: 4, height: 3 });
  assert.deepEqual(picture.paint(frame({ x: 2, y: 1 }), rows(5, 6, 7, 8), 4, 3), { x: 2, y: 1, width: 2, height: 2 });
  assert.deepEqual(reds(picture), [1, 2, 0, 0, 3, 4, 5, 6, 0, 0, 7, 8]);
});

test("coarse pixels fill squares that end with the picture", () => {
  const picture = new Picture();
  picture.paint(frame({ scale: 2, pictureWidth: 3, pictureHeight: 2, width: 3, height: 2 }), rows(1, 2, 3, 4, 5, 6), 5, 3);
  assert.deepEqual([picture.width, picture.height], [5, 3]);
  assert.deepEqual(reds(picture), [1, 1, 2, 2, 3, 1, 1, 2, 2, 3, 4, 4, 5, 5, 6]);
});

test("an older picture paints nothing over a newer", () => {
  const picture = new Picture();
  picture.paint(frame({ serial: 9 }), rows(9, 9, 9, 9), 4, 3);
  assert.equal(picture.paint(frame({ serial: 8 }), rows(1, 1, 1, 1), 4, 3), undefined);
  assert.equal(reds(picture)[0], 9);
  picture.restart();
  assert.ok(picture.paint(frame({ serial: 1 }), rows(1, 1, 1, 1), 4, 3));
});

test("another size begins as the old picture, scaled", () => {
  const picture = new Picture();
  picture.paint(frame({ pictureWidth: 2, pictureHeight: 2 }), rows(1, 2, 3, 4), 2, 2);
  picture.resize(4, 2);
  assert.deepEqual(reds(picture), [1, 1, 2, 2, 3, 3, 4, 4]);
});

test("a body that is short paints nothing", () => {
  assert.equal(new Picture().paint(frame(), rows(1, 2, 3), 4, 3), undefined);
});

test("only the last piece of the last pass completes", () => {
  const picture = new Picture();
  picture.paint(frame({ lastPass: true }), rows(1, 2, 3, 4), 4, 3);
  assert.equal(picture.complete, false);
  picture.paint(frame({ lastPass: true, endsPass: true }), rows(1, 2, 3, 4), 4, 3);
  assert.equal(picture.complete, true);
});
