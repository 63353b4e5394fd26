import assert from "node:assert/strict";
import { test } from "node:test";
import { PANELS, PRESETS, ZONES, keptLayout, maximise, move, resize, restored, show, zoneOf, type Layout } from "../src/core/layout.js";

function panels(layout: Layout): string[] {
  return ZONES.flatMap((name) => layout.zones[name].tabs).sort();
}

test("the default has every panel once", () => {
  assert.deepEqual(panels(PRESETS.Default), [...PANELS].sort());
  assert.deepEqual(panels(PRESETS.CRT), [...PANELS].sort());
});

test("a panel that is moved is in one zone, on top", () => {
  const moved = move(PRESETS.Default, "Scene", "left");
  assert.equal(zoneOf(moved, "Scene"), "left");
  assert.equal(moved.zones.left.shown, "Scene");
  assert.equal(moved.zones.low.shown, "Properties");
  assert.deepEqual(panels(moved), [...PANELS].sort());
});

test("a panel of no zone is shown all the same", () => {
  assert.equal(zoneOf(show(PRESETS.LUX, "Console"), "Console"), "left");
});

test("everything keeps some room", () => {
  for (const share of [-1, 0, 0.5, 2]) {
    const { left, middle } = resize(PRESETS.Default, "left", share).shares;
    assert.ok(left >= 0.06 && left + middle <= 0.94 + 1e-9, String(share));
  }
});

test("maximising twice goes back", () => {
  const once = maximise(PRESETS.Default, "top");
  assert.equal(once.maximised, "top");
  assert.equal(maximise(once, "top").maximised, undefined);
});

test("what was kept comes back, and nonsense does not", () => {
  const moved = move(PRESETS.Default, "Graphs", "low");
  assert.deepEqual(restored(JSON.parse(JSON.stringify(moved))), moved);
  for (const kept of [undefined, null, 1, {}, { zones: {}, shares: {} }]) assert.equal(restored(kept), undefined);
  const odd = JSON.parse(JSON.stringify(moved)) as Layout;
  odd.zones.left.tabs.push("Graphs", "Nothing" as "Graphs");
  assert.equal(panels(restored(odd)!).filter((each) => each === "Graphs").length, 1);
  assert.ok(!panels(restored(odd)!).includes("Nothing"));
});

test("a panel that is new comes to a layout that was kept, where it is by default", () => {
  const old = JSON.parse(JSON.stringify(keptLayout(PRESETS.Default))) as ReturnType<typeof keptLayout>;
  old.zones.bottom.tabs = old.zones.bottom.tabs.filter((each) => each !== "Farm");
  old.panels = PANELS.filter((each) => each !== "Farm");
  const now = restored(old)!;
  assert.equal(zoneOf(now, "Farm"), "bottom");
  assert.equal(now.zones.bottom.shown, "Problems");
  assert.deepEqual(panels(now), [...PANELS].sort());
});

test("a layout without some panels stays so", () => {
  const kept = JSON.parse(JSON.stringify(keptLayout(PRESETS.LUX))) as unknown;
  assert.deepEqual(panels(restored(kept)!), panels(PRESETS.LUX));
});
