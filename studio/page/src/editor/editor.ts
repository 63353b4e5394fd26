// The one editor of the page, which shows the document of the tab that is on top.

import { EditorView, type ViewUpdate } from "@codemirror/view";
import * as documents from "../documents.js";
import * as state from "../state.js";
import { markProblems, textWasTyped } from "./problem_marks.js";
import { emptyState, setListener } from "./editor_state.js";

/** Makes the editor, in an element of its own that panels show. */
export function makeEditor(): HTMLElement {
  setListener(EditorView.updateListener.of(heard));
  const host = document.createElement("div");
  host.className = "editor";
  const view = new EditorView({ state: emptyState(), parent: host });
  documents.setEditorView(view);
  documents.setScroll((position) => EditorView.scrollIntoView(position, { y: "center" }));
  state.problems.subscribe(() => markProblems(view));
  state.activeFile.subscribe(() => markProblems(view));
  return host;
}

function heard(update: ViewUpdate): void {
  for (const transaction of update.transactions) {
    if (!transaction.docChanged) continue;
    documents.editorChanged(transaction.changes, transaction.annotation(documents.alreadyKnown) === true);
    textWasTyped();
  }
  if (update.selectionSet || update.docChanged) documents.noteCaret(update.state);
}
