// Folding of what stands between brackets, for languages that are read word by word.

import { foldService } from "@codemirror/language";
import type { EditorState, Extension } from "@codemirror/state";

const CLOSING: Record<string, string> = { "{": "}", "[": "]", "(": ")" };
/** How far the end of a block is looked for, which is done for each line that is seen. */
const FARTHEST = 500_000;

/** What a language says of itself where a text is looked at, as far as it matters here. */
interface Syntax {
  lineComment: string | undefined;
  quotes: string;
  multilineStrings: boolean;
}

function syntaxAt(state: EditorState, position: number): Syntax {
  const [comments] = state.languageDataAt<{ line?: string }>("commentTokens", position);
  const [closing] = state.languageDataAt<{ brackets?: string[] }>("closeBrackets", position);
  const [multilineStrings = false] = state.languageDataAt<boolean>("multilineStrings", position);
  const quotes = (closing?.brackets ?? []).filter((each) => !(each in CLOSING)).join("");
  return { lineComment: comments?.line, quotes, multilineStrings };
}

/** Finds comments, strings and brackets; a string that a line ends is one too. */
function partsOf({ lineComment, quotes }: Syntax): RegExp {
  const parts = [...quotes].map((quote) => `${quote}(?:\\\\.|[^${quote}\\\\])*(?:${quote}|\\\\?$)`);
  if (lineComment) parts.unshift(`${lineComment}.*`);
  return new RegExp([...parts, "[{}\\[\\]()]"].join("|"), "g");
}

/** The first block that begins in a line and ends in a later one. */
function block(state: EditorState, start: number, end: number): { from: number; to: number } | null {
  const { doc } = state;
  const syntax = syntaxAt(state, start);
  const parts = partsOf(syntax);
  /** The brackets that are open, the outermost first. */
  const open: { at: number; closing: string }[] = [];
  /** The quote that ends the string in which a line begins. */
  let until = "";
  let from = start;
  for (const line of doc.iterLines(doc.lineAt(start).number)) {
    parts.lastIndex = 0;
    if (until) {
      const ends = line.indexOf(until);
      parts.lastIndex = ends < 0 ? line.length : ends + 1;
      if (ends >= 0) until = "";
    }
    for (let found; (found = parts.exec(line)); ) {
      const [part] = found;
      const first = part[0]!;
      const at = from + found.index;
      if (part.length === 1 && first in CLOSING) open.push({ at, closing: CLOSING[first]! });
      else if (syntax.quotes.includes(first)) {
        const isOpen = found.index + part.length === line.length && (part.length === 1 || !part.endsWith(first));
        if (isOpen && syntax.multilineStrings) until = first;
      } else if (open.length > 0 && part === open[open.length - 1]!.closing) {
        const { at: began } = open.pop()!;
        if (open.length === 0 && at > end) return { from: began + 1, to: at };
      }
    }
    from += line.length + 1;
    if (from > end && open.length === 0) return null;
    if (from - start > FARTHEST) return null;
  }
  return null;
}

export const bracketFolding: Extension = foldService.of(block);
