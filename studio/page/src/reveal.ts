// Bringing a place of a text before the eyes, and telling where the cursor stands.

import type { ChangeSet, EditorState, StateEffect } from "@codemirror/state";
import type { EditorView } from "@codemirror/view";
import { rangeNow, type TextPlace } from "./core/text_place.js";
import * as documents from "./documents.js";
import * as state from "./state.js";

/** Puts the cursor at a place, in the middle of the editor. The view stays: the place may be in what its scene includes. */
export function reveal(file: string, line: number, column: number, endLine = line, endColumn = column, focus = true): void {
  revealPlace(file, { line, column, end_line: endLine, end_column: endColumn }, focus);
}

/** The same of a place that was told of: what was typed since has moved it. One in a version that is not known any more is left. */
export function revealPlace(file: string, place: TextPlace, focus: boolean): void {
  const document = documents.find(file);
  if (!document) {
    revealing = { file, place, focus };
    documents.open(file, false);
    return;
  }
  documents.activate(file, false);
  const view = documents.editorView();
  const range = rangeNow(document.sync, place);
  if (!view || !range) return;
  const [anchor, head] = range.map((each) => Math.min(each, view.state.doc.length)) as [number, number];
  revealed = true;
  view.dispatch({ selection: { anchor, head }, effects: scrollTo(anchor) });
  if (focus) view.focus();
}

/** Brings the cursor before the eyes, where it stands. */
export function revealCursor(): void {
  const view = documents.editorView();
  view?.dispatch({ effects: scrollTo(view.state.selection.main.head) });
}

/** A place of a file that is still being opened. */
let revealing: { file: string; place: TextPlace; focus: boolean } | undefined;
let scrollTo: (position: number) => StateEffect<unknown>;

export function setScroll(effect: typeof scrollTo): void {
  scrollTo = effect;
}

export function revealPending(file: string): void {
  if (revealing?.file !== file) return;
  const { place, focus } = revealing;
  revealing = undefined;
  revealPlace(file, place, focus);
}

/** Selects what was added, without the blanks around it. */
export function selectInserted(changes: ChangeSet, editor: EditorView): void {
  let place: { anchor: number; head: number } | undefined;
  changes.iterChanges((_fromA, _toA, fromB, _toB, inserted) => {
    const text = inserted.toString();
    if (text.trim() === "") return;
    place ??= { anchor: fromB + text.length - text.trimStart().length, head: fromB + text.trimEnd().length };
  });
  if (!place) return;
  revealed = true;
  editor.dispatch({ selection: place, effects: scrollTo(place.anchor) });
}

/** Whether the cursor was put somewhere by what is not typing, since this was asked last. */
let revealed = false;
export function takeRevealed(): boolean {
  const was = revealed;
  revealed = false;
  return was;
}

export function noteCaret(editor: EditorState): void {
  const { main } = editor.selection;
  const start = editor.doc.lineAt(main.from);
  const end = editor.doc.lineAt(main.to);
  state.caret.value = {
    line: start.number,
    column: main.from - start.from + 1,
    endLine: end.number,
    endColumn: main.to - end.from + 1,
    length: main.to - main.from,
  };
}
