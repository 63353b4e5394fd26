// The open files: their texts, with history and selection.

import { signal } from "@preact/signals";
import { Annotation, type ChangeSet, type EditorState, type Text, type TransactionSpec } from "@codemirror/state";
import type { EditorView } from "@codemirror/view";
import { DocumentSync, textOf } from "./core/document_sync.js";
import { isScene } from "./core/paths.js";
import type { Draft, ProgramDocument } from "./core/protocol.js";
import { editorState, emptyState } from "./editor/editor_state.js";
import { restart, scheduleFlush } from "./exchange.js";
import * as measures from "./measures.js";
import * as program from "./program.js";
import { noteCaret, revealCursor } from "./reveal.js";
import * as state from "./state.js";
import { showScene } from "./view/scenes.js";

export { connectionLost, editRefused, flush, greeting, isUntouched, receiveChange, receiveEdited, reopen, settle } from "./exchange.js";
export { noteCaret, reveal, revealPending, revealPlace, setScroll } from "./reveal.js";
export { keepMine, loadTheirs, postponeDraft, receiveDisk, receiveDraft, receiveSaved, recover, save, saveRefused } from "./saving.js";

export interface OpenDocument {
  file: string;
  sync: DocumentSync;
  editor: EditorState;
  /** The text of the file; unknown where the program had changes already. */
  saved: Text | undefined;
  language: string;
  eol: string;
  bom: boolean;
  encoding: string;
  editable: boolean;
  why?: string;
  readOnly: boolean;
  dirty: boolean;
  disk: "same" | "changed" | "deleted";
  diskText?: string;
  draft?: Draft;
  /** The text whose last change the program has refused. */
  refusedText?: Text;
  /** Whether the next save goes over what another program wrote. */
  force: boolean;
  /** Whether the file is closed once the save that is under way has succeeded. */
  closesOnceSaved: boolean;
  /** Whether the text of the disk is taken whatever was typed. */
  reloading: boolean;
}

/** In the order of their tabs. */
export const documents = signal<OpenDocument[]>([]);
/** Counts up whenever something of a document changes that panels show. */
export const revision = signal(0);

let view: EditorView | undefined;
/** What becomes of a file that was asked for. */
interface Opening {
  /** It comes into the editor. */
  activates: boolean;
  /** The view is to show it. */
  shows: boolean;
}
const opening = new Map<string, Opening>();
/** Where the cursor stood in files that were open before. */
const keptSelections = new Map<string, [anchor: number, head: number]>();

export function isOpening(): boolean {
  return opening.size > 0;
}
/** Marks changes that the program made itself, which it is not to be sent again. */
export const alreadyKnown = Annotation.define<boolean>();

export function setEditorView(editor: EditorView): void {
  view = editor;
}

export function editorView(): EditorView | undefined {
  return view;
}

export function find(file: string | undefined): OpenDocument | undefined {
  return file === undefined ? undefined : documents.peek().find((each) => each.file === file);
}

export function active(): OpenDocument | undefined {
  return find(state.activeFile.peek());
}

export function touched(): void {
  ++revision.value;
}

/** Files whose changes the program, which was not there, is to forget. */
const discarded = new Set<string>();

/** Asks a program that was not there for the files that are wanted, and tells it of those that are not. */
export function askAgain(): void {
  for (const file of discarded) program.send("close", { file, discard: true });
  discarded.clear();
  for (const file of opening.keys()) program.send("open", { file });
}

/** Brings a file into the editor, asking the program for it where it is not open. `shows`: the view turns to it. */
export function open(file: string, shows = true): void {
  if (find(file)) {
    activate(file, shows);
    return;
  }
  ask(file, { activates: true, shows });
}

function ask(file: string, how: Opening): void {
  opening.set(file, how);
  program.send("open", { file });
}

/** Opens what was open before, in the order of the tabs. */
export function restore(kept: { files: string[]; active: string | undefined; scene: string | undefined; selections: Record<string, [number, number]> }): void {
  for (const [file, selection] of Object.entries(kept.selections)) keptSelections.set(file, selection);
  const files = kept.active === undefined ? kept.files : [...new Set([...kept.files, kept.active])];
  for (const file of files) ask(file, { activates: file === kept.active, shows: file === kept.scene });
}

/** Where nothing that is still to come is to be in the editor, some file that is there is. */
function activateAny(): void {
  const first = documents.peek()[0];
  const isToCome = [...opening.values()].some((each) => each.activates);
  if (first && !isToCome && state.activeFile.peek() === undefined) activate(first.file, state.sceneFile.peek() === undefined);
}

/** The program cannot open it. */
export function openRefused(file: string): void {
  if (!opening.delete(file)) return;
  activateAny();
  touched();
}

export function activate(file: string, shows = true): void {
  const document = find(file);
  if (!document || !view) return;
  const before = active();
  // What a document that is shown had before it was shown is old.
  if (before) before.editor = view.state;
  if ((shows && isScene(file)) || state.sceneFile.peek() === undefined) showScene(file);
  state.activeFile.value = file;
  if (view.state !== document.editor) view.setState(document.editor);
  touched();
  noteCaret(view.state);
}

/** Closes a file; `discard`: the program forgets what was not saved. */
export function close(file: string, discard = false): void {
  const all = documents.peek();
  const index = all.findIndex((each) => each.file === file);
  if (index < 0) return;
  documents.value = all.filter((each) => each.file !== file);
  state.forgetOutline(file);
  if (!program.send("close", { file, ...(discard ? { discard } : {}) }) && discard) discarded.add(file);
  const rest = documents.peek();
  if (state.sceneFile.peek() === file) showScene(rest.find((each) => isScene(each.file))?.file);
  if (state.activeFile.peek() === file) {
    const next = rest[Math.min(index, rest.length - 1)];
    state.activeFile.value = undefined;
    if (next) activate(next.file);
    else view?.setState(emptyState());
  }
  touched();
}

/** The program's answer to `open`, or the text to start anew from. */
export function receive(message: ProgramDocument): void {
  const known = find(message.file);
  const text = textOf(message.text);
  if (known) {
    restart(known, message, text);
    return;
  }
  const document: OpenDocument = {
    file: message.file,
    sync: new DocumentSync(message.version, text),
    editor: editorState(message.file, text, message.editable && !message.read_only, keptSelections.get(message.file)),
    saved: message.dirty ? undefined : text,
    language: message.language,
    eol: message.eol,
    bom: message.bom,
    encoding: message.encoding,
    editable: message.editable,
    why: message.why,
    readOnly: message.read_only,
    dirty: message.dirty ?? false,
    disk: "same",
    draft: message.draft,
    force: false,
    closesOnceSaved: false,
    reloading: false,
  };
  documents.value = [...documents.peek(), document];
  const how = opening.get(message.file);
  opening.delete(message.file);
  if (how?.shows && !how.activates) showScene(message.file);
  if (how?.activates) activate(message.file, how.shows);
  if (how?.activates && keptSelections.has(message.file)) revealCursor();
  keptSelections.delete(message.file);
  activateAny();
  touched();
}

export function stateOf(document: OpenDocument): EditorState {
  return document === active() && view ? view.state : document.editor;
}

/** Makes a change of a text, whether the editor shows it or not. */
export function apply(document: OpenDocument, spec: TransactionSpec): void {
  const transaction = stateOf(document).update({ ...spec, filter: false });
  if (document === active() && view) view.dispatch(transaction);
  else {
    document.editor = transaction.state;
    if (transaction.docChanged) noteChanges(document, transaction.changes, transaction.annotation(alreadyKnown) === true);
  }
}

/** To be called by the editor for every transaction that changes the text. */
export function editorChanged(changes: ChangeSet, fromProgram: boolean): void {
  const document = active();
  if (document) noteChanges(document, changes, fromProgram);
}

function noteChanges(document: OpenDocument, changes: ChangeSet, fromProgram: boolean): void {
  if (fromProgram) return;
  if (document.readOnly) document.sync.follow(changes);
  else document.sync.record(changes);
  document.dirty = isDirty(document);
  measures.typed(document.file, document.sync.version);
  scheduleFlush();
  touched();
}

export function isDirty(document: OpenDocument): boolean {
  const text = stateOf(document).doc;
  if (!document.saved) return true;
  return text.length !== document.saved.length || !text.eq(document.saved);
}
