// Parsers that read a line word by word. They follow nothing but braces, so that a key costs a line.

import type { StreamParser, StringStream } from "@codemirror/language";

export interface WordState {
  depth: number;
  /** What ends the comment or string that a line was left in. */
  until: string | undefined;
  kind: "comment" | "string";
  /** Words since the line began. */
  words: number;
  /** The last word, for languages where it tells what follows. */
  last: string;
}

export interface WordRules {
  name: string;
  lineComments: string[];
  blockComment?: [open: string, close: string];
  quotes: string;
  multilineStrings?: boolean;
  number: RegExp;
  word: RegExp;
  /** The token of a word, as @lezer/highlight names it. */
  classify(word: string, stream: StringStream, state: WordState): string | null;
  operators?: RegExp;
}

/** The parser of a language by its words. */
export function wordParser(rules: WordRules): StreamParser<WordState> {
  return {
    name: rules.name,
    startState: () => ({ depth: 0, until: undefined, kind: "comment", words: 0, last: "" }),
    copyState: (state) => ({ ...state }),
    token: (stream, state) => token(rules, stream, state),
    blankLine: (state) => {
      state.words = 0;
    },
    indent(state, textAfter, context) {
      const closing = /^\s*[}\])>]/.test(textAfter);
      return Math.max(0, state.depth - (closing ? 1 : 0)) * context.unit;
    },
    languageData: {
      commentTokens: {
        ...(rules.lineComments[0] ? { line: rules.lineComments[0] } : {}),
        ...(rules.blockComment ? { block: { open: rules.blockComment[0], close: rules.blockComment[1] } } : {}),
      },
      closeBrackets: { brackets: ["(", "[", "{", ...rules.quotes] },
      multilineStrings: rules.multilineStrings ?? false,
      indentOnInput: /^\s*[}\])]$/,
    },
  };
}

function token(rules: WordRules, stream: StringStream, state: WordState): string | null {
  if (stream.sol()) {
    state.words = 0;
    if (state.until) return finish(stream, state);
  }
  if (stream.eatSpace()) return null;
  for (const comment of rules.lineComments) {
    if (stream.match(comment)) {
      stream.skipToEnd();
      return "comment";
    }
  }
  if (rules.blockComment && stream.match(rules.blockComment[0])) {
    state.until = rules.blockComment[1];
    state.kind = "comment";
    return finish(stream, state);
  }
  const next = stream.peek()!;
  if (rules.quotes.includes(next)) {
    stream.next();
    return string(rules, stream, state, next);
  }
  if (stream.match(rules.number)) {
    ++state.words;
    return "number";
  }
  const word = stream.match(rules.word) as RegExpMatchArray | null;
  if (word) {
    const kind = rules.classify(word[0], stream, state);
    ++state.words;
    state.last = word[0];
    return kind;
  }
  return punctuation(rules, stream, state);
}

function punctuation(rules: WordRules, stream: StringStream, state: WordState): string | null {
  if (rules.operators && stream.match(rules.operators)) return "operator";
  const character = stream.next()!;
  if ("{[(".includes(character)) ++state.depth;
  else if ("}])".includes(character)) state.depth = Math.max(0, state.depth - 1);
  return "{}[]()".includes(character) ? "bracket" : "punctuation";
}

function string(rules: WordRules, stream: StringStream, state: WordState, quote: string): string {
  for (let escaped = false; ; ) {
    const character = stream.next();
    if (character === undefined || character === null) {
      if (rules.multilineStrings) {
        state.until = quote;
        state.kind = "string";
      }
      break;
    }
    if (character === quote && !escaped) break;
    escaped = character === "\\" && !escaped;
  }
  ++state.words;
  return "string";
}

function finish(stream: StringStream, state: WordState): string {
  const { kind } = state;
  if (stream.skipTo(state.until!)) {
    for (let i = 0; i < state.until!.length; ++i) stream.next();
    state.until = undefined;
  } else stream.skipToEnd();
  return kind;
}
