// What the view leaves out of the scene, whose text stays as it is; and where what it shows is.

import { computed, effect, signal, useSignalEffect } from "@preact/signals";
import { around } from "../core/camera.js";
import { pathTo, timesOf, type EntityId } from "../core/entities.js";
import type { Axes, Entity, EntityRef, ToPage, Vector } from "../core/protocol.js";
import * as program from "../program.js";
import * as state from "../state.js";

const ASK_MS = 200;

interface Place {
  center: Vector | null;
  size: Vector | null;
  times: number;
  axes?: Axes | undefined;
}
const places = signal<ReadonlyMap<string, Place>>(new Map());
const keyOf = (file: string, entity: EntityId) => `${file}\n${entity}`;
const isSame = (a: EntityRef, b: EntityRef) => a[0] === b[0] && a[1] === b[1];

/** In words; empty while all of the scene is seen. */
export const filterWords = computed(() => {
  const words = [];
  if (state.hidden.value.length > 0) words.push(`${state.hidden.value.length} hidden`);
  if (state.solo.value.length > 0) words.push(`${state.solo.value.length} alone`);
  return words.join(", ");
});

/** The centre of what an entity made; null: that has none; nothing: it made nothing, or that is not known yet. */
export function centerOf(file: string, entity: EntityId): Vector | null | undefined {
  return places.value.get(keyOf(file, entity))?.center;
}

/** How many things the text of an entity makes, as that of a macro which is called more than once. */
export function timesMade(file: string, entities: readonly Entity[], entity: EntityId): number {
  return timesOf(entities, entity, (id) => places.value.get(keyOf(file, id))?.times);
}

/** The axes that an entity's numbers are in: those of the innermost thing that it is, or stands in; nothing where they are the world's. */
export function axesOf(file: string, entities: readonly Entity[], entity: EntityId): Axes | undefined {
  const path = pathTo(entities, entity).reverse();
  return path.map((each) => places.peek().get(keyOf(file, each.id))).find(Boolean)?.axes;
}

/** The box of what an entity made; nothing: that has none, or is not known. */
export function boundsOf(file: string, entity: EntityId): [Vector, Vector] | undefined {
  const { center, size } = places.peek().get(keyOf(file, entity)) ?? {};
  return center && size ? around(center, size) : undefined;
}

export function isHidden(ref: EntityRef): boolean {
  return state.hidden.value.some((each) => isSame(each, ref));
}
export function isAlone(ref: EntityRef): boolean {
  return state.solo.value.some((each) => isSame(each, ref));
}

function toggled(list: EntityRef[], ref: EntityRef): EntityRef[] {
  const rest = list.filter((each) => !isSame(each, ref));
  return rest.length < list.length ? rest : [...list, ref];
}

export function toggleHidden(ref: EntityRef): void {
  if (centerOf(...ref) !== undefined || isHidden(ref)) state.hidden.value = toggled(state.hidden.peek(), ref);
}
export function toggleSolo(ref: EntityRef): void {
  if (centerOf(...ref) !== undefined || isAlone(ref)) state.solo.value = toggled(state.solo.peek(), ref);
}
export function showAll(): void {
  state.hidden.value = [];
  state.solo.value = [];
}

/** Another scene has other entities. */
export function watchFilter(): void {
  effect(() => {
    void state.sceneFile.value;
    showAll();
  });
}

let due: ReturnType<typeof setTimeout> | undefined;

/** To be called by what shows where things are: it is asked anew for each scene that is read. */
export function usePlaces(): void {
  useSignalEffect(() => {
    void state.summary.value;
    askCenters();
  });
}

/** Asks where things are in the scene as it was read last. */
function askCenters(): void {
  clearTimeout(due);
  due = setTimeout(() => {
    const file = state.sceneFile.peek();
    if (file !== undefined) program.send("centers", { file });
  }, ASK_MS);
}

let waiting: (() => void) | undefined;

/** Does it once it is known where things are now; of what waits the last is done. */
export function whenPlacesAreKnown(what: () => void): void {
  const file = state.sceneFile.peek();
  waiting = file !== undefined && program.send("centers", { file }) ? what : undefined;
}

export function centersCame(message: ToPage["centers"]): void {
  places.value = new Map(message.list.map(([file, entity, center, size, times, axes]) => [keyOf(file, entity), { center, size, times, axes }]));
  const due = waiting;
  waiting = undefined;
  if (message.file === state.sceneFile.peek()) due?.();
}
