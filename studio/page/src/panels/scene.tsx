import { signal } from "@preact/signals";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { rowsOf, titleOf, type EntityId, type EntityRow } from "../core/entities.js";
import { add, addTo, duplicate, remove, select, selected } from "../entities.js";
import type { Entity, EntityRef } from "../core/protocol.js";
import { placeWords } from "../core/view_words.js";
import * as state from "../state.js";
import { centerOf, isAlone, isHidden, toggleHidden, toggleSolo, usePlaces } from "../view/filter.js";
import { Palette } from "./palette.js";

const ROW_HEIGHT = 24;
const BEYOND = 8;
const closed = signal<Set<EntityId>>(new Set());
const search = signal("");

function setOpen(id: EntityId, open: boolean): void {
  const next = new Set(closed.value);
  if (open) next.delete(id);
  else next.add(id);
  closed.value = next;
}

function useHeight(): [(element: HTMLElement | null) => void, number] {
  const [height, setHeight] = useState(400);
  const observer = useRef<ResizeObserver | undefined>(undefined);
  const attach = useRef((element: HTMLElement | null) => {
    observer.current?.disconnect();
    if (!element) return;
    observer.current = new ResizeObserver(() => setHeight(element.clientHeight));
    observer.current.observe(element);
  });
  return [attach.current, height];
}

/** Where what the entity made is, and whether the view shows it. */
function Place({ entity, file }: { entity: Entity; file: string }) {
  const center = centerOf(file, entity.id);
  const ref: EntityRef = [file, entity.id];
  const [off, alone] = [isHidden(ref), isAlone(ref)];
  if (center === undefined && !off && !alone) return null;
  const click = (toggle: (ref: EntityRef) => void) => (event: Event) => {
    event.stopPropagation();
    toggle(ref);
  };
  return (
    <>
      {center && <span class="center">{placeWords(center)}</span>}
      <span class="seen">
        <button type="button" tabIndex={-1} aria-pressed={off} title="Hide it in the view (H)" onClick={click(toggleHidden)}>{off ? "hidden" : "hide"}</button>
        <button type="button" tabIndex={-1} aria-pressed={alone} title="Show it alone in the view (S)" onClick={click(toggleSolo)}>{alone ? "alone" : "solo"}</button>
      </span>
    </>
  );
}

function Row({ row, index, chosen, focusable, file }: { row: EntityRow; index: number; chosen: boolean; focusable: boolean; file: string }) {
  const { entity } = row;
  return (
    <div
      role="treeitem"
      id={`entity-${index}`}
      class="row"
      aria-level={row.level}
      aria-selected={chosen}
      aria-expanded={row.children > 0 ? row.isOpen : undefined}
      aria-posinset={row.position}
      aria-setsize={row.siblings}
      tabIndex={focusable ? 0 : -1}
      style={{ paddingInlineStart: `${row.level * 14 - 4}px`, top: `${index * ROW_HEIGHT}px` }}
      onClick={() => select(entity)}
    >
      <span
        class={`mark ${row.isOpen ? "open" : ""}`}
        aria-hidden="true"
        onClick={(event) => {
          if (row.children === 0) return;
          event.stopPropagation();
          setOpen(entity.id, !row.isOpen);
        }}
      >
        {row.children > 0 ? "▸" : ""}
      </span>
      <span class="name">{titleOf(entity)}</span>
      {row.children > 0 && <span class="count" title={`${row.children} in it`}>{row.children}</span>}
      {entity.name && <span class="kind">{entity.type && entity.type !== entity.kind ? entity.type : entity.kind}</span>}
      {entity.target && <span class="kind">{entity.target}</span>}
      <Place entity={entity} file={file} />
      <span class="aside">{entity.line}</span>
    </div>
  );
}

/** Steps of a transform are added to what is selected, all else to the scene. */
function Adder() {
  const templates = state.outline.value?.templates ?? [];
  const chosen = selected.value;
  if (templates.length === 0) return null;
  const addThat = (name: string) => {
    const made = templates.find((each) => each.name === name);
    if (made?.type === "transform.steps") {
      if (chosen) addTo(chosen.id, name);
    } else if (name) add(name);
  };
  return (
    <select
      aria-label="Add to the scene"
      value=""
      onKeyDown={(event) => {
        // A key would choose at once, and so add something, in a list that is not open.
        const isWord = event.key.length === 1 || event.key.startsWith("Arrow");
        if (!isWord || event.ctrlKey || event.altKey || event.metaKey) return;
        event.preventDefault();
        event.currentTarget.showPicker();
      }}
      onChange={(event) => {
        addThat(event.currentTarget.value);
        event.currentTarget.value = "";
      }}
    >
      <option value="">Add…</option>
      {templates.filter((each) => each.name !== "file").map((each) => <option key={each.name} value={each.name}>{each.name}</option>)}
    </select>
  );
}

function treeKey(event: KeyboardEvent, rows: EntityRow[], index: number, page: number, file: string): void {
  const row = rows[index];
  const isPlain = !event.ctrlKey && !event.altKey && !event.metaKey;
  const go = (to: number) => {
    const target = rows[Math.min(rows.length - 1, Math.max(0, to))];
    if (target) select(target.entity);
  };
  if (event.key === "ArrowDown") go(index + 1);
  else if (event.key === "ArrowUp") go(index - 1);
  else if (event.key === "PageDown") go(index + page);
  else if (event.key === "PageUp") go(index - page);
  else if (event.key === "Home") go(0);
  else if (event.key === "End") go(rows.length - 1);
  else if (event.key === "Delete" && row && row.entity.parent !== null) remove(row.entity);
  else if (event.key.toLowerCase() === "d" && event.ctrlKey && row && row.entity.parent !== null) duplicate(row.entity);
  else if (event.key.toLowerCase() === "h" && isPlain && row) toggleHidden([file, row.entity.id]);
  else if (event.key.toLowerCase() === "s" && isPlain && row) toggleSolo([file, row.entity.id]);
  else if (event.key === "ArrowRight" && row && row.children > 0) row.isOpen ? go(index + 1) : setOpen(row.entity.id, true);
  else if (event.key === "ArrowLeft" && row) {
    if (row.isOpen) setOpen(row.entity.id, false);
    else go(rows.findIndex((each) => each.entity.id === row.entity.parent));
  } else return;
  event.preventDefault();
}

export function ScenePanel() {
  const [attach, height] = useHeight();
  const host = useRef<HTMLDivElement | null>(null);
  const [top, setTop] = useState(0);
  const entities = state.outline.value?.entities;
  const file = state.outline.value?.file ?? "";
  const rows = useMemo(() => rowsOf(entities ?? [], closed.value, search.value), [entities, closed.value, search.value]);
  usePlaces();
  const chosen = rows.findIndex((each) => each.entity.id === state.selectedEntity.value);
  useEffect(() => {
    const box = host.current;
    if (!box || chosen < 0) return;
    const at = chosen * ROW_HEIGHT;
    if (at < box.scrollTop || at + ROW_HEIGHT > box.scrollTop + box.clientHeight) box.scrollTop = at - box.clientHeight / 2;
    if (box.contains(document.activeElement)) box.querySelector<HTMLElement>(`#entity-${chosen}`)?.focus({ preventScroll: true });
  }, [chosen]);
  const first = Math.max(0, Math.floor(top / ROW_HEIGHT) - BEYOND);
  const last = Math.min(rows.length, Math.ceil((top + height) / ROW_HEIGHT) + BEYOND);
  const focusable = chosen >= first && chosen < last ? chosen : first;
  return (
    <>
      <div class="bar">
        <input type="search" placeholder="Search the scene" aria-label="Search the scene" value={search.value} onInput={(event) => (search.value = event.currentTarget.value)} />
        <Adder />
      </div>
      <Palette />
      <div
        class="tree"
        role={rows.length > 0 ? "tree" : undefined}
        aria-label={rows.length > 0 ? "Entities of the scene" : undefined}
        ref={(element) => {
          host.current = element;
          attach(element);
        }}
        onScroll={(event) => setTop(event.currentTarget.scrollTop)}
        onKeyDown={(event) => treeKey(event, rows, Math.max(0, chosen), Math.floor(height / ROW_HEIGHT) - 1, file)}
      >
        <div class="tree-rows" role="presentation" style={{ height: `${rows.length * ROW_HEIGHT}px` }}>
          {rows.slice(first, last).map((row, offset) => (
            <Row key={row.entity.id} row={row} index={first + offset} chosen={first + offset === chosen} focusable={first + offset === focusable} file={file} />
          ))}
        </div>
        {state.outline.value?.truncated && <p class="empty">The text has more entities than are listed.</p>}
        {rows.length === 0 && <p class="empty">{search.value ? "Nothing is called so." : "No scene is read."}</p>}
      </div>
    </>
  );
}
