// Problems in the text: they go at the first key and come 400 ms after the last, and no line ever moves for them.

import { setDiagnostics, type Diagnostic } from "@codemirror/lint";
import type { EditorView } from "@codemirror/view";
import { EditorSelection, type Text } from "@codemirror/state";
import type { Problem } from "../core/protocol.js";
import * as documents from "../documents.js";
import * as state from "../state.js";

const AFTER_LAST_KEY_MS = 400;

let quietAt = 0;
let due: ReturnType<typeof setTimeout> | undefined;

/** To be called for every change of a text. */
export function textWasTyped(): void {
  quietAt = performance.now() + AFTER_LAST_KEY_MS;
  if (state.problems.peek().length > 0) state.problems.value = [];
  later();
}

/** To be called when the program has told of problems. */
export function problemsCame(): void {
  later();
}

function later(): void {
  clearTimeout(due);
  due = setTimeout(show, Math.max(0, quietAt - performance.now()));
}

function show(): void {
  const list: Problem[] = [];
  // An answer about another text than the one that stands here would mark wrong places.
  const stands = (file: string, version: number) => (documents.find(file)?.sync.version ?? version) === version;
  for (const [file, known] of state.knownProblems.peek()) {
    if (stands(file, known.version)) list.push(...known.list.filter((each) => stands(each.file, each.version)));
  }
  // Another list of nothing would have all draw themselves anew that show it.
  if (list.length > 0 || state.problems.peek().length > 0) state.problems.value = list;
}

/** The words of a problem, in the order in which they help. */
export function wordsOf(problem: Problem): string {
  const words = [problem.message];
  if (problem.found && !problem.message.includes(problem.found)) words.push(`found ${problem.found}`);
  if (problem.expected && !problem.message.includes(problem.expected)) words.push(`expected ${problem.expected}`);
  return words.join("; ");
}

/** The offsets of a problem; at least one character is marked, so that it is seen. */
export function rangeOf(text: Text, problem: Problem): { from: number; to: number } {
  const at = (line: number, column: number) => {
    if (line < 1) return 0;
    if (line > text.lines) return text.length;
    const { from, to } = text.line(line);
    return Math.min(from + Math.max(0, column - 1), to);
  };
  const from = at(problem.line, problem.column);
  const to = Math.max(from, at(problem.end_line ?? problem.line, problem.end_column ?? problem.column));
  if (to > from) return { from, to };
  const line = text.lineAt(from);
  // Where no end is known, the word that begins there.
  const word = /^[\w.]+/.exec(text.sliceString(from, Math.min(line.to, from + 200)));
  if (word) return { from, to: from + word[0].length };
  return from < line.to ? { from, to: from + 1 } : { from: Math.max(line.from, from - 1), to: from };
}

export function markProblems(view: EditorView): void {
  const file = state.activeFile.peek();
  const { doc } = view.state;
  const diagnostics: Diagnostic[] = state.problems
    .peek()
    .filter((problem) => problem.file === file)
    .map((problem) => ({
      ...rangeOf(doc, problem),
      severity: problem.severity,
      message: wordsOf(problem),
      actions: problem.suggestion
        ? [{ name: `Replace by “${problem.suggestion}” (Ctrl-.)`, apply: () => fix(problem) }]
        : [],
    }));
  diagnostics.sort((a, b) => a.from - b.from || a.to - b.to);
  view.dispatch(setDiagnostics(view.state, diagnostics));
}

/** Puts what the program suggests in place of what it found. */
export function fix(problem: Problem): void {
  const document = documents.find(problem.file);
  if (!document || problem.suggestion === undefined) return;
  const { from, to } = rangeOf(documents.stateOf(document).doc, problem);
  documents.apply(document, {
    changes: { from, to, insert: problem.suggestion },
    selection: EditorSelection.cursor(from + problem.suggestion.length),
    userEvent: "input.fix",
  });
}

/** Fixes the problem with a suggestion that stands nearest to the cursor. */
export function fixNearest(): boolean {
  const file = state.activeFile.peek();
  const { line } = state.caret.peek();
  const candidates = state.problems.peek().filter((each) => each.file === file && each.suggestion !== undefined);
  candidates.sort((a, b) => Math.abs(a.line - line) - Math.abs(b.line - line));
  if (!candidates[0]) return false;
  fix(candidates[0]);
  return true;
}
