import { signal } from "@preact/signals";
import { isModel, pathTo, titleOf } from "../core/entities.js";
import type { Entity, Field } from "../core/protocol.js";
import * as documents from "../documents.js";
import { beginGesture, duplicate, remove, resetField, select, selected, setField } from "../entities.js";
import { placed, setPlaced } from "../models.js";
import * as state from "../state.js";
import { PlacementFields } from "./placement_fields.js";
import { timesMade, usePlaces } from "../view/filter.js";
import { expectedWords, isOdd, PropertyValue } from "./property_value.js";

const hidesDefaults = signal(false);

function reference(field: Field): void {
  const target = state.outline.peek()?.entities.find((each) => each.name !== "" && each.name === field.text);
  if (target) select(target);
  else state.notify(`Nothing in this file is called “${field.text}”.`, "error");
}

function openFile(field: Field): void {
  const { file } = state.outline.peek()!;
  const folder = file.slice(0, file.lastIndexOf("/") + 1);
  documents.open(folder + field.text);
}

function jump(field: Field): void {
  const document = documents.find(state.outline.peek()?.file);
  if (!document) return;
  const { doc } = documents.stateOf(document);
  const at = (offset: number) => {
    const line = doc.lineAt(Math.min(doc.length, offset));
    return [line.number, Math.min(offset, line.to) - line.from + 1] as const;
  };
  documents.reveal(document.file, ...at(field.from), ...at(field.to));
}

/** The last part of a path, after what it stands in. */
function Label({ field, hint }: { field: Field; hint: string }) {
  const dot = field.name.lastIndexOf(".") + 1;
  return (
    <span class="label" title={`${field.name}${hint === "" ? "" : `: ${hint}`}`}>
      {dot > 0 && <span class="path-of">{field.name.slice(0, dot)}</span>}
      <span class="own">{field.name.slice(dot)}</span>
    </span>
  );
}

/** The unit and range of a number, and a colour as its swatch has it, where the panel is wide enough. */
function Expected({ field }: { field: Field }) {
  const words = expectedWords(field);
  return words === "" ? null : <span class="expected aside">{words}</span>;
}

function Property({ entity, field }: { entity: Entity; field: Field }) {
  const isAbsent = field.present === false;
  const isLocked = field.locked !== undefined;
  const hint = [field.help, field.unit, field.default === undefined ? "" : `default ${field.default}`, field.locked].filter(Boolean).join("; ");
  const { value: refused } = state.refusedField;
  const why = refused?.entity === entity.id && refused.field === field.name ? refused.words : undefined;
  const set = (text: string) => setField(entity.id, field.name, text);
  return (
    <div class={`property ${isAbsent || field.default === field.text ? "is-default" : ""} ${isOdd(field) || why ? "odd" : ""}`}>
      <Label field={field} hint={hint} />
      <span class="value">
        <PropertyValue field={field} set={set} disabled={isLocked} />
        <Expected field={field} />
        {field.uses !== undefined && field.uses > 1 && <span class="aside">one literal for {field.uses} values: all of them change</span>}
        {isLocked && <span class="aside">{field.locked}</span>}
        {why && <span class="why" role="alert">{why}</span>}
      </span>
      <span class="group">
        {field.kind === "reference" && field.text !== "" && <button type="button" class="link" aria-label={`Go to ${field.text}`} title={`Go to ${field.text}`} onClick={() => reference(field)}>→</button>}
        {field.kind === "file" && field.text !== "" && <button type="button" class="link" aria-label={`Open ${field.text}`} title={`Open ${field.text}`} onClick={() => openFile(field)}>→</button>}
        {!isAbsent && !isLocked && field.default !== undefined && (
          <button type="button" class="link" aria-label={`Reset ${field.name} to ${field.default}`} title={`Reset to ${field.default}`} onClick={() => resetField(entity.id, field.name)}>↺</button>
        )}
        {!isAbsent && <button type="button" class="link" aria-label={`Show ${field.name} in the script`} title="Show in the script" onClick={() => jump(field)}>¶</button>}
      </span>
    </div>
  );
}

/** Says, before anything is changed, how much changes with it. */
function TimesMade({ entity }: { entity: Entity }) {
  const { file, entities } = state.outline.value!;
  const times = timesMade(file, entities, entity.id);
  return times > 1 ? <p class="times-made">This text makes {times} things: all of them change.</p> : null;
}

export function PropertiesPanel() {
  usePlaces();
  const entity = selected.value;
  if (!entity) return <p class="empty">Select something: in the scene, in the script or on the picture.</p>;
  const path = pathTo(state.outline.value!.entities, entity.id);
  const { value: told } = state.fields;
  const isTold = told?.entity === entity.id && told.file === state.outline.value!.file;
  const fields = isTold ? told.fields : [];
  const shown = hidesDefaults.value ? fields.filter((each) => each.present !== false) : fields;
  return (
    <>
      <div class="property-head">
        <strong>{titleOf(entity)}</strong>
        <span class="aside">{entity.name && entity.type ? `${entity.kind}, ${entity.type}` : entity.kind}</span>
        <span class="spacer" />
        <button type="button" class="link" onClick={() => select(entity)}>line {entity.line}</button>
        {entity.parent !== null && (
          <>
            <button type="button" onClick={() => duplicate(entity)}>Duplicate</button>
            <button type="button" onClick={() => remove(entity)}>Remove</button>
          </>
        )}
      </div>
      <nav class="path" aria-label="What it stands in">
        {path.slice(0, -1).map((each) => <button type="button" class="link" key={each.id} onClick={() => select(each)}>{titleOf(each)}</button>)}
        <span class="spacer" />
        <label class="aside"><input type="checkbox" checked={hidesDefaults.value} onChange={(event) => (hidesDefaults.value = event.currentTarget.checked)} /> what is set alone</label>
      </nav>
      <TimesMade entity={entity} />
      <div class="scroll">
        {isModel(entity) && placed.value && <PlacementFields wish={placed.value} begin={beginGesture} set={setPlaced} />}
        {shown.map((field) => <Property key={`${entity.id} ${field.name}`} entity={entity} field={field} />)}
        {isTold && shown.length === 0 && <p class="empty">It has no fields{fields.length > 0 ? " that are set" : ""}.</p>}
      </div>
    </>
  );
}
