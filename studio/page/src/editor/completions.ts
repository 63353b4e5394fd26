// What the editor proposes while someone types, and says of the word under the pointer: the program knows the
// language; where it does not answer, the words of the file are proposed.

import type { Extension } from "@codemirror/state";
import { EditorState } from "@codemirror/state";
import { completionStatus, type CompletionContext, type CompletionResult } from "@codemirror/autocomplete";
import { EditorView, hoverTooltip, type Tooltip } from "@codemirror/view";
import type { Completions } from "../core/protocol.js";
import { candidates, picturesFor } from "../models.js";
import { ask } from "../questions.js";

const LARGEST_TEXT = 500_000;

function wordsOfFile(context: CompletionContext): CompletionResult | null {
  const word = context.matchBefore(/[A-Za-z_]\w*/);
  if ((!word || word.to - word.from < 2) && !context.explicit) return null;
  if (context.state.doc.length > LARGEST_TEXT) return null;
  const from = word?.from ?? context.pos;
  const words = new Set<string>();
  const text = context.state.doc.toString();
  for (const match of text.matchAll(/[A-Za-z_]\w{2,}/g)) {
    if (match.index !== from) words.add(match[0]);
  }
  return { from, options: [...words].map((label) => ({ label, type: "text" })), validFor: /^\w*$/ };
}

/** Names of the folder's files that fit the place, as the file there says them. */
function namesOfFiles(file: string, answer: Completions): CompletionResult {
  const names = answer.files === "model" ? candidates(file) : picturesFor(file);
  const options = names.map((label) => ({ label, apply: answer.quoted ? `"${label}"` : label, detail: answer.files! }));
  return { from: answer.from, to: answer.to, options, validFor: /^[^"'\n]*$/ };
}

async function wordsOfProgram(file: string, context: CompletionContext): Promise<CompletionResult | null> {
  // Properties change the text too, while nobody types in it.
  if (!context.explicit && !context.view?.hasFocus) return null;
  if (!context.explicit && !context.matchBefore(/[A-Za-z_"']\w*/)) return null;
  const answer = await ask("complete", file, { offset: context.pos });
  if (context.aborted) return null;
  if (answer?.files) return namesOfFiles(file, answer);
  if (!answer || answer.items.length === 0) return wordsOfFile(context);
  const options = answer.items.map((each) => ({
    label: each.label,
    apply: each.insert,
    ...(each.detail ? { detail: each.detail } : {}),
    ...(each.help ? { info: each.help } : {}),
  }));
  // Before a word nothing of it is typed yet: all is proposed, and the word stays.
  const to = answer.from === context.pos ? context.pos : Math.max(answer.to, context.pos);
  return { from: answer.from, to, options, validFor: /^[\w.-]*$/ };
}

function line(host: HTMLElement, className: string, text: string | undefined): void {
  if (!text) return;
  const element = host.appendChild(document.createElement("div"));
  element.className = className;
  element.textContent = text;
}

async function explain(file: string, position: number): Promise<Tooltip | null> {
  const answer = await ask("hover", file, { offset: position });
  if (answer?.from === undefined) return null;
  return {
    pos: answer.from,
    end: answer.to ?? answer.from,
    above: true,
    create() {
      const dom = document.createElement("div");
      dom.className = "explained";
      line(dom, "title", answer.title);
      line(dom, "detail", answer.detail);
      line(dom, "help", answer.help);
      return { dom };
    },
  };
}

/** The list of completions scrolls: keys reach it by Tab, as every region that scrolls. */
const focusableList = EditorView.updateListener.of(({ state, view }) => {
  if (completionStatus(state) !== "active") return;
  view.requestMeasure({
    key: "focusable list",
    read: () => view.dom.querySelector<HTMLElement>(".cm-tooltip-autocomplete > ul"),
    write: (list) => list && (list.tabIndex = 0),
  });
});

export function completions(file: string): Extension {
  // One function for all times: answers are told apart by who gave them.
  const autocomplete = (context: CompletionContext) => wordsOfProgram(file, context);
  const data = [{ autocomplete }];
  return [
    EditorState.languageData.of(() => data),
    focusableList,
    hoverTooltip((_view, position) => explain(file, position), { hideOnChange: true }),
  ];
}
