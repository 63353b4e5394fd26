import assert from "node:assert/strict";
import { test } from "node:test";
import { ChangeSet, Text } from "@codemirror/state";
import { DocumentSync, changeSetOf, differenceOf, textOf } from "../src/core/document_sync.js";
import type { Change } from "../src/core/protocol.js";

/** A program that has one text: edits of another base than its version are refused. */
class Program {
  version = 1;
  constructor(public text: string) {}
  edit(edit: { base: number; changes: Change[] }): number {
    assert.equal(edit.base, this.version);
    this.text = changeSetOf(edit.changes, this.text.length)!.apply(textOf(this.text)).toString();
    return ++this.version;
  }
}

function insert(text: Text, at: number, what: string): ChangeSet {
  return ChangeSet.of({ from: at, insert: what }, text.length, "\n");
}

test("changes of one frame are one edit", () => {
  const sync = new DocumentSync(1, textOf("ab"));
  sync.record(insert(sync.text(), 1, "x"));
  sync.record(insert(sync.text(), 2, "y"));
  assert.equal(sync.version, 2);
  assert.deepEqual(sync.take(), { base: 1, changes: [[1, 1, "xy"]] });
  assert.equal(sync.take(), undefined);
  assert.equal(sync.sentVersion, 2);
});

test("edits follow each other without waiting", () => {
  const program = new Program("one\ntwo");
  const sync = new DocumentSync(1, textOf(program.text));
  const answers = [];
  for (const letter of "abc") {
    sync.record(insert(sync.text(), 0, letter));
    answers.push(program.edit(sync.take()!));
  }
  assert.equal(program.text, "cbaone\ntwo");
  assert.ok(!sync.settled);
  answers.forEach((version) => sync.acknowledge(version));
  assert.ok(sync.settled);
  assert.equal(sync.acknowledgedVersion, 4);
});

/** A generator whose numbers are the same in every run. */
function numbers(seed: number): (below: number) => number {
  return (below) => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return Math.floor((seed / 2 ** 32) * below);
  };
}

test("no key is lost or doubled, whenever the connection goes", () => {
  for (let seed = 1; seed <= 300; ++seed) {
    const random = numbers(seed);
    const program = new Program("begin");
    const sync = new DocumentSync(1, textOf(program.text));
    let wire: { base: number; changes: Change[] }[] = [];
    let answers: number[] = [];
    let typed = 0;
    for (let step = 0; step < 60; ++step) {
      const what = random(6);
      if (what < 2) sync.record(insert(sync.text(), random(sync.text().length + 1), `<${++typed}>`));
      else if (what === 2) {
        const edit = sync.take();
        if (edit) wire.push(edit);
      } else if (what === 3 && wire.length > 0) answers.push(program.edit(wire.shift()!));
      else if (what === 4 && answers.length > 0) sync.acknowledge(answers.shift()!);
      else if (what === 5) {
        // Whatever was under way, in either direction, is lost.
        wire = [];
        answers = [];
        if (sync.acknowledgedText.toString() === program.text) sync.resume(program.version);
        else assert.equal(sync.restart(program.version, textOf(program.text), false), undefined);
      }
    }
    for (const edit of wire) sync.acknowledge(program.edit(edit));
    const last = sync.take();
    if (last) program.edit(last);
    assert.equal(program.text, sync.text().toString(), `seed ${seed}`);
    for (let i = 1; i <= typed; ++i) assert.equal(program.text.replace(/[^0-9]+/g, " ").length > 0, true);
  }
});

test("another's text is merged with what was typed here", () => {
  const sync = new DocumentSync(3, textOf("alpha\nbeta"));
  sync.record(insert(sync.text(), 5, "!"));
  const mine = sync.text();
  const changes = sync.restart(7, textOf("alpha\nbeta\ngamma"), false)!;
  assert.equal(changes.apply(mine).toString(), "alpha!\nbeta\ngamma");
  assert.deepEqual(sync.take(), { base: 7, changes: [[5, 5, "!"]] });
});

test("a program that starts again gets the text of the page", () => {
  const sync = new DocumentSync(9, textOf("typed long ago"));
  assert.equal(sync.restart(1, textOf("on the disk"), true), undefined);
  assert.equal(sync.text().toString(), "typed long ago");
  const program = new Program("on the disk");
  program.edit(sync.take()!);
  assert.equal(program.text, "typed long ago");
});

test("a program that has the text under another number gets the rest", () => {
  const sync = new DocumentSync(4, textOf("x"));
  sync.record(insert(sync.text(), 1, "y"));
  sync.take();
  sync.record(insert(sync.text(), 2, "z"));
  sync.resume(1);
  assert.deepEqual(sync.take(), { base: 1, changes: [[1, 1, "yz"]] });
});

test("differences are one stretch", () => {
  const make = (a: string, b: string) => differenceOf(textOf(a), textOf(b)).apply(textOf(a)).toString();
  for (const [a, b] of [["", "a"], ["a", ""], ["aaa", "aa"], ["abc", "abc"], ["a\nb", "a\n\nb"], ["xay", "xby"]] as const) {
    assert.equal(make(a, b), b);
  }
});

test("changes that do not fit are none", () => {
  assert.equal(changeSetOf([[5, 6, "x"]], 3), undefined);
  assert.equal(changeSetOf([[0, 1, "x"]], 3)!.length, 3);
});
