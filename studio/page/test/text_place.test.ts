import assert from "node:assert/strict";
import { test } from "node:test";
import { ChangeSet } from "@codemirror/state";
import { DocumentSync, textOf } from "../src/core/document_sync.js";
import { rangeNow } from "../src/core/text_place.js";

const TEXT = "one\ntwo\nthree\n";

/** Makes an edit, which the program has once it is `acknowledged`. */
function edit(sync: DocumentSync, from: number, to: number, insert: string, acknowledged: boolean): void {
  sync.record(ChangeSet.of({ from, to, insert }, sync.text().length, "\n"));
  sync.take();
  if (acknowledged) sync.acknowledge(sync.sentVersion);
}

/** What is told of "two" in a version of the text. */
function cut(sync: DocumentSync, version?: number): string | undefined {
  const range = rangeNow(sync, { version, line: 2, column: 1, end_line: 2, end_column: 4 });
  return range && sync.text().sliceString(...range);
}

test("a place of an older text is where its text stands now", () => {
  const sync = new DocumentSync(5, textOf(TEXT));
  assert.equal(cut(sync, 5), "two");
  edit(sync, 0, 0, "zero\n", true);
  assert.equal(cut(sync, 5), "two");
  assert.equal(cut(sync, 6), "one");
  assert.equal(cut(sync), "one", "without a version it is one of the text as it is");
  edit(sync, 9, 9, "between\n", false);
  assert.equal(cut(sync, 5), "two", "what is typed right before it is outside of it");
  sync.record(ChangeSet.of({ from: 18, insert: "!" }, sync.text().length));
  assert.equal(cut(sync, 5), "t!wo");
  edit(sync, 17, 21, "", true);
  assert.equal(cut(sync, 5), "", "what is gone leaves its place");
});

test("places in versions that are not known are nowhere", () => {
  const sync = new DocumentSync(5, textOf(TEXT));
  assert.equal(cut(sync, 4), undefined);
  assert.equal(cut(sync, 6), undefined);
  edit(sync, 0, 0, "x", true);
  sync.restart(9, textOf("other"), false);
  assert.equal(cut(sync, 5), undefined, "the program has begun anew");
});

test("a page that follows another one knows what moved", () => {
  const sync = new DocumentSync(1, textOf(TEXT));
  sync.follow(ChangeSet.of({ from: 0, insert: "zero\n" }, TEXT.length, "\n"));
  assert.equal(cut(sync, 1), "two");
});
