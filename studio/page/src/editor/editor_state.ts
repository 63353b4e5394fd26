// The editor's state for one file: everything that belongs to text alone.

import { type ChangeDesc, Compartment, EditorState, type Extension, type StateEffect, type Text } from "@codemirror/state";
import {
  EditorView,
  crosshairCursor,
  drawSelection,
  dropCursor,
  highlightActiveLine,
  highlightActiveLineGutter,
  highlightSpecialChars,
  keymap,
  lineNumbers,
  rectangularSelection,
} from "@codemirror/view";
import {
  bracketMatching,
  codeFolding,
  foldGutter,
  foldKeymap,
  indentOnInput,
  indentUnit,
  syntaxHighlighting,
} from "@codemirror/language";
import { defaultKeymap, history, historyKeymap, indentWithTab, redo, undo } from "@codemirror/commands";
import { findNext, findPrevious, gotoLine, highlightSelectionMatches, openSearchPanel, search, searchKeymap } from "@codemirror/search";
import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap, startCompletion } from "@codemirror/autocomplete";
import { lintGutter, lintKeymap } from "@codemirror/lint";
import { highlighter } from "../languages/highlighter.js";
import { languageOf } from "../languages/language_of.js";
import { ruler } from "./ruler.js";
import { overview } from "./overview.js";
import { completions } from "./completions.js";
import * as state from "../state.js";

let listener: Extension = [];

/** What hears of changes in every editor state; to be set before the first is made. */
export function setListener(extension: Extension): void {
  listener = extension;
}

/** What the file indents with: a tab, or as many spaces as its least indented line has. */
export function indentOf(text: Text): string {
  let least = 0;
  let lines = 0;
  for (const line of text.iterLines()) {
    if (++lines > 400) break;
    if (line.startsWith("\t")) return "\t";
    const spaces = /^ +(?=\S)/.exec(line)?.[0].length ?? 0;
    if (spaces >= 2 && (least === 0 || spaces < least)) least = spaces;
  }
  return " ".repeat(least >= 2 && least <= 8 ? least : 4);
}

function nonce(): string {
  return document.querySelector<HTMLMetaElement>('meta[name="csp-nonce"]')?.content ?? "";
}

/** What commands of the page do, whose keys can be changed. */
const COMMANDS: unknown[] = [undo, redo, openSearchPanel, findNext, findPrevious, gotoLine, startCompletion];

const keys = keymap.of(
  [
    ...closeBracketsKeymap,
    ...defaultKeymap.filter((binding) => binding.key !== "Mod-Enter"),
    ...searchKeymap,
    ...historyKeymap,
    ...foldKeymap,
    ...completionKeymap,
    ...lintKeymap,
    indentWithTab,
  ].filter((binding) => !COMMANDS.includes(binding.run)),
);

/** The state of an editor that shows no file. */
export function emptyState(): EditorState {
  return EditorState.create({ extensions: [EditorView.cspNonce.of(nonce()), EditorState.readOnly.of(true)] });
}

const rightsOf = new Compartment();

function extensionsOfRights(file: string, editable: boolean): Extension {
  return [
    EditorState.readOnly.of(!editable),
    EditorView.contentAttributes.of({
      "aria-label": `${file}, script. Tab indents; Escape, then Tab leaves the editor.`,
      tabindex: "0",
      "aria-readonly": String(!editable),
    }),
  ];
}

/** What gives an editor of the file another right to edit, with its history kept. */
export function rights(file: string, editable: boolean): StateEffect<unknown> {
  return rightsOf.reconfigure(extensionsOfRights(file, editable));
}

/** Refuses, with words, a change after which the text is larger than the program takes, whose bytes are at least as many. */
function mayGrow({ length, newLength }: ChangeDesc): boolean {
  const most = state.mostOf("text");
  if (newLength <= length || newLength <= most) return true;
  state.notify(`The text would have ${newLength} characters; expected at most ${most}.`, "error");
  return false;
}

/** The state that a file's text begins with; `selection` may be of a longer text. */
export function editorState(file: string, text: Text, editable: boolean, selection: [anchor: number, head: number] = [0, 0]): EditorState {
  const [anchor, head] = selection.map((each) => Math.min(each, text.length)) as [number, number];
  return EditorState.create({
    doc: text,
    selection: { anchor, head },
    extensions: [
      EditorView.cspNonce.of(nonce()),
      // The program has texts with \n alone; whatever else a paste brings is no end of a line.
      EditorState.lineSeparator.of("\n"),
      EditorView.clipboardInputFilter.of((pasted) => pasted.replace(/\r\n?/g, "\n").replaceAll("\0", "")),
      EditorState.changeFilter.of(({ changes }) => mayGrow(changes)),
      EditorState.allowMultipleSelections.of(true),
      rightsOf.of(extensionsOfRights(file, editable)),
      EditorState.tabSize.of(4),
      indentUnit.of(indentOf(text)),
      listener,
      lintGutter(),
      lineNumbers({ formatNumber: (number) => String(number) }),
      foldGutter(),
      codeFolding(),
      highlightActiveLineGutter(),
      highlightSpecialChars(),
      history({ minDepth: 10000 }),
      drawSelection({ cursorBlinkRate: matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 1200 }),
      dropCursor(),
      rectangularSelection(),
      crosshairCursor(),
      highlightActiveLine(),
      highlightSelectionMatches({ minSelectionLength: 2 }),
      indentOnInput(),
      bracketMatching(),
      closeBrackets(),
      completions(file),
      autocompletion({ icons: false, maxRenderedOptions: 60 }),
      search({ top: true }),
      syntaxHighlighting(highlighter),
      languageOf(file),
      ruler(120),
      overview(),
      keys,
    ],
  });
}
