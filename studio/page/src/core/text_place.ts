// Where a place of an older text is in the text as it is now.

import type { Text } from "@codemirror/state";
import type { DocumentSync } from "./document_sync.js";
import type { ChainLink } from "./protocol.js";

/** Lines and columns count from 1, in the text of that version. */
export type TextPlace = Pick<ChainLink, "version" | "column" | "end_line" | "end_column"> & { line: number };

function offsetIn(text: Text, line: number, column: number): number {
  const { from, to } = text.line(Math.min(Math.max(1, line), text.lines));
  return Math.min(from + Math.max(0, column - 1), to);
}

/** The offsets of a place in the text with all changes made; nothing where its version is not known. What was typed at its ends is outside. */
export function rangeNow(sync: DocumentSync, place: TextPlace): [from: number, to: number] | undefined {
  const { version = sync.version, line, column = 1, end_line: endLine = line, end_column: endColumn = column } = place;
  const since = sync.since(version);
  if (!since) return undefined;
  const from = since.changes.mapPos(offsetIn(since.text, line, column), 1);
  return [from, Math.max(from, since.changes.mapPos(offsetIn(since.text, endLine, endColumn), -1))];
}
