import assert from "node:assert/strict";
import { test } from "node:test";
import { lineDifference } from "../src/core/line_difference.js";

const marked = (before: string, after: string) =>
  lineDifference(before, after).map((each) => `${each.isSame ? " " : "!"}${each.before ?? ""}|${each.after ?? ""}`);

test("lines that both texts have stand beside each other", () => {
  assert.deepEqual(marked("a\nb\nc", "a\nx\nc"), [" a|a", "!b|x", " c|c"]);
  assert.deepEqual(marked("a\nb\nc\nd", "a\nc\nnew\nd"), [" a|a", "!b|", " c|c", "!|new", " d|d"]);
  assert.deepEqual(marked("same", "same"), [" same|same"]);
});

test("what both sides are made of is all there, however long the texts are", () => {
  const before = Array.from({ length: 3000 }, (_, line) => `before ${line}`);
  const after = Array.from({ length: 2000 }, (_, line) => `after ${line}`);
  const pairs = lineDifference(before.join("\n"), after.join("\n"));
  assert.deepEqual(pairs.flatMap((each) => each.before ?? []), before);
  assert.deepEqual(pairs.flatMap((each) => each.after ?? []), after);
  assert.ok(pairs.every((each) => !each.isSame));
});
