// The text formats that have no parser of their own among CodeMirror's packages.

import { wordParser } from "./words.js";

const NUMBER = /^[-+]?(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)[fF]?(?![\w.])/;
const WORD = /^[A-Za-z_][\w.]*/;

/** Protocol Buffers' text format, which `.tessera` files are. */
export const tessera = wordParser({
  name: "tessera",
  lineComments: ["#"],
  quotes: "\"'",
  number: NUMBER,
  word: WORD,
  classify(word, stream) {
    if (stream.match(/^\s*:/, false)) return "propertyName";
    if (stream.match(/^\s*[{<]/, false)) return "typeName";
    if (word === "true" || word === "false") return "bool";
    return /^[A-Z][A-Z0-9_]*$/.test(word) ? "atom" : "variableName";
  },
});

const CRT_BLOCKS = new Set(["Settings", "Scene", "Macro"]);
const CRT_WORDS = new Set(["if", "else", "while", "for", "return", "in"]);
const CRT_TRANSFORMS = new Set(["scale", "translate", "rotate"]);

/** CRT's scripts. */
export const crt = wordParser({
  name: "crt",
  lineComments: ["--"],
  quotes: "\"",
  number: /^(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])/,
  word: /^[A-Za-z_]\w*/,
  operators: /^(?:->|==|!=|<=|>=|&&|\|\||[-+*/%^<>=!&|])/,
  classify(word, stream) {
    if (CRT_BLOCKS.has(word)) return "keyword";
    if (CRT_WORDS.has(word)) return "controlKeyword";
    if (CRT_TRANSFORMS.has(word)) return "modifier";
    if (word === "true" || word === "false") return "bool";
    if (stream.match(/^\s*->/, false)) return "propertyName";
    if (/^[A-Z]/.test(word) && stream.match(/^\s*\{/, false)) return "typeName";
    if (stream.match(/^\s*\(/, false)) return "variableName.function";
    return stream.match(/^\s*=(?!=)/, false) ? "variableName.definition" : "variableName";
  },
});

const VRML_WORDS = new Set(["DEF", "USE", "PROTO", "EXTERNPROTO", "ROUTE", "TO", "IS", "PROFILE", "COMPONENT", "META", "IMPORT", "EXPORT"]);
const VRML_ACCESS = new Set(["eventIn", "eventOut", "field", "exposedField", "initializeOnly", "inputOnly", "outputOnly", "inputOutput"]);

/** VRML 97 and X3D in the classic encoding. */
export const vrml = wordParser({
  name: "vrml",
  lineComments: ["#"],
  quotes: "\"",
  multilineStrings: true,
  number: NUMBER,
  word: /^[A-Za-z_][^\s"'#,.{}[\]\\]*/,
  classify(word, stream, state) {
    if (VRML_WORDS.has(word)) return "keyword";
    if (VRML_ACCESS.has(word)) return "modifier";
    if (word === "TRUE" || word === "FALSE" || word === "NULL") return "bool";
    if (state.last === "DEF" || state.last === "USE") return "variableName.definition";
    return stream.match(/^\s*\{/, false) || /^[A-Z]/.test(word) ? "typeName" : "propertyName";
  },
});

/** Formats whose statements begin with a word on each line: .obj and .mtl. */
export const obj = wordParser({
  name: "obj",
  lineComments: ["#"],
  quotes: "",
  number: /^[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])/,
  word: /^[^\s#/]+/,
  classify(word, _stream, state) {
    if (state.words > 0) return word.startsWith("-") ? "modifier" : "string";
    return ["o", "g", "s", "usemtl", "newmtl", "mtllib", "usemap"].includes(word) ? "keyword" : "propertyName";
  },
});

/** Text .ply: a header of statements, then numbers. */
export const ply = wordParser({
  name: "ply",
  lineComments: ["comment", "obj_info"],
  quotes: "",
  number: NUMBER,
  word: /^\S+/,
  classify(word, _stream, state) {
    if (state.words === 0) return "keyword";
    return /^(?:u?char|u?short|u?int|float|double|list|u?int(?:8|16|32)|float(?:32|64))$/.test(word)
      ? "typeName"
      : "propertyName";
  },
});

/** Text .stl. */
export const stl = wordParser({
  name: "stl",
  lineComments: [],
  quotes: "",
  number: NUMBER,
  word: /^\S+/,
  classify(word, _stream, state) {
    if (/^(?:endsolid|solid|facet|endfacet|outer|loop|endloop)$/.test(word)) return "keyword";
    if (word === "normal" || word === "vertex") return "propertyName";
    return state.last === "solid" || state.last === "endsolid" ? "string" : "variableName";
  },
});
