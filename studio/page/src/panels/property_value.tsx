import { useState } from "preact/hooks";
import { hexOf, linearOf } from "../core/colours.js";
import type { NumberRules } from "../core/numbers.js";
import { checkNumber, rangeWords } from "../core/numbers.js";
import type { Field } from "../core/protocol.js";
import { beginGesture } from "../entities.js";
import * as state from "../state.js";
import { NumberField } from "./number_field.js";

interface ValueProps {
  field: Field;
  set: (text: string) => void;
  disabled: boolean;
}

function rulesOf(field: Field): NumberRules {
  const rules: NumberRules = { whole: field.kind === "integer", unit: field.unit };
  if (field.range) rules.range = [field.range[0] ?? -Infinity, field.range[1] ?? Infinity];
  if (field.open) rules.open = field.open;
  return rules;
}

/** The numbers of a vector, however they are parted. */
function partsOf(text: string): string[] {
  return text.split(/[\s,]+/).filter(Boolean);
}

function VectorValue({ field, set, disabled }: ValueProps) {
  const known = partsOf(field.text);
  // What has no default is empty until something is typed.
  const parts = known.length > 0 ? known : ["", "", ""];
  const names = field.kind === "color" ? ["r", "g", "b", "a"] : ["x", "y", "z", "w"];
  const change = (index: number, text: string) => set(parts.map((each, at) => (at === index ? text : each || "0")).join(" "));
  return (
    <span class="vector">
      {parts.map((part, index) => (
        <NumberField key={index} quiet optional={known.length === 0} label={`${field.name} ${names[index] ?? index + 1}`} text={part} rules={rulesOf(field)} disabled={disabled} begin={beginGesture} commit={(text) => text !== "" && change(index, text)} />
      ))}
    </span>
  );
}

function ColourValue(props: ValueProps) {
  const { field, set, disabled } = props;
  const linear = partsOf(field.text).map(Number);
  return (
    <span class="group colour">
      <input
        type="color"
        class="swatch"
        aria-label={`${field.name} as sRGB`}
        title={`${hexOf(linear)} in sRGB`}
        value={hexOf(linear)}
        disabled={disabled}
        onClick={beginGesture}
        onInput={(event) => set([...linearOf(event.currentTarget.value), ...linear.slice(3)].join(" "))}
      />
      <VectorValue {...props} />
    </span>
  );
}

/** A text that is set when it is left or with Enter; Escape gives the old one back. */
function TextValue({ field, set, disabled, list }: ValueProps & { list?: readonly string[] }) {
  const [draft, setDraft] = useState<string | undefined>(undefined);
  const id = `choices-${field.name}`;
  const take = () => {
    if (draft !== undefined && draft !== field.text) set(draft);
    setDraft(undefined);
  };
  return (
    <>
      <input
        type="text"
        aria-label={field.name}
        spellcheck={false}
        autocomplete="off"
        list={list && list.length > 0 ? id : undefined}
        value={draft ?? field.text}
        disabled={disabled}
        onInput={(event) => setDraft(event.currentTarget.value)}
        onBlur={take}
        onKeyDown={(event) => {
          if (event.key === "Enter") take();
          else if (event.key === "Escape" && draft !== undefined) setDraft(undefined);
          else return;
          event.preventDefault();
          event.stopPropagation();
        }}
      />
      {list && list.length > 0 && <datalist id={id}>{list.map((each) => <option key={each} value={each} />)}</datalist>}
    </>
  );
}

/** The names that a reference can have: of entities of the kind that its field is called after. */
function namesFor(field: Field): string[] {
  const kinds = ["material", "texture", "camera", "background", "object"].filter((each) => field.name.toLowerCase().includes(each));
  const entities = state.outline.value?.entities ?? [];
  return [...new Set(entities.filter((each) => each.name !== "" && (kinds.length === 0 || kinds.includes(each.kind))).map((each) => each.name))];
}

function filesFor(): string[] {
  return state.files.value.filter((each) => each.kind !== "folder").map((each) => each.name);
}

/** What a field is set with, by its kind. */
export function PropertyValue(props: ValueProps) {
  const { field, set, disabled } = props;
  switch (field.kind) {
    case "number":
    case "integer":
      return <NumberField quiet optional={field.text === ""} label={field.name} text={field.text} rules={rulesOf(field)} unit={field.unit} disabled={disabled} begin={beginGesture} commit={(text) => text !== "" && set(text)} />;
    case "vector":
    case "color":
      // A default may be a word, as "none".
      if (partsOf(field.text).some((each) => !checkNumber(each).ok)) return <TextValue {...props} />;
      return field.kind === "color" ? <ColourValue {...props} /> : <VectorValue {...props} />;
    case "boolean":
      return <input type="checkbox" aria-label={field.name} checked={/^true$/i.test(field.text)} disabled={disabled} onChange={(event) => set(String(event.currentTarget.checked))} />;
    case "choice":
      return (
        <select aria-label={field.name} value={field.text} disabled={disabled} onChange={(event) => set(event.currentTarget.value)}>
          {[...new Set([field.text, ...(field.choices ?? [])])].map((each) => <option key={each} value={each}>{each}</option>)}
        </select>
      );
    case "expression":
    case "data":
      return <code class="expression">{field.text}</code>;
    case "reference":
      return <TextValue {...props} list={field.choices ?? namesFor(field)} />;
    case "file":
      return <TextValue {...props} list={filesFor()} />;
    default:
      return <TextValue {...props} />;
  }
}

/** What its row says of the values that a field may have. */
export function expectedWords(field: Field): string {
  if (!["number", "integer", "vector", "color"].includes(field.kind)) return "";
  const numbers = partsOf(field.text).map(Number);
  const isColour = field.kind === "color" && numbers.length >= 3 && numbers.every(Number.isFinite);
  // A number has its unit beside it already.
  const unit = field.kind === "vector" ? field.unit : undefined;
  return [isColour ? `${hexOf(numbers)} in sRGB` : "", unit ?? "", field.range ? rangeWords(rulesOf(field)) : ""].filter(Boolean).join(", ");
}

/** Whether what the text says is no number of the field's rules. */
export function isOdd(field: Field): boolean {
  return (field.kind === "number" || field.kind === "integer") && field.present !== false && !checkNumber(field.text, rulesOf(field)).ok;
}
