// How the texts of the page are kept equal to the program's: what is typed goes there, what the program changes comes here.

import { isolateHistory } from "@codemirror/commands";
import { Transaction, type Text } from "@codemirror/state";
import { changeSetOf } from "./core/document_sync.js";
import { encode, type ProgramDocument, type ToPage, type ToProgram } from "./core/protocol.js";
import { sha256 } from "./core/sha256.js";
import * as documents from "./documents.js";
import type { OpenDocument } from "./documents.js";
import { rights } from "./editor/editor_state.js";
import * as program from "./program.js";
import { editWasSent, forgetEdits } from "./reading.js";
import { selectInserted } from "./reveal.js";
import * as state from "./state.js";

/** Takes what the program has of a text that is open here. */
export function restart(document: OpenDocument, message: ProgramDocument, text: Text): void {
  // A program that was started again has only what the disk has: what was typed here is newer.
  const keepMine = otherRun && document.dirty;
  const changes = document.sync.restart(message.version, text, keepMine);
  if (changes && !changes.empty) documents.apply(document, { changes, annotations: [documents.alreadyKnown.of(true), Transaction.userEvent.of("program.disk")] });
  const wasReadOnly = !document.editable || document.readOnly;
  Object.assign(document, {
    eol: message.eol,
    bom: message.bom,
    encoding: message.encoding,
    editable: message.editable,
    why: message.why,
    readOnly: message.read_only,
    // What was typed here is what the draft is of, or newer.
    draft: keepMine ? undefined : message.draft,
  });
  if (!message.dirty && !keepMine && document.sync.settled) document.saved = text;
  document.dirty = documents.isDirty(document);
  const isEditable = document.editable && !document.readOnly;
  if (wasReadOnly === isEditable) documents.apply(document, { effects: rights(document.file, isEditable) });
  scheduleFlush();
  documents.touched();
}

let flushDue = false;
/** Whether the program that is talked to is another run than the one that the texts come from. */
let otherRun = false;
let runId: string | undefined;

/** What `hello` says of the texts that the page has. */
export function greeting(): Omit<ToProgram["hello"], "token"> {
  const have: Record<string, [number, string]> = {};
  for (const each of documents.documents.peek()) have[each.file] = [each.sync.acknowledgedVersion, sha256(each.sync.acknowledgedText.toString())];
  return { ...(runId ? { resume: runId } : {}), have };
}

/** After `welcome`, which is followed by what the program has of the files that `hello` named. */
export function reopen(id: string): void {
  otherRun = runId !== undefined && runId !== id;
  runId = id;
  for (const each of documents.documents.peek()) waiting.add(each.file);
  documents.askAgain();
}

/** Files whose state at the program is not known since the connection was lost. */
const waiting = new Set<string>();

export function connectionLost(): void {
  forgetEdits();
  for (const each of documents.documents.peek()) {
    waiting.add(each.file);
    each.closesOnceSaved = false;
  }
}

/** The program does not take what was typed: it is not sent again before the text is another one. */
export function editRefused(file: string): void {
  const document = documents.find(file);
  if (document) document.refusedText = documents.stateOf(document).doc;
}

/** Whether the program takes a message as large as that; one that is larger would end the connection. */
function fits(message: ToProgram["edit"]): boolean {
  if (new TextEncoder().encode(encode("edit", message)).length <= state.mostOf("message")) return true;
  state.notify(`${message.file}: the last change is too large to be sent; undo it, or make it in smaller steps.`, "error");
  editRefused(message.file);
  return false;
}

/** Whether the program has refused the text as it is now. */
export function isRefused(document: OpenDocument): boolean {
  return document.refusedText === documents.stateOf(document).doc;
}

export function settle(file: string): void {
  waiting.delete(file);
  // What the program has of the text is taken in first.
  const due = afterSettling.get(file);
  if (due && afterSettling.delete(file)) setTimeout(due);
}

/** What is done once it is known what the program has of a file. */
const afterSettling = new Map<string, () => void>();

/** Does it once that is known: at once where it is. The last that waits for a file replaces the one before. */
export function whenSettled(file: string, what: () => void): void {
  if (waiting.has(file) && program.isConnected()) afterSettling.set(file, what);
  else what();
}

/** The version that the last change of the program made, which tells whether anything was typed since. */
let lastProgramVersion = -1;

/** Whether a text is as the last change of the program left it. */
export function isUntouched(file: string): boolean {
  return documents.find(file)?.sync.version === lastProgramVersion;
}

/** What the program proposes: one transaction of the editor, which is then sent as any other. */
export function receiveChange(message: ToPage["change"], continues = false, goThere = false): void {
  const document = documents.find(message.file);
  if (!document) return;
  if (document.sync.hasPending || document.sync.sentVersion !== message.base) {
    state.notify(`“${message.why}” came too late: the text has changed since.`, "error");
    return;
  }
  const changes = changeSetOf(message.changes, documents.stateOf(document).doc.length);
  if (!changes) return;
  documents.apply(document, {
    changes,
    // The history joins what is composed to what came before.
    annotations: continues
      ? Transaction.userEvent.of("input.type.compose")
      : [Transaction.userEvent.of(`program.${message.why}`), isolateHistory.of("before")],
  });
  lastProgramVersion = document.sync.version;
  const view = documents.editorView();
  if (goThere && document === documents.active() && view) selectInserted(changes, view);
}

/** Sends what was typed with the next frame. */
export function scheduleFlush(): void {
  if (flushDue) return;
  flushDue = true;
  let done = false;
  const once = () => {
    if (done) return;
    done = true;
    flushDue = false;
    flush();
  };
  requestAnimationFrame(once);
  // Pages that are not seen get no frames.
  setTimeout(once, 100);
}

/** Sends what was typed. */
export function flush(): void {
  if (!program.isConnected()) return;
  for (const document of documents.documents.peek()) {
    if (waiting.has(document.file) || document.readOnly || isRefused(document)) continue;
    const edit = document.sync.take((due) => fits({ file: document.file, ...due }));
    if (!edit) continue;
    program.send("edit", { file: document.file, ...edit });
    editWasSent(document.file, document.sync.sentVersion);
  }
}

export function receiveEdited(message: ToPage["edited"]): void {
  const document = documents.find(message.file);
  if (!document) return;
  if (waiting.has(message.file)) {
    document.sync.resume(message.version);
    settle(message.file);
    scheduleFlush();
  } else document.sync.acknowledge(message.version);
}

