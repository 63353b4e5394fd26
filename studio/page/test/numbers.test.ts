import assert from "node:assert/strict";
import { test } from "node:test";
import { checkNumber, dragged, evaluate, rangeWords, stepped, written } from "../src/core/numbers.js";

test("numbers are taken as they are typed", () => {
  for (const [text, value] of [["1.5", 1.5], ["-2", -2], [" .5 ", 0.5], ["1e3", 1000], ["2.", 2], ["+4", 4]] as const) {
    assert.deepEqual(checkNumber(text), { ok: true, value }, text);
  }
});

test("what is no number says what was found", () => {
  for (const text of ["", "nan", "inf", "-Infinity", "1,5", "1;2", "blah", "0x10", "1e999", "~", "1 2", "--1", "1e", "."]) {
    const checked = checkNumber(text);
    assert.ok(!checked.ok, text);
    assert.ok(checked.found !== "" && checked.expected.startsWith("a number"), text);
  }
  const comma = checkNumber("1,5");
  assert.ok(!comma.ok && comma.found.includes("point"));
  const two = checkNumber("1;2");
  assert.ok(!two.ok && two.found.includes("more than one"));
});

test("sizes are whole and from 1 to 65536", () => {
  const rules = { whole: true, range: [1, 65536] as [number, number] };
  for (const text of ["1", "65536", "960"]) assert.ok(checkNumber(text, rules).ok, text);
  for (const text of ["0", "-1", "65537", "1.0", "1e2", "blah"]) assert.ok(!checkNumber(text, rules).ok, text);
});

test("a number may have to suit others", () => {
  const rules = { also: (value: number) => (value === 0 ? "one beside 0" : undefined) };
  assert.deepEqual(checkNumber("0.0", rules), { ok: false, found: "0.0", expected: "one beside 0" });
  assert.ok(checkNumber("1", rules).ok);
});

test("a field of view lies between 0 and 180", () => {
  const rules = { range: [0, 180] as [number, number], open: true };
  for (const text of ["0.001", "179.9"]) assert.ok(checkNumber(text, rules).ok, text);
  for (const text of ["0", "180", "-1"]) assert.ok(!checkNumber(text, rules).ok, text);
});

test("arithmetic is worked out", () => {
  for (const [text, value] of [["1+2*3", 7], ["(1+2)*3", 9], ["-pi", -Math.PI], ["1/4", 0.25], ["2 - -1", 3], ["1e2+1", 101]] as const) {
    assert.equal(evaluate(text), value, text);
  }
  for (const text of ["", "1+", "(1", "1)", "a", "1/0", "alert(1)", "1 2"]) assert.equal(evaluate(text), undefined, text);
});

test("values are written short, and floats stay floats", () => {
  assert.equal(written(0.1 + 0.2), "0.3");
  assert.equal(written(2, "2.0"), "2.0");
  assert.equal(written(2, "2"), "2");
  assert.equal(written(-0), "0");
});

test("dragging and keys step", () => {
  assert.equal(dragged(100, 1, { ctrl: false, shift: false }), 101);
  assert.equal(dragged(0, 5, { ctrl: false, shift: false }), 0.005);
  assert.equal(dragged(100, 1, { ctrl: false, shift: true }), 100.1);
  assert.equal(dragged(1, 4, { ctrl: true, shift: false }), 1);
  assert.equal(stepped(1, "ArrowUp"), 1.01);
  assert.equal(stepped(1, "PageDown"), 0);
  assert.equal(stepped(8, "ArrowDown", true), 7);
  assert.equal(stepped(8, "a"), undefined);
});

test("the range of a number is told in few words", () => {
  assert.equal(rangeWords({ range: [0, 1] }), "0 to 1");
  assert.equal(rangeWords({ range: [0, 180], open: true }), "above 0, below 180");
  assert.equal(rangeWords({ range: [0, Infinity] }), "at least 0");
  assert.equal(rangeWords({ range: [-Infinity, 3], open: [false, true] }), "below 3");
  assert.equal(rangeWords({}), "");
});
