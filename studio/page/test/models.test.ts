import "./socket_worker.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { relativeName, resolvedName } from "../src/core/paths.js";
import type { Entity, Problem } from "../src/core/protocol.js";
import { candidates, faultOfFile, type ModelWish } from "../src/models.js";
import * as state from "../src/state.js";

const SCENE = "sub/up.tessera";
const include: Entity = { id: "includes[0]", parent: "scene", kind: "include", name: "", target: "../elsewhere/far.obj", line: 2, column: 1, end_line: 2, end_column: 40, from: 20, to: 59 };

function wish(changes: Partial<ModelWish> = {}): ModelWish {
  const numbers: [string, string, string] = ["0", "0", "0"];
  const placement = { file: include.target!, material: "", position: numbers, rotation: numbers, scale: numbers, flip: [false, false, false] as [boolean, boolean, boolean] };
  return { file: SCENE, entity: include.id, placement, materials: undefined, locked: undefined, ...changes };
}

function problem(line: number, severity: Problem["severity"] = "error"): Problem {
  return { severity, file: SCENE, version: 1, line, column: 18, end_line: line, end_column: 30, message: "" };
}

function know(...list: Problem[]): void {
  state.knownProblems.value = new Map([[SCENE, { version: 1, list }]]);
}

state.files.value = [
  { name: "sub", kind: "folder", size: 0 }, { name: "two.obj", kind: "model", size: 1 }, { name: "two.mtl", kind: "model", size: 1 },
  { name: SCENE, kind: "scene", size: 1 }, { name: "sub/one.obj", kind: "model", size: 1 }, { name: "sun/three.obj", kind: "model", size: 1 },
];
state.outlines.value = new Map([[SCENE, { file: SCENE, version: 1, entities: [include] }]]);

test("names lead from a text to a file and back", () => {
  for (const [folder, relative, name] of [["sub/", "../two.obj", "two.obj"], ["", "sub/a.obj", "sub/a.obj"], ["a/b/", "../c/d.obj", "a/c/d.obj"], ["a/b/", "d.obj", "a/b/d.obj"], ["a/b/", "../b.obj", "a/b.obj"]] as const) {
    assert.equal(resolvedName(folder, relative), name);
    assert.equal(relativeName(folder, name), relative);
  }
  assert.equal(resolvedName("sub/", "./x/../../two.obj"), "two.obj");
  assert.equal(resolvedName("sub/", "../../two.obj"), undefined);
});

test("a scene is offered the models of the whole folder, those beside it first", () => {
  assert.deepEqual(candidates(SCENE), ["one.obj", "../two.obj", "../sun/three.obj"]);
});

test("a model that the scene can place is right wherever it lies in the folder", () => {
  know();
  for (const name of ["one.obj", "../two.obj", "./one.obj", "../sub/one.obj", "../sun/three.obj"]) assert.equal(faultOfFile(name, wish()), undefined, name);
  for (const name of ["", " ", "two.obj", "../two.mtl", "up.tessera", "../../two.obj", "../sub"]) assert.ok(/^found .*; expected /.test(faultOfFile(name, wish()) ?? ""), name);
});

test("the file that the text names is right as long as the program reads it", () => {
  const fault = (changes = {}) => faultOfFile(include.target!, wish(changes));
  know();
  assert.equal(fault(), undefined);
  assert.ok(/no such file/.test(faultOfFile("../elsewhere/other.obj", wish()) ?? ""));
  assert.ok(/no such file/.test(fault({ entity: undefined }) ?? ""));
  know(problem(1), problem(2, "warning"), problem(3));
  assert.equal(fault(), undefined);
  know(problem(2));
  assert.ok(/no such file/.test(fault() ?? ""));
});

test("what cannot be set is not wrong", () => {
  assert.equal(faultOfFile("", wish({ locked: "a text of this language places no models" })), undefined);
});
