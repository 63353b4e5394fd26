// The models of a scene: the files that it places, and the ones that a dialog and the Properties panel are about.

import { effect, signal } from "@preact/signals";
import { isModel } from "./core/entities.js";
import type { Entity, EntityId, FileEntry, Placement, Problem } from "./core/protocol.js";
import { folderOf, isCompanion, relativeName, resolvedName } from "./core/paths.js";
import { placeLive, selected } from "./entities.js";
import { ask } from "./questions.js";
import * as state from "./state.js";

export interface ModelWish {
  /** The scene's. */
  file: string;
  /** Nothing: one that is to be added. */
  entity: EntityId | undefined;
  placement: Placement;
  /** Nothing: the language has no choice of them. */
  materials: string[] | undefined;
  /** Why nothing of it can be set. */
  locked: string | undefined;
}
/** What the dialog of models is about. */
export const wished = signal<ModelWish | undefined>(undefined);

/** Those files of the opened folder as the scene names them: first the ones in the scene's own folder or below it. */
function filesFor(scene: string, fits: (file: FileEntry) => boolean): string[] {
  const folder = folderOf(scene);
  const names = state.files.value.filter(fits).map((each) => relativeName(folder, each.name));
  const isOutside = (name: string) => name.startsWith("../");
  return [...names.filter((each) => !isOutside(each)), ...names.filter(isOutside)];
}

export function canBePlaced({ name, kind }: FileEntry): boolean {
  return (kind === "model" || kind === "scene") && !isCompanion(name);
}

/** Files that the scene can place. */
export function candidates(scene: string): string[] {
  return filesFor(scene, (file) => canBePlaced(file) && file.name !== scene);
}

export function picturesFor(scene: string): string[] {
  return filesFor(scene, ({ kind }) => kind === "picture");
}

/** Whether the text names that file for the entity, and the program found no error within what the text says of it. */
function isRead(scene: string, id: EntityId | undefined, name: string): boolean {
  const entity = state.outlines.value.get(scene)?.entities.find((each) => each.id === id);
  if (entity?.target !== name) return false;
  const { line, column, end_line: endLine, end_column: endColumn } = entity;
  const isWithin = (problem: Problem) =>
    (problem.line > line || (problem.line === line && problem.column >= column)) &&
    (problem.line < endLine || (problem.line === endLine && problem.column <= endColumn));
  const all = [...state.knownProblems.value.values()].flatMap(({ list }) => list);
  return !all.some((each) => each.severity === "error" && each.file === scene && isWithin(each));
}

/** What is wrong with the name of a model's file; nothing where it is one of the opened folder that can be placed, or the
    one that the text names and that the program reads, as from the folder of `--assets`. */
export function faultOfFile(name: string, { file: scene, entity, locked }: ModelWish): string | undefined {
  if (locked !== undefined) return undefined;
  const meant = resolvedName(folderOf(scene), name);
  const isListed = meant !== scene && state.files.value.some((each) => each.name === meant && canBePlaced(each));
  if (name !== "" && (isListed || isRead(scene, entity, name))) return undefined;
  const found = name.trim() === "" ? "nothing" : `“${name}”, which is no such file`;
  return `found ${found}; expected a model or a scene in the opened folder`;
}

async function wishOf(file: string, entity: Entity | undefined): Promise<ModelWish | undefined> {
  const answer = await ask("placement", file, entity ? { entity: entity.id } : {});
  return answer && { file, entity: entity?.id, placement: answer.placement, materials: answer.materials, locked: answer.locked };
}

/** Opens the dialog about an include, or about a new one of a file. */
export async function openModel(entity: Entity | undefined, added = ""): Promise<void> {
  const file = state.outline.peek()?.file;
  const wish = file === undefined ? undefined : await wishOf(file, entity);
  if (!wish) return;
  wished.value = entity ? wish : { ...wish, placement: { ...wish.placement, file: added } };
}

/** The model that is selected, as the Properties panel sets it: with what was typed, which the text may not have yet. */
export const placed = signal<ModelWish | undefined>(undefined);
/** Whether a change of it is under way, and whether that is answered and read; what it is to become thereafter. */
let isChanging = false, isAnswered = false;
let next: Placement | undefined;
/** How often it was asked for: what was asked before a change or another question tells nothing any more. */
let asked = 0;

/** Sets the placement of the selected model: one change at a time, since the first may give the model another name. */
export function setPlaced(placement: Placement): void {
  const { value: told } = placed;
  if (!told) return;
  placed.value = { ...told, placement };
  next = placement;
  changePlaced();
}

function changePlaced(): void {
  const { value: told } = placed;
  if (isChanging || !next || !told) return;
  isChanging = true;
  isAnswered = false;
  ++asked;
  placeLive(told.file, told.entity!, next, () => {
    isAnswered = true;
    void readPlaced();
  });
  next = undefined;
}

async function readPlaced(): Promise<void> {
  if (isChanging && !isAnswered) return;
  const question = ++asked;
  const outline = state.outline.peek();
  const entity = selected.peek();
  const wish = outline && entity && isModel(entity) ? await wishOf(outline.file, entity) : undefined;
  if (question !== asked) return;
  isChanging = false;
  if (!wish || selected.peek()?.id !== wish.entity || state.outline.peek()?.file !== wish.file) return;
  const { value: before } = placed;
  const isAnother = before?.file !== wish.file || (before.entity !== wish.entity && outline!.entities.some((each) => each.id === before.entity));
  if (isAnother) next = undefined;
  placed.value = next ? { ...wish, placement: next } : wish;
  changePlaced();
}

/** The program is asked how the selected model is placed, anew for each text. */
export function followPlaced(): void {
  effect(() => {
    const entity = selected.value;
    void state.outline.value;
    if (state.connection.value !== "open") return;
    if (entity && !isModel(entity)) placed.value = undefined;
    void readPlaced();
  });
}
