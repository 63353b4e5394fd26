// The classes of tokens, which studio.css gives their colours.

import { classHighlighter, type Highlighter } from "@lezer/highlight";

/** Punctuation has no class: it is half of all tokens, and with each frame the browser walks through all elements of
    the text, to tell input methods of it. */
export const highlighter: Highlighter = {
  style(tags) {
    const classes = classHighlighter.style(tags);
    return classes === "tok-punctuation" ? null : classes;
  },
};
