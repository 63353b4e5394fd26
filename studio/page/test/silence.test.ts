import assert from "node:assert/strict";
import { test } from "node:test";
import { LOOK_MS, Silence } from "../src/core/silence.js";

/** Milliseconds until a silence counts as a loss. */
function untilLost(silence: Silence): number {
  let looks = 1;
  while (!silence.look()) ++looks;
  return looks * LOOK_MS;
}

/** A new connection, which brings something each second. */
function hearFor(silence: Silence, seconds: number): void {
  silence.begin();
  silence.heard();
  for (let second = 0; second < seconds; ++second) {
    for (let look = 0; look < 4; ++look) silence.look();
    silence.heard();
  }
}

test("every loss of a program that was heard in good time is told within three seconds", () => {
  const silence = new Silence();
  for (let loss = 0; loss < 4; ++loss) {
    hearFor(silence, 4);
    assert.equal(untilLost(silence), 3000);
  }
});

test("a line that is silent while a large message comes is given ever more time", () => {
  const silence = new Silence();
  const times = [];
  for (let loss = 0; loss < 5; ++loss) {
    hearFor(silence, 1);
    times.push(untilLost(silence));
  }
  assert.deepEqual(times, [3000, 6000, 12000, 24000, 24000]);
});
