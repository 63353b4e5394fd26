// Bringing a place of a text before the eyes, and telling where the cursor stands.

import type { ChangeSet, EditorState, StateEffect } from "@codemirror/state";
import type { EditorView } from "@codemirror/view";
import * as documents from "./documents.js";
import * as state from "./state.js";

/** Puts the cursor at a place, in the middle of the editor. The view stays: the place may be in what its scene includes. */
export function reveal(file: string, line: number, column: number, endLine = line, endColumn = column, focus = true): void {
  if (!documents.find(file)) {
    revealing = { file, line, column, endLine, endColumn, focus };
    documents.open(file, false);
    return;
  }
  documents.activate(file, false);
  const view = documents.editorView();
  if (!view) return;
  const at = (l: number, c: number) => {
    const { from, to } = view.state.doc.line(Math.min(Math.max(1, l), view.state.doc.lines));
    return Math.min(from + Math.max(0, c - 1), to);
  };
  const anchor = at(line, column);
  const head = at(endLine, endColumn);
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
let revealing: { file: string; line: number; column: number; endLine: number; endColumn: number; focus: boolean } | undefined;
let scrollTo: (position: number) => StateEffect<unknown>;

export function setScroll(effect: typeof scrollTo): void {
  scrollTo = effect;
}

export function revealPending(file: string): void {
  if (revealing?.file !== file) return;
  const { line, column, endLine, endColumn, focus } = revealing;
  revealing = undefined;
  reveal(file, line, column, endLine, endColumn, focus);
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
