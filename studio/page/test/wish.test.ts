import assert from "node:assert/strict";
import { test } from "node:test";
import * as program from "../src/program.js";
import * as state from "../src/state.js";
import { resized, watchWishes } from "../src/view/wish.js";
import { hear, said } from "./socket_worker.js";

/** Frames and time pass by hand. */
let now = 0;
let frames: (() => void)[] = [];
const timers = new Set<number>();
Object.assign(globalThis, {
  requestAnimationFrame: (draw: () => void) => frames.push(draw),
  setTimeout: (_: () => void, after: number) => (timers.add(after), 0),
});
Object.defineProperty(performance, "now", { value: () => now }); // which cannot be assigned to everywhere

function passFrame(after: number): void {
  now += after;
  for (const each of frames.splice(0)) each();
}

const sizes = () => said.splice(0).flatMap((each) => (each.view ? [each.view.size] : []));

test("sizes are told as they change, the last one of a frame, and no pane floods the program", () => {
  program.connect({ handlers: {}, greeting: () => ({}), painted: () => {}, parts: () => {} });
  hear({ welcome: {} });
  watchWishes();
  state.sceneFile.value = "a.tessera";
  resized(state.main, 100, 50);
  passFrame(16);
  assert.deepEqual(sizes(), [[100, 50]]);
  for (const width of [110, 120, 130]) resized(state.main, width, 50);
  passFrame(16);
  assert.deepEqual(sizes(), [[130, 50]]);
  resized(state.main, 130, 50);
  passFrame(16);
  assert.deepEqual(sizes(), []);
  // A screen of 240 frames a second.
  for (let width = 131; width <= 140; ++width) {
    resized(state.main, width, 50);
    passFrame(4);
  }
  passFrame(16);
  assert.deepEqual(sizes(), [[131, 50], [135, 50], [139, 50], [140, 50]]);
  assert.deepEqual([...timers], [100], "nothing waits but for frames that do not come");
});
