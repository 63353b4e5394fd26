// The entities of a text as a tree of rows.

import type { Entity, EntityId } from "./protocol.js";

export type { EntityId };

export interface EntityRow {
  entity: Entity;
  level: number;
  /** How many stand right in it, of those that the search finds. */
  children: number;
  isOpen: boolean;
  position: number;
  siblings: number;
}

/** What an entity is called. */
export function titleOf(entity: Entity): string {
  return entity.name || entity.type || entity.kind;
}

/** The rows that are seen: those inside of closed ones are not; with a search, those that match and what they stand in. */
export function rowsOf(entities: readonly Entity[], closed: ReadonlySet<EntityId>, search = ""): EntityRow[] {
  const wanted = search.trim().toLowerCase();
  const matches = wanted === "" ? undefined : matching(entities, wanted);
  const children = new Map<EntityId | null, Entity[]>();
  const known = new Set(entities.map((each) => each.id));
  for (const entity of entities) {
    if (matches && !matches.has(entity.id)) continue;
    const parent = entity.parent !== null && known.has(entity.parent) && entity.parent !== entity.id ? entity.parent : null;
    const list = children.get(parent);
    if (list) list.push(entity);
    else children.set(parent, [entity]);
  }
  const rows: EntityRow[] = [];
  const add = (parent: EntityId | null, level: number) => {
    const list = children.get(parent) ?? [];
    list.forEach((entity, index) => {
      const inside = children.get(entity.id)?.length ?? 0;
      const isOpen = inside > 0 && (matches !== undefined || !closed.has(entity.id));
      rows.push({ entity, level, children: inside, isOpen, position: index + 1, siblings: list.length });
      if (isOpen) add(entity.id, level + 1);
    });
  };
  add(null, 1);
  return rows;
}

function matching(entities: readonly Entity[], wanted: string): Set<EntityId> {
  const byId = new Map(entities.map((each) => [each.id, each]));
  const found = new Set<EntityId>();
  for (const entity of entities) {
    if (!`${entity.kind} ${entity.type ?? ""} ${entity.name}`.toLowerCase().includes(wanted)) continue;
    for (let at: Entity | undefined = entity; at && !found.has(at.id); at = at.parent === null ? undefined : byId.get(at.parent)) {
      found.add(at.id);
    }
  }
  return found;
}

/** Whether the entity places another file: an include, an Inline, a Mesh. */
export function isModel(entity: Entity): boolean {
  return entity.kind === "include" || /^(?:Mesh|Inline)$/.test(entity.type ?? "");
}

/** The innermost entity that holds the whole of a range. */
export function entityAt(entities: readonly Entity[], from: number, to: number): Entity | undefined {
  let found: Entity | undefined;
  for (const entity of entities) {
    if (entity.from > from || entity.to < to) continue;
    if (!found || entity.to - entity.from <= found.to - found.from) found = entity;
  }
  return found;
}

/** The entities that an entity stands in, the outermost first. */
export function pathTo(entities: readonly Entity[], id: EntityId): Entity[] {
  const byId = new Map(entities.map((each) => [each.id, each]));
  const path: Entity[] = [];
  for (let at = byId.get(id); at && !path.includes(at); at = at.parent === null ? undefined : byId.get(at.parent)) path.unshift(at);
  return path;
}

/** How many things are made of what a text says of an entity; 1 where that is not known. `made`: what each makes by itself.
    What makes nothing by itself, as a call, is a part of what it stands in, and a macro makes what stands in it. */
export function timesOf(entities: readonly Entity[], id: EntityId, made: (id: EntityId) => number | undefined): number {
  for (const entity of pathTo(entities, id).reverse()) {
    const own = made(entity.id);
    if (own) return own;
    if (entity.kind !== "macro") continue;
    const inside = entities.filter((each) => each.id !== entity.id && each.from >= entity.from && each.to <= entity.to);
    return Math.max(1, ...inside.map((each) => made(each.id) ?? 0));
  }
  return 1;
}
