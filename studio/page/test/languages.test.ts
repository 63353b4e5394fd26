import assert from "node:assert/strict";
import { test } from "node:test";
import { StreamLanguage, ensureSyntaxTree, foldable, syntaxTree, type StreamParser } from "@codemirror/language";
import { EditorState } from "@codemirror/state";
import { classHighlighter, highlightTree } from "@lezer/highlight";
import { highlighter } from "../src/languages/highlighter.js";
import { languageName, languageOf } from "../src/languages/language_of.js";
import { crt, obj, ply, stl, tessera, vrml } from "../src/languages/parsers.js";

/** The words of a text with their classes, those without one left out. */
function tokens<State>(parser: StreamParser<State>, text: string): string[] {
  const tree = StreamLanguage.define(parser).parser.parse(text);
  const found: string[] = [];
  highlightTree(tree, classHighlighter, (from, to, classes) => found.push(`${text.slice(from, to)}=${classes.replace(/tok-/g, "")}`));
  return found;
}

test("tessera", () => {
  assert.deepEqual(tokens(tessera, 'camera { # eye\n  fov: -4.5e1 name: "a\\"b" kind: FLAT on: true }'), [
    "camera=typeName", "{=punctuation", "# eye=comment", "fov=propertyName", ":=punctuation", "-4.5e1=number",
    "name=propertyName", ":=punctuation", '"a\\"b"=string', "kind=propertyName", ":=punctuation", "FLAT=atom",
    "on=propertyName", ":=punctuation", "true=bool", "}=punctuation",
  ]);
});

test("crt", () => {
  const found = tokens(crt, "-- note\nball = Sphere { radius -> 2.5 } <translate (1, 0, 0)>\nwhile (i < 3) { f(x) }\nScene { ball }");
  for (const expected of ["-- note=comment", "Sphere=typeName", "radius=propertyName", "->=operator", "2.5=number", "while=keyword", "Scene=keyword"]) {
    assert.ok(found.includes(expected), `${expected} in ${found}`);
  }
});

test("vrml, with strings over several lines", () => {
  const found = tokens(vrml, '#VRML V2.0 utf8\nDEF Ball Shape { geometry Sphere { radius 2 } }\nText { string "one\ntwo" } NavigationInfo { headlight TRUE }');
  for (const expected of ["#VRML V2.0 utf8=comment", "DEF=keyword", "Shape=typeName", "geometry=propertyName", "2=number", "TRUE=bool"]) {
    assert.ok(found.includes(expected), `${expected} in ${found}`);
  }
  assert.ok(found.some((each) => each.startsWith('two"') && each.endsWith("string")), String(found));
});

test("obj, mtl, ply and stl", () => {
  assert.deepEqual(tokens(obj, "v 1 -2 .5\nusemtl red\n# c"), ["v=propertyName", "1=number", "-2=number", ".5=number", "usemtl=keyword", "red=string", "# c=comment"]);
  assert.ok(tokens(ply, "ply\ncomment made\nelement vertex 3\nproperty float x").includes("float=typeName"));
  assert.ok(tokens(stl, "solid a\nfacet normal 0 0 1").includes("facet=keyword"));
});

/** Read to its end, however long that takes: by itself the editor goes on later. */
function editorOf(file: string, text: string): EditorState {
  const editor = EditorState.create({ doc: text, extensions: languageOf(file) });
  ensureSyntaxTree(editor, text.length, Infinity);
  return editor.update({}).state;
}

/** The words of a file's text with the classes that the editor gives them. */
function highlighted(file: string, text: string): string[] {
  const editor = editorOf(file, text);
  const found: string[] = [];
  highlightTree(syntaxTree(editor), highlighter, (from, to, classes) => found.push(`${text.slice(from, to)}=${classes.replace(/tok-/g, "")}`));
  return found;
}

test("json and gltf", () => {
  for (const file of ["a.json", "a.gltf"]) {
    assert.deepEqual(highlighted(file, '{"asset": {"version": "2.0"}, "scene": 0, "on": [true, null]}'), [
      '"asset"=propertyName', '"version"=propertyName', '"2.0"=string', '"scene"=propertyName', "0=number",
      '"on"=propertyName', "true=bool", "null=keyword",
    ]);
  }
});

test("the XML encoding of X3D", () => {
  const found = highlighted("a.x3d", '<!-- note --><Sphere radius="2.5"/>');
  for (const expected of ["<!-- note -->=comment", "Sphere=typeName", "radius=propertyName", '"2.5"=string']) {
    assert.ok(found.includes(expected), `${expected} in ${found}`);
  }
});

test("languages have names", () => {
  assert.equal(languageName("a/b.CRT"), "CRT");
  assert.equal(languageName("b.wrl"), "VRML 97");
  assert.equal(languageName("constructor"), "Text");
});

test("a line of a megabyte is read in pieces", () => {
  const text = `values: ${"1 ".repeat(500_000)}`;
  const tree = StreamLanguage.define(tessera).parser.parse(text);
  assert.equal(tree.length, text.length);
});

/** What folds in each line of a file's text; nothing where a line has no block. */
function folds(file: string, text: string): (string | undefined)[] {
  const state = editorOf(file, text);
  return text.split("\n").map((_, index) => {
    const { from, to } = state.doc.line(index + 1);
    const range = foldable(state, from, to);
    return range ? text.slice(range.from, range.to) : undefined;
  });
}

test("blocks of braces and brackets fold", () => {
  assert.deepEqual(folds("a.tessera", 'nodes { shape {\n  # }\n  name: "}" sphere { radius: 1 }\n} }\nlast: [\n1 ]'), [
    ' shape {\n  # }\n  name: "}" sphere { radius: 1 }\n} ', undefined, undefined, undefined, "\n1 ", undefined,
  ]);
  assert.deepEqual(folds("a.crt", "if (a) {\n  b -- {\n} else {\n  c\n}"), ["\n  b -- {\n", undefined, "\n  c\n", undefined, undefined]);
  assert.deepEqual(folds("a.x3dv", 'Text {\n string [ "one\n]" ]\n}\nShape {'), ['\n string [ "one\n]" ]\n', ' "one\n]" ', undefined, undefined, undefined]);
  assert.deepEqual(folds("a.wrl", "Group { children [\n] }"), [" children [\n] ", undefined]);
});

test("punctuation is no element of its own", () => {
  const text = "a { b: 1 }";
  const found: string[] = [];
  highlightTree(StreamLanguage.define(tessera).parser.parse(text), highlighter, (from, to) => found.push(text.slice(from, to)));
  assert.deepEqual(found, ["a", "b", "1"]);
});
