// Saving texts, and what becomes of them when their files change or a draft was left.

import { isolateHistory } from "@codemirror/commands";
import { Transaction, type Text } from "@codemirror/state";
import { differenceOf, textOf } from "./core/document_sync.js";
import type { ToPage } from "./core/protocol.js";
import * as documents from "./documents.js";
import type { OpenDocument } from "./documents.js";
import { isRefused, whenSettled } from "./exchange.js";
import * as program from "./program.js";
import * as state from "./state.js";
import { seeAlike } from "./view/scenes.js";

/** Saves a file, under another name where one is given. `closes`: it is closed once that is done. */
export function save(file: string, as?: string, closes = false): void {
  saveRefused(file);
  if (as === undefined && documents.find(file)?.disk === "changed") {
    state.notify(`${file} was changed on the disk: choose above its text.`, "error");
  } else whenSettled(file, () => saveNow(file, as, closes));
}

function saveNow(file: string, as: string | undefined, closes: boolean): void {
  documents.flush();
  const document = documents.find(file);
  if (document && isRefused(document)) {
    state.notify(`${file} is not saved: the program has refused its last change; undo that first.`, "error");
    return;
  }
  const force = document?.force && as === undefined;
  if (!program.send("save", { file, ...(as === undefined ? {} : { as }), ...(force ? { force } : {}) })) {
    state.notify("Not saved: there is no connection to the program. The text is kept here.", "error");
  } else if (document) document.closesOnceSaved = closes;
}

/** A file that is not saved stays open. */
export function saveRefused(file: string): void {
  const document = documents.find(file);
  if (document) document.closesOnceSaved = false;
}

export function receiveSaved(message: ToPage["saved"]): void {
  if (message.as !== undefined) {
    state.notify(`Saved ${message.as}`);
    seeAlike(message.file, message.as);
    documents.open(message.as);
    program.send("list", {});
    return;
  }
  const document = documents.find(message.file);
  if (!document) return;
  document.disk = "same";
  document.diskText = undefined;
  document.force = false;
  document.sync.acknowledge(message.version);
  if (message.version === document.sync.version) document.saved = documents.stateOf(document).doc;
  const wasDirty = document.dirty;
  document.dirty = documents.isDirty(document);
  if (wasDirty) state.notify(`Saved ${message.file}`);
  documents.touched();
  const { closesOnceSaved } = document;
  document.closesOnceSaved = false;
  if (closesOnceSaved && !document.dirty) documents.close(message.file);
}

/** What happened to the file: a text that has no changes of its own follows it. */
export function receiveDisk(message: ToPage["disk"]): void {
  const document = documents.find(message.file);
  if (!document) return;
  document.disk = message.state;
  // What was chosen was chosen of what the disk had then.
  document.force = false;
  document.diskText = message.text;
  const follows = !document.dirty || document.reloading;
  if (message.state === "changed" && message.text !== undefined && follows && !document.readOnly) takeDiskText(document);
  documents.touched();
}

function takeDiskText(document: OpenDocument): void {
  if (document.diskText === undefined) return;
  const text = textOf(document.diskText);
  document.disk = "same";
  document.diskText = undefined;
  document.reloading = false;
  document.saved = text;
  replaceText(document, text, "program.disk");
  document.dirty = documents.isDirty(document);
}

/** Makes a text of another, as one change that can be undone. */
function replaceText(document: OpenDocument, text: Text, event: string): void {
  const changes = differenceOf(documents.stateOf(document).doc, text);
  if (changes.empty) return;
  documents.apply(document, { changes, annotations: [Transaction.userEvent.of(event), isolateHistory.of("full")] });
}

export function loadTheirs(file: string): void {
  const document = documents.find(file);
  if (!document) return;
  if (document.diskText !== undefined) {
    takeDiskText(document);
    documents.touched();
    return;
  }
  document.reloading = true;
  program.send("reload", { file });
}

export function keepMine(file: string): void {
  const document = documents.find(file);
  if (!document) return;
  document.disk = "same";
  document.diskText = undefined;
  document.force = true;
  documents.touched();
}

/** Takes up the text that was never saved, as a change that can be undone, or has it thrown away. */
export function recover(file: string, take: boolean): void {
  const document = documents.find(file);
  if (!document?.draft) return;
  program.send("recover", { file, take });
  if (take) replaceText(document, textOf(document.draft.text), "program.recovery");
  document.draft = undefined;
  documents.touched();
}

export function receiveDraft({ file, ...draft }: ToPage["draft"]): void {
  const document = documents.find(file);
  if (!document) return;
  document.draft = draft;
  documents.touched();
}

/** Keeps the draft for another time: neither taken nor thrown away. */
export function postponeDraft(file: string): void {
  const document = documents.find(file);
  if (!document) return;
  document.draft = undefined;
  documents.touched();
}
