// The models of a scene: the files that it places, and the one that a dialog is about.

import { signal } from "@preact/signals";
import type { Entity, EntityId, FileEntry, Placement } from "./core/protocol.js";
import { folderOf } from "./core/paths.js";
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

/** Those files in the scene's own folder or below it, by their names from there. */
function filesBeside(scene: string, fits: (file: FileEntry) => boolean): string[] {
  const folder = folderOf(scene);
  return state.files.value.filter((each) => each.name.startsWith(folder) && fits(each)).map((each) => each.name.slice(folder.length));
}

/** Files that the scene can place. */
export function candidates(scene: string): string[] {
  return filesBeside(scene, ({ name, kind }) => (kind === "model" || kind === "scene") && !/\.mtl$/i.test(name) && name !== scene);
}

export function picturesFor(scene: string): string[] {
  return filesBeside(scene, ({ kind }) => kind === "picture");
}

/** Opens the dialog about an include, or about a new one of a file. */
export async function openModel(entity: Entity | undefined, added = ""): Promise<void> {
  const file = state.outline.peek()?.file;
  if (file === undefined) return;
  const answer = await ask("placement", file, entity ? { entity: entity.id } : {});
  if (!answer) return;
  const { placement, materials, locked } = answer;
  wished.value = {
    file, entity: entity?.id, materials, locked,
    placement: { ...placement, file: entity ? placement.file : added },
  };
}
