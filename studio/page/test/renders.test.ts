import assert from "node:assert/strict";
import { test } from "node:test";
import { question } from "../src/confirm.js";
import * as program from "../src/program.js";
import { handlers } from "../src/receive.js";
import { copyCommand, copyCommandOfView, orderExport, orderRender, watchRenders } from "../src/renders.js";
import * as state from "../src/state.js";
import { hear, said } from "./socket_worker.js";

// Time does not pass.
Object.assign(globalThis, { setTimeout: () => 0 });

const answers: (string | undefined)[] = [];
const answer = (why?: string) => void answers.push(why);
const heard = () => answers.splice(0);

test("an order that the page cannot give is answered", () => {
  orderRender({}, answer);
  assert.deepEqual(heard(), ["No scene is shown; expected one to render."]);
  state.sceneFile.value = "a.tessera";
  orderRender({}, answer);
  orderExport({ name: "a.png" }, answer);
  assert.deepEqual(heard(), ["There is no connection to the program.", "There is no connection to the program."]);
});

test("each order has its own answer, whatever else is answered or ordered", () => {
  program.connect({ handlers: { ...handlers, welcome: undefined }, greeting: () => ({}), painted: () => {}, parts: () => {} });
  hear({ welcome: {} });
  watchRenders();
  const done: unknown[] = [];
  said.length = 0;
  orderRender({}, (why) => answers.push(`first ${why}`), (job) => done.push(job.job));
  orderRender({}, (why) => answers.push(`second ${why}`));
  orderExport({ name: "a.png" }, (why) => answers.push(`third ${why}`));
  const numbers = said.flatMap((each) => Object.values(each).map(({ number }) => number));
  assert.equal(new Set(numbers).size, 3);
  const [first, second, third] = numbers;
  // The job of another page, for the same scene, and the refusal of something else.
  hear({ renders: { list: [{ job: 1, file: "a.tessera", state: "done" }] } });
  hear({ refused: { request: "export", why: "no" } });
  assert.deepEqual(heard(), []);
  hear({ refused: { request: "render", why: "the queue is full", number: second } });
  assert.deepEqual(heard(), ["second the queue is full"]);
  hear({ exported: { number: third, name: "a.png" } });
  hear({ ordered: { number: first, job: 2 } });
  assert.deepEqual(heard(), ["third undefined", "first undefined"]);
  hear({ renders: { list: [{ job: 1, file: "a.tessera", state: "done" }, { job: 2, file: "a.tessera", state: "done" }] } });
  assert.deepEqual(done, [2]);
});

test("a command line is of the picture that would be ordered", () => {
  state.tone.value = { exposure: 2, "tone-map": "filmic" };
  state.frame.value = 7;
  state.camera.value = { name: "side" };
  const spec = { overrides: { spp: 3 }, outputs: ["a.png"] };
  said.length = 0;
  orderRender(spec);
  copyCommand(spec);
  state.main.size.value = [40, 30];
  copyCommandOfView([]);
  const [rendered, copied, ofView] = said as { render?: { spec: object }; export?: { file: string; command: object } }[];
  assert.deepEqual(copied!.export!.command, rendered!.render!.spec);
  assert.deepEqual(ofView!.export!.command, { camera: { name: "side" }, tone: { exposure: 2, "tone-map": "filmic" }, frame: 7, overrides: { size: "40x30" }, outputs: [] });
  // What no option hides is not passed over silently.
  said.length = 0;
  state.hidden.value = [["a.tessera", "nodes[0]"]];
  copyCommandOfView([]);
  assert.deepEqual(said, []);
});

test("files are replaced only once that was agreed to", () => {
  for (const order of [orderRender, orderExport] as ((wish: { name: string }, answer: (why?: string) => void) => void)[]) {
    const force = () => JSON.stringify(said.pop()).includes('"force":true');
    const refuse = () => hear({ refused: { request: "", why: "it is there", number: Object.values(said[said.length - 1]!)[0]!.number, existing: { first: "a.png", count: 1 } } });
    order({ name: "a.png" }, answer);
    refuse();
    assert.ok(!force());
    assert.equal(question.value?.words, "a.png exists: replace it?");
    question.value!.otherwise!();
    assert.deepEqual(heard(), ["it is there"]);
    order({ name: "a.png" }, answer);
    refuse();
    question.value!.run();
    assert.ok(force());
    assert.deepEqual(heard(), []);
  }
});
