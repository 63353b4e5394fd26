// The entity that is worked with: chosen in the tree, by the cursor or by a click on the picture; and edits of it.

import { computed, effect, signal } from "@preact/signals";
import { entityAt, type EntityId } from "./core/entities.js";
import type { Entity, FreeCamera, OfText, Placement, ToPage, ToProgram, Vector } from "./core/protocol.js";
import * as documents from "./documents.js";
import * as program from "./program.js";
import { takeRevealed } from "./reveal.js";
import * as state from "./state.js";

export const selected = computed<Entity | undefined>(() =>
  state.outline.value?.entities.find((each) => each.id === state.selectedEntity.value),
);

export function select(entity: Entity, reveal = true): void {
  state.selectedEntity.value = entity.id;
  const file = state.outline.peek()?.file;
  // The scene as a whole is no place in its text.
  if (reveal && file && entity.parent !== null) documents.reveal(file, entity.line, entity.column, entity.end_line, entity.end_column, false);
  takeRevealed();
}

/** The cursor selects what it stands in, while the outline is of the text that is shown. */
export function followCaret(): void {
  effect(() => {
    void state.caret.value;
    const outline = state.outline.value;
    const shown = documents.active();
    const view = documents.editorView();
    if (!outline || !view || !shown || shown.file !== outline.file || shown.sync.version !== outline.version) return;
    const { from, to } = view.state.selection.main;
    const id = state.selectedEntity.peek();
    const now = outline.entities.find((each) => each.id === id);
    // What an edit has put into another entity has another name: the cursor is still on it.
    const isRenamed = id !== undefined && !now && from < to;
    // Where nobody types and nothing was gone to, what was selected stays.
    if (!view.hasFocus && !takeRevealed() && !isRenamed) return;
    if (now && now.from === from && now.to === to) return;
    const found = entityAt(outline.entities, from, to);
    if (found) state.selectedEntity.value = found.id;
  });
}

/** The program is asked for the fields of what is selected, anew for each text. */
export function followFields(): void {
  effect(() => {
    const outline = state.outline.value;
    const entity = selected.value;
    if (state.connection.value !== "open" || !outline || !entity) return;
    program.send("fields", { file: outline.file, base: outline.version, entity: entity.id });
  });
}

const TEXT_CHANGES = ["set", "reset", "add", "remove", "duplicate", "write_camera", "write_settings", "place"] as const;
type TextChanges = (typeof TEXT_CHANGES)[number];

export function changesText(request: string): boolean {
  return (TEXT_CHANGES as readonly string[]).includes(request);
}

interface Wish {
  kind: TextChanges;
  file: string;
  body: Record<string, unknown>;
  /** Wishes of one gesture are one step of undo. */
  gesture: string;
  /** Hears that the text has it. */
  made?: (() => void) | undefined;
  /** Hears that the text has it, or that it was refused. */
  answered?: (() => void) | undefined;
}

const ANSWER_MS = 1000;
let wishes: Wish[] = [];
let asked: Wish | undefined;
let lastGesture: string | undefined;
let gestures = 0;
let timer: ReturnType<typeof setTimeout> | undefined;

/** What is set from now on is another step of undo than what was set before. */
export function beginGesture(): void {
  ++gestures;
}

/** At most one edit is under way; of those that wait and are of one gesture, the last one is made. */
function want<K extends TextChanges>(kind: K, body: Omit<ToProgram[K], keyof OfText>, gesture: string = String(++gestures), file = state.outline.peek()?.file ?? state.sceneFile.peek(), hears: Pick<Wish, "made" | "answered"> = {}): void {
  if (file === undefined) return;
  if (documents.find(file)?.readOnly) {
    state.notify(state.welcome.peek()?.read_only ? `${file} is open for reading alone.` : `${file} is edited by another page: take it over first.`, "error");
    hears.answered?.();
    return;
  }
  const last = wishes[wishes.length - 1];
  if (last?.gesture === gesture && last.file === file) wishes.pop();
  wishes.push({ kind, file, body: body as Record<string, unknown>, gesture, ...hears });
  sendWish();
}

function sendWish(): void {
  const [next] = wishes;
  if (asked || !next) return;
  wishes.shift();
  const document = documents.find(next.file);
  if (!document) return sendWish();
  documents.flush();
  const body = { file: next.file, base: document.sync.sentVersion, ...next.body } as ToProgram[TextChanges];
  if (!program.send(next.kind, body)) {
    state.notify("The change was not made: there is no connection to the program.", "error");
    const dropped = [next, ...wishes];
    wishes = [];
    for (const each of dropped) each.answered?.();
    return;
  }
  asked = next;
  clearTimeout(timer);
  timer = setTimeout(answered, ANSWER_MS);
}

/** Takes what the program proposes. */
export function receiveChange(message: ToPage["change"]): void {
  const mine = asked?.file === message.file ? asked : undefined;
  const continues = mine !== undefined && mine.gesture === lastGesture && documents.isUntouched(message.file);
  const isNew = mine?.kind === "add" || mine?.kind === "duplicate" || (mine?.kind === "place" && mine.body.entity === undefined);
  if (mine) state.refusedField.value = undefined;
  documents.receiveChange(message, continues, isNew);
  lastGesture = mine?.gesture;
  mine?.made?.();
  answered();
}

/** The program has proposed the change, or refused it. */
export function answered(): void {
  const { answered: hears } = asked ?? {};
  asked = undefined;
  clearTimeout(timer);
  hears?.();
  requestAnimationFrame(sendWish);
}

/** A field whose literal stands for several values, and the text that it would get. */
export interface SharedChange {
  entity: EntityId;
  field: string;
  text: string;
  uses: number;
}
/** What is to be agreed to before it is made. */
export const sharedChange = signal<SharedChange | undefined>(undefined);
let agreed: { entity: EntityId; field: string } | undefined;

/** Makes the change that was asked about, and from now on further ones of that field, or forgets it. */
export function decideShared(make: boolean): void {
  const change = sharedChange.peek();
  sharedChange.value = undefined;
  if (!change || !make) return;
  agreed = change;
  setField(change.entity, change.field, change.text);
}

/** Sets a field's text; what is set of it in one gesture is one step of undo. Where more changes than is seen, it is asked about first. */
export function setField(entity: EntityId, field: string, text: string): void {
  const { value: told } = state.fields;
  const uses = (told?.entity === entity && told.fields.find((each) => each.name === field)?.uses) || 1;
  if (agreed && (agreed.entity !== entity || agreed.field !== field)) agreed = undefined;
  if (uses > 1 && !agreed) {
    sharedChange.value = { entity, field, text, uses };
    return;
  }
  want("set", { entity, field, text }, `${gestures} ${entity} ${field}`);
}

export function resetField(entity: EntityId, field: string): void {
  want("reset", { entity, field });
}

export function remove(entity: Entity): void {
  want("remove", { entity: entity.id });
}

export function duplicate(entity: Entity): void {
  want("duplicate", { entity: entity.id });
}

/** Adds what the template makes; a file where it is of one. */
export function add(kind: string, text?: string): void {
  want("add", { kind, ...(text === undefined ? {} : { text }) });
}

/** The same to the scene that the view shows, at a point of it where there is one. */
export function addToScene(kind: string, { text, position }: { text?: string; position?: Vector | undefined }): void {
  want("add", { kind, ...(text === undefined ? {} : { text }), ...(position === undefined ? {} : { position }) }, undefined, state.sceneFile.peek());
}

/** Gives an include its placement; without one it is a new one. */
export function place(file: string, entity: EntityId | undefined, placement: Placement): void {
  want("place", { placement, ...(entity === undefined ? {} : { entity }) }, undefined, file);
}

/** The same, at once as it is typed: what is set in one gesture is one step of undo. */
export function placeLive(file: string, entity: EntityId, placement: Placement, answered: () => void): void {
  want("place", { placement, entity }, `${gestures} placement`, file, { answered });
}

/** Adds to an entity, as a step to a transform. */
export function addTo(entity: EntityId, kind: string): void {
  want("add", { kind, entity });
}

export function writeCamera(camera: FreeCamera, aspect: number, name = "", made?: () => void): void {
  want("write_camera", { camera, aspect, text: name }, undefined, state.sceneFile.peek(), { made });
}

export function writeSettings(options: ToProgram["write_settings"]["options"]): void {
  want("write_settings", { options }, undefined, state.sceneFile.peek());
}
