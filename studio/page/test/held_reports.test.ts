import assert from "node:assert/strict";
import { test } from "node:test";
import { encode } from "../src/core/protocol.js";
import { BURST_MS, HeldReports, LONGEST_WAIT_MS } from "../src/worker/held_reports.js";

const EDIT = encode("edit", { file: "a.crt", base: 1, changes: [[0, 0, "x"]] });
const outline = (file: string, version: number) => JSON.stringify({ outline: { entities: [], file, version } });

test("the report of a single edit is passed on at once", () => {
  const reports = new HeldReports();
  reports.sent(EDIT, 0);
  assert.ok(!reports.holds(outline("a.crt", 2), 5));
  reports.sent(EDIT, BURST_MS);
  assert.ok(!reports.holds(outline("a.crt", 3), BURST_MS + 5));
  assert.equal(reports.due, undefined);
});

test("of a burst of edits the last report of each file is passed on, once it is over", () => {
  const reports = new HeldReports();
  for (let key = 0; key < 4; ++key) {
    reports.sent(EDIT, 100 * key);
    assert.equal(reports.holds(outline("a.crt", 2 + key), 100 * key + 5), key > 0);
    assert.ok(!reports.holds(encode("list", {}), 100 * key + 6));
  }
  assert.ok(reports.holds(outline("b.crt", 1), 310));
  assert.equal(reports.due, 300 + BURST_MS);
  assert.deepEqual(reports.take(), [outline("a.crt", 5), outline("b.crt", 1)]);
  assert.equal(reports.due, undefined);
});

test("a burst that does not end keeps nothing for long", () => {
  const reports = new HeldReports();
  for (let key = 0; key < 30; ++key) {
    reports.sent(EDIT, 100 * key);
    reports.holds(outline("a.crt", 2 + key), 100 * key + 5);
  }
  assert.equal(reports.due, 105 + LONGEST_WAIT_MS);
});

test("what comes after the burst takes the place of what waits of it", () => {
  const reports = new HeldReports();
  reports.sent(EDIT, 0);
  reports.sent(EDIT, 100);
  assert.ok(reports.holds(outline("a.crt", 2), 110));
  assert.ok(!reports.holds(outline("a.crt", 3), 100 + BURST_MS));
  assert.deepEqual(reports.take(), []);
});
