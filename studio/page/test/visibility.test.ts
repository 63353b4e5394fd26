import assert from "node:assert/strict";
import { test } from "node:test";
import * as program from "../src/program.js";
import * as state from "../src/state.js";
import { pauseOrResume, watchVisibility } from "../src/view/wish.js";
import { hear, said } from "./socket_worker.js";

/** Time passes by hand. */
let now = 0;
let last = 0;
const timers = new Map<number, { at: number; run: () => void }>();
const seen = { hidden: false, listeners: [] as (() => void)[] };
Object.assign(globalThis, {
  setTimeout: (run: () => void, after: number) => (timers.set(++last, { at: now + after, run }), last),
  clearTimeout: (timer: number) => timers.delete(timer),
  document: {
    get hidden() {
      return seen.hidden;
    },
    addEventListener: (_: string, heard: () => void) => seen.listeners.push(heard),
  },
});

function pass(milliseconds: number): void {
  now += milliseconds;
  for (const [timer, { at, run }] of timers) {
    if (at > now) continue;
    timers.delete(timer);
    run();
  }
}

function hide(hidden: boolean): void {
  seen.hidden = hidden;
  for (const each of seen.listeners) each();
}

const orders = () => said.splice(0).flatMap((each) => Object.keys(each).filter((kind) => ["pause", "resume"].includes(kind)));

test("a page that nobody sees pauses its view after ten seconds, and goes on once it is seen", () => {
  program.connect({ handlers: {}, greeting: () => ({}), painted: () => {}, parts: () => {} });
  hear({ welcome: {} });
  watchVisibility();
  hide(true);
  pass(9_999);
  assert.deepEqual(orders(), []);
  hide(false);
  pass(60_000);
  assert.deepEqual(orders(), [], "it was hidden for less");
  hide(true);
  pass(10_000);
  assert.deepEqual(orders(), ["pause"]);
  hide(false);
  assert.deepEqual(orders(), ["resume"]);
});

test("what the user has paused stays so", () => {
  pauseOrResume();
  assert.deepEqual(orders(), ["pause"]);
  assert.ok(state.paused.peek());
  hide(true);
  pass(10_000);
  hide(false);
  assert.deepEqual(orders(), []);
});
