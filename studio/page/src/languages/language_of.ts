import { StreamLanguage, type StreamParser } from "@codemirror/language";
import { json } from "@codemirror/lang-json";
import { xml } from "@codemirror/lang-xml";
import type { Extension } from "@codemirror/state";
import { endingOf } from "../core/paths.js";
import { bracketFolding } from "./folding.js";
import { crt, obj, ply, stl, tessera, vrml } from "./parsers.js";

interface Language {
  name: string;
  make: () => Extension;
}

function stream<State>(name: string, parser: StreamParser<State>, folding: Extension = []): Language {
  let language: Extension | undefined;
  return { name, make: () => (language ??= [StreamLanguage.define(parser), folding]) };
}

const JSON_LANGUAGE: Language = { name: "JSON", make: json };
const XML_LANGUAGE: Language = { name: "X3D (XML)", make: () => xml() };
const CLASSIC = stream("X3D classic", vrml, bracketFolding);

const LANGUAGES: Record<string, Language> = {
  tessera: stream("Tessera", tessera, bracketFolding),
  crt: stream("CRT", crt, bracketFolding),
  json: JSON_LANGUAGE,
  gltf: { name: "glTF", make: json },
  x3d: XML_LANGUAGE,
  x3dv: CLASSIC,
  wrl: { name: "VRML 97", make: CLASSIC.make },
  obj: stream("OBJ", obj),
  mtl: stream("MTL", obj),
  ply: stream("PLY", ply),
  stl: stream("STL", stl),
};

/** How a file is highlighted; nothing for what is no known text. */
export function languageOf(file: string): Extension {
  const ending = endingOf(file);
  return Object.hasOwn(LANGUAGES, ending) ? LANGUAGES[ending]!.make() : [];
}

/** The language's name for the status bar. */
export function languageName(file: string): string {
  const ending = endingOf(file);
  return Object.hasOwn(LANGUAGES, ending) ? LANGUAGES[ending]!.name : "Text";
}
