import assert from "node:assert/strict";
import { test } from "node:test";
import * as documents from "../src/documents.js";
import * as program from "../src/program.js";
import { handlers } from "../src/receive.js";
import * as state from "../src/state.js";
import { hear, said } from "./socket_worker.js";

// Frames come by hand, and time does not pass.
let frames: (() => void)[] = [];
Object.assign(globalThis, {
  requestAnimationFrame: (draw: () => void) => frames.push(draw),
  setTimeout: () => 0,
  MessageChannel: class {
    port1 = {};
    port2 = { postMessage() {} };
  },
  document: { querySelector: () => null },
  matchMedia: () => ({ matches: false }),
});
const passFrames = () => frames.splice(0).forEach((each) => each());

const FILE = "a.tessera";
const disk = { file: FILE, version: 1, text: "one\n", language: "tessera", eol: "lf", bom: false, encoding: "UTF-8", editable: true, read_only: false };
const shown = () => documents.find(FILE)!;
const textOf = () => documents.stateOf(shown()).doc.toString();
/** The messages of that kind that were sent since they were asked for last. */
function sent(kind: string): any[] {
  passFrames();
  const found = said.filter((each) => each[kind]).map((each) => each[kind]);
  said.splice(0, said.length, ...said.filter((each) => !each[kind]));
  return found;
}
const type = (insert: string, from = 0) => documents.apply(shown(), { changes: { from, insert } });
const notices = () => state.notices.value.splice(0).map((each) => each.text);

/** Begins anew with the file open as the disk has it. */
function begin(): void {
  program.connect({ handlers: { ...handlers, welcome: (message) => (state.welcome.value = message) }, greeting: () => ({}), painted: () => {}, parts: () => {} });
  hear({ welcome: { limits: { text: 100, message: 150 } } });
  documents.documents.value = [];
  hear({ document: disk });
  passFrames();
  said.length = 0;
  notices();
}

test("an edit that is refused is sent again once the text is another one, and not before", () => {
  begin();
  type("much ");
  assert.equal(sent("edit").length, 1);
  hear({ refused: { request: "edit", file: FILE, why: "too much" } });
  hear({ document: disk });
  assert.equal(textOf(), "much one\n");
  assert.deepEqual(sent("edit"), []);
  assert.deepEqual(notices(), [`${FILE}: too much`]);
  documents.save(FILE);
  assert.deepEqual(sent("save"), [], "the program has another text");
  assert.equal(notices().length, 1);
  type("x");
  assert.deepEqual(sent("edit"), [{ file: FILE, base: 1, changes: [[0, 0, "xmuch "]] }]);
  hear({ edited: { file: FILE, version: 2 } });
  documents.save(FILE);
  assert.equal(sent("save").length, 1);
});

test("an edit that would end the connection is not sent", () => {
  begin();
  type("\n".repeat(90));
  assert.deepEqual(sent("edit"), []);
  assert.ok(/too large to be sent/.test(notices()[0]!));
  documents.apply(shown(), { changes: { from: 0, to: 90, insert: "2" } });
  assert.deepEqual(sent("edit"), [{ file: FILE, base: 1, changes: [[0, 0, "2"]] }]);
});

test("a text does not grow beyond what the program takes", () => {
  begin();
  const { editor } = shown();
  assert.equal(editor.update({ changes: { from: 0, insert: "x".repeat(97) } }).docChanged, false);
  assert.ok(/101 characters; expected at most 100/.test(notices()[0]!));
  assert.equal(editor.update({ changes: { from: 0, insert: "x".repeat(96) } }).docChanged, true);
});

test("who keeps the own text keeps it over what the disk had then, and over no later change", () => {
  begin();
  type("mine ");
  hear({ disk: { file: FILE, state: "changed", text: "theirs" } });
  documents.save(FILE);
  assert.deepEqual(sent("save"), []);
  documents.keepMine(FILE);
  hear({ disk: { file: FILE, state: "changed", text: "later" } });
  documents.save(FILE);
  assert.deepEqual(sent("save"), [], "it is asked again");
  documents.keepMine(FILE);
  documents.save(FILE);
  assert.deepEqual(sent("save"), [{ file: FILE, force: true }]);
});

test("a file that was to be closed once it is saved stays open where that save was refused", () => {
  begin();
  type("mine ");
  sent("edit");
  documents.save(FILE, undefined, true);
  hear({ refused: { request: "save", file: FILE, why: "the disk is full" } });
  documents.save(FILE);
  hear({ saved: { file: FILE, version: 2, hash: "" } });
  assert.ok(shown());
  type("more ");
  sent("edit");
  documents.save(FILE, undefined, true);
  hear({ saved: { file: FILE, version: 3, hash: "" } });
  assert.equal(shown(), undefined);
});
