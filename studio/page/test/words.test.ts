import assert from "node:assert/strict";
import { test } from "node:test";
import { backoff } from "../src/core/backoff.js";
import { keptKeys, keyMap, matching, nameOfKey, whyNotKey, withKeys } from "../src/core/keys.js";
import { keptLook } from "../src/core/looks.js";
import { isScene, isText, endingOf } from "../src/core/paths.js";
import { decode, encode, type JobReport } from "../src/core/protocol.js";
import { dateAndTime, progressWords, short, viewWords, type ViewState } from "../src/core/view_words.js";

const job: JobReport = { pane: 0, serial: 3, file: "a.crt", version: 2, scale: 4, samples: 1, width: 10, height: 10, state: "tracing" };
const view: ViewState = { connection: "open", file: "a.crt", shown: "a.crt", job, progress: undefined, paused: false, reading: false, workers: 1 };

test("the view says what it shows", () => {
  const words = (changes: Partial<ViewState>) => viewWords({ ...view, ...changes });
  assert.equal(words({ file: undefined }).words, "open or drop a scene");
  assert.equal(words({ connection: "lost" }).words, "disconnected");
  assert.equal(words({}).words, "refining, 1/4 size");
  const progress = { pane: 0, serial: 3, tiles_done: 1, tiles_total: 3, elapsed: 1, left: 1 };
  assert.equal(words({ progress }).words, "refining, 1/4 size, 33 %");
  assert.equal(words({ progress: { ...progress, serial: 2 } }).words, "refining, 1/4 size");
  assert.equal(words({ job: { ...job, state: "done", samples: 16, times: { total: 1.234 } } }).words, "done, 16 samples, 1.23 s");
  assert.equal(words({ job: { ...job, state: "done", stale: { as_of: new Date(2026, 1, 3, 12, 30, 1).getTime(), why: "line 4: no such field" } } }).words, "as of 12:30:01: line 4: no such field");
  assert.equal(words({ job: { ...job, stale: { as_of: null, why: "" } } }).words, "as of an earlier text");
  assert.equal(words({ job: { ...job, state: "failed", why: "line 2" } }).state, "failed");
  const nothing = { ...job, stale: { as_of: null, why: "files of type .mtl are not read" } };
  for (const shown of [undefined, "b.crt"]) assert.deepEqual(words({ job: nothing, shown }), { state: "failed", words: "files of type .mtl are not read" });
  assert.equal(words({ job: { ...nothing, stale: { as_of: null, why: "" } }, shown: undefined }).words, "nothing is shown");
  assert.equal(words({ paused: true, reading: true }).words, "paused");
  assert.equal(words({ reading: true, job: { ...job, stale: { as_of: 0, why: "" } } }).words, "reading");
  assert.equal(words({ job: undefined, workers: 0 }).words, "waiting for workers");
});

test("a time has its date and zone", () => {
  const time = new Date(2026, 1, 3, 12, 30, 1).getTime();
  assert.ok(/^2026-02-03T12:30:01[+-][0-9]{2}:[0-9]{2}$/.test(dateAndTime(time)));
  assert.equal(new Date(dateAndTime(time)).getTime(), time);
});

test("connecting is tried again ever later", () => {
  assert.deepEqual([0, 1, 2, 3, 4, 5, 6, 50].map(backoff), [0.25, 0.5, 1, 2, 4, 5, 5, 5]);
});

test("a message is one object with one member", () => {
  assert.deepEqual(decode(encode("open", { file: "a" })), { kind: "open", body: { file: "a" } });
  for (const text of ["", "[]", "1", "{}", '{"a":1}', '{"a":{},"b":{}}', "{", "null"]) assert.equal(decode(text), undefined, text);
});

test("keys have names", () => {
  const none = { ctrlKey: false, altKey: false, shiftKey: false, metaKey: false };
  assert.equal(nameOfKey({ ...none, key: "s", ctrlKey: true }), "Ctrl-S");
  assert.equal(nameOfKey({ ...none, key: "S", ctrlKey: true, shiftKey: true }), "Ctrl-Shift-S");
  assert.equal(nameOfKey({ ...none, key: "F6", shiftKey: true }), "Shift-F6");
  assert.equal(nameOfKey({ ...none, key: "Enter", ctrlKey: true }), "Ctrl-Enter");
  assert.equal(nameOfKey({ ...none, key: "ß", code: "KeyS", altKey: true }), "Alt-S");
  assert.equal(nameOfKey({ ...none, key: "Control", ctrlKey: true }), undefined);
  assert.equal(keyMap([{ name: "a", keys: ["F1"] }, { name: "b", keys: ["F1", "F2"] }]).get("F1"), "a");
});

test("commands are found by parts of their names", () => {
  const all = [{ name: "Theme: dark" }, { name: "Dark side" }, { name: "Save" }];
  assert.deepEqual(matching(all, "dark").map((each) => each.name), ["Dark side", "Theme: dark"]);
  assert.deepEqual(matching(all, "th da").map((each) => each.name), ["Theme: dark"]);
  assert.equal(matching(all, "").length, 3);
});

test("files are told apart by their endings", () => {
  assert.equal(endingOf("a/B.TESSERA"), "tessera");
  assert.equal(endingOf("a.b/c"), "");
  assert.ok(isScene("x.crt") && !isScene("x.mtl") && !isScene("x.png"));
  assert.ok(isText("x.mtl") && !isText("x.glb") && !isText("x.exr"));
});

test("large numbers are short", () => {
  assert.deepEqual([0, 999, 1234, 12345, 1.5e6, 2e9].map(short), ["0", "999", "1.23 k", "12.3 k", "1.50 M", "2.00 G"]);
});

test("of what was kept of looks, what makes no sense is left out", () => {
  const choices = { channel: ["light", "depth"], integrator: ["path"], "tone-map": ["filmic"], filter: ["gauss"] };
  const look = { channel: "depth", exposure: -10, tone_map: "filmic", integrator: "path", filter: "gauss" };
  assert.deepEqual(keptLook(look, choices), look);
  assert.deepEqual(keptLook({ tone_map: "gauss", filter: "filmic" }, choices), {});
  assert.deepEqual(keptLook({ channel: "taste", exposure: 11, integrator: "" }, choices), {});
  assert.deepEqual(keptLook({ channel: ["depth"], exposure: null, integrator: 3 }, choices), {});
});

test("small numbers keep three digits", () => {
  assert.deepEqual([0.001234, 0.5, 4.256, 99.96, 123.4, -4.256, -2500].map(short), ["0.00123", "0.5", "4.26", "100", "123", "-4.26", "-2.50 k"]);
});

test("the status bar says what is known of the pass that is traced, and nothing else", () => {
  const tracing = { ...job, state: "tracing" as const, serial: 4 };
  const progress = { pane: 0, serial: 4, tiles_done: 1, tiles_total: 8, elapsed: 0.5 };
  assert.deepEqual(progressWords({ job: tracing, progress }, undefined), ["1 of 8 tiles", "0.5 s"]);
  assert.deepEqual(progressWords({ job: tracing, progress: { ...progress, left: -1 } }, 2e6), ["1 of 8 tiles", "2.00 Mrays/s", "0.5 s"]);
  assert.deepEqual(progressWords({ job: tracing, progress: { ...progress, left: 0 } }, 0), ["1 of 8 tiles", "0.5 s", "0.0 s left"]);
  assert.deepEqual(progressWords({ job: tracing, progress: { ...progress, serial: 3 } }, 1), []);
  assert.deepEqual(progressWords({ job: { ...tracing, state: "done" }, progress }, 1), []);
});

test("keys that are no command's to have are refused with words", () => {
  const all = [{ name: "Save", keys: ["Ctrl-S"] }, { name: "Undo", keys: ["Ctrl-Z"] }];
  assert.equal(whyNotKey("Ctrl-Shift-U", "Undo", all), undefined);
  assert.equal(whyNotKey("Shift-F9", "Undo", all), undefined);
  assert.equal(whyNotKey("Ctrl-Z", "Undo", all), undefined);
  assert.ok(/found Ctrl-S, which the command “Save” has; expected/.test(whyNotKey("Ctrl-S", "Undo", all)!));
  for (const key of ["Ctrl-T", "Ctrl-W", "Alt-F4"]) assert.ok(/the browser keeps; expected/.test(whyNotKey(key, "Undo", all)!));
  assert.ok(/text fields have; expected/.test(whyNotKey("Ctrl-C", "Undo", all)!));
  for (const key of ["A", "Shift-A", "Enter", "Escape", "Tab", "ArrowLeft", "Space", "Shift-Tab"]) {
    assert.ok(/types or moves; expected/.test(whyNotKey(key, "Undo", all)!), key);
  }
});

test("commands of the view have keys without Ctrl and Alt, and no key twice", () => {
  const all = [{ name: "Save", keys: ["Ctrl-S"] }, { name: "Forward", keys: [], inView: ["W"] }, { name: "Pause", keys: [], inView: ["Space"] }];
  for (const key of ["I", "Shift-I", "Enter", "Left", "Ctrl-Left", "Ctrl-C", "W"]) assert.equal(whyNotKey(key, "Forward", all), undefined, key);
  assert.ok(/found Space, which the command “Pause” has; expected another one$/.test(whyNotKey("Space", "Forward", all)!));
  assert.ok(/which the command “Save” has/.test(whyNotKey("Ctrl-S", "Forward", all)!));
  assert.ok(/the browser keeps/.test(whyNotKey("Ctrl-T", "Forward", all)!));
  assert.ok(/which the command “Forward” has/.test(whyNotKey("Alt-W", "Save", [...all.slice(0, 1), { name: "Forward", keys: [], inView: ["Alt-W"] }])!));
  assert.deepEqual(withKeys(all[1]!, ["I"]), { name: "Forward", keys: [], inView: ["I"] });
  assert.deepEqual(withKeys(all[0]!, []), { name: "Save", keys: [] });
});

test("what was kept of keys may be anything", () => {
  assert.deepEqual(keptKeys({ Save: ["Ctrl-S"], Undo: "Ctrl-Z", Redo: [1], Find: [] }), { Save: ["Ctrl-S"], Find: [] });
  for (const wrong of [undefined, null, 5, "Ctrl-S"]) assert.deepEqual(keptKeys(wrong), {});
});
