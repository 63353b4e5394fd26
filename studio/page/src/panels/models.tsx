import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { isModel, titleOf } from "../core/entities.js";
import { baseName, folderOf, resolvedName } from "../core/paths.js";
import type { Entity } from "../core/protocol.js";
import * as program from "../program.js";
import { duplicate, remove, select } from "../entities.js";
import { candidates, openModel } from "../models.js";
import * as state from "../state.js";
import { listKey } from "./list_keys.js";

const adding = signal("");

function key(event: KeyboardEvent, entity: Entity): void {
  if (event.key === "Delete") remove(entity);
  else if (event.key === "Enter") void openModel(entity);
  else if (event.key.toLowerCase() === "d" && event.ctrlKey) duplicate(entity);
  else return;
  event.preventDefault();
}

function Orders({ chosen }: { chosen: Entity | undefined }) {
  const file = state.outline.value?.file ?? "";
  const take = (use: (name: string) => void) => () => {
    use(adding.peek());
    adding.value = "";
  };
  return (
    <div class="bar">
      <select aria-label="Model to add" value={adding.value} onChange={(event) => (adding.value = event.currentTarget.value)}>
        <option value="">Add a model…</option>
        {candidates(file).map((each) => <option key={each} value={each}>{each}</option>)}
      </select>
      <button type="button" disabled={adding.value === ""} onClick={take((name) => void openModel(undefined, name))}>Add</button>
      <button
        type="button"
        disabled={adding.value === ""}
        title="A new scene, untitled, that places the model"
        onClick={take((name) => program.send("create", { model: resolvedName(folderOf(file), name) ?? name }))}
      >
        New scene
      </button>
      <button type="button" disabled={!chosen} onClick={() => remove(chosen!)}>Delete</button>
    </div>
  );
}

export function ModelsPanel() {
  const models = (state.outline.value?.entities ?? []).filter(isModel);
  const list = useRef<HTMLDivElement>(null);
  /** Which of them had the focus last, that the next one has it when that is gone. */
  const focused = useRef<number | undefined>(undefined);
  useEffect(() => {
    if (focused.current === undefined || document.activeElement !== document.body) return;
    const options = list.current?.querySelectorAll<HTMLElement>('[role="option"]') ?? [];
    options[Math.min(focused.current, options.length - 1)]?.focus();
  }, [models.length]);
  const some = models.length > 0;
  return (
    <>
      <Orders chosen={models.find((each) => each.id === state.selectedEntity.value)} />
      <div class="list" ref={list} role={some ? "listbox" : undefined} aria-label={some ? "Models of the scene" : undefined} onKeyDown={listKey}>
        {models.map((each, index) => (
          <div
            key={each.id}
            role="option"
            class="row"
            aria-selected={each.id === state.selectedEntity.value}
            tabIndex={index === 0 ? 0 : -1}
            onFocus={() => (focused.current = index)}
            onClick={() => select(each)}
            onDblClick={() => void openModel(each)}
            onKeyDown={(event) => key(event, each)}
          >
            <span class="mark" aria-hidden="true">△</span>
            <span class="name">{each.name || baseName(each.target ?? titleOf(each))}</span>
            {each.target && <span class="aside">{each.target}</span>}
          </div>
        ))}
        {!some && <p class="empty">The scene includes no files.</p>}
      </div>
      <p class="aside">Return opens one, Delete removes it, Ctrl-D doubles it.</p>
    </>
  );
}
