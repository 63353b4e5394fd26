import { useEffect, useId, useRef, useState } from "preact/hooks";
import { checkNumber, dragged, evaluate, stepped, written, type Checked, type NumberRules } from "../core/numbers.js";

export interface NumberFieldProps {
  label: string;
  text: string;
  rules?: NumberRules;
  unit?: string;
  placeholder?: string;
  /** Whether nothing is a value too. */
  optional?: boolean;
  /** What else is wrong with it, which its form knows. */
  wrong?: string | undefined;
  disabled?: boolean;
  /** Whether the label is only spoken. */
  quiet?: boolean;
  /** Hears that what is committed from now on belongs together: a drag, or what is typed before the focus leaves. */
  begin?: () => void;
  /** Takes the text of a right number; `live` while it is still dragged or typed. */
  commit: (text: string, live: boolean) => void;
}

const STILL_PX = 3;
const ANSWER_MS = 400;

interface Drag {
  x: number;
  value: number;
  moved: boolean;
}

/** A number that is checked at each key; while it is wrong, nothing is applied. Its label is dragged, or the field itself. */
export function NumberField(props: NumberFieldProps) {
  const { rules = {} } = props;
  const id = useId();
  const [draft, setDraft] = useState<string | undefined>(undefined);
  const drag = useRef<Drag | undefined>(undefined);
  const before = useRef(props.text);
  const input = useRef<HTMLInputElement | null>(null);
  const text = draft ?? props.text;
  const { also: _, ...ownRules } = rules;
  const checked: Checked = props.optional && text.trim() === "" ? { ok: true, value: NaN } : checkNumber(text, draft === undefined ? ownRules : rules);
  const fault = checked.ok ? props.wrong : `found ${checked.found}; expected ${checked.expected}`;
  const wrong = props.disabled ? undefined : fault;
  const isEdited = () => drag.current !== undefined || document.activeElement === input.current;

  // What the program made of it is shown once nobody types or drags any more.
  useEffect(() => {
    if (!isEdited()) setDraft(undefined);
  }, [props.text]);

  const change = (next: string, live = true) => {
    setDraft(next);
    if ((props.optional && next.trim() === "") || checkNumber(next, rules).ok) props.commit(next.trim(), live);
  };
  const key = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === "Enter") {
      const value = checkNumber(text, rules).ok ? undefined : evaluate(text);
      if (value !== undefined) change(written(rules.whole ? Math.round(value) : value, before.current), false);
      else if (checked.ok && draft !== undefined) props.commit(text.trim(), false);
      // What is a number already is accepted with all of its dialog.
      if (value === undefined && input.current?.form) return;
    } else if (event.key === "Escape") {
      if (draft === undefined) return;
      setDraft(undefined);
      if (before.current !== props.text) props.commit(before.current, false);
    } else {
      const base = checkNumber(text);
      const next = base.ok ? stepped(base.value, event.key, rules.whole) : undefined;
      if (next === undefined) return;
      change(written(next, text), false);
    }
    event.preventDefault();
    event.stopPropagation();
  };
  const blur = () => {
    if (!checked.ok) return;
    setDraft(undefined);
    // A draft that is not shown yet, as what it committed took the focus away, is no change to what draws.
    if (input.current) input.current.value = props.text;
  };
  const down = (event: PointerEvent) => {
    const base = checkNumber(text);
    if (!base.ok || props.disabled || event.button !== 0 || document.activeElement === input.current) return;
    // A click gives the field the focus once it is seen to be none of a drag.
    event.preventDefault();
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    drag.current = { x: event.clientX, value: base.value, moved: false };
  };
  const moved = (event: PointerEvent) => {
    const start = drag.current;
    if (!start || (!start.moved && Math.abs(event.clientX - start.x) < STILL_PX)) return;
    if (!start.moved) props.begin?.();
    start.moved = true;
    const value = dragged(start.value, event.clientX - start.x, { ctrl: event.ctrlKey, shift: event.shiftKey });
    change(written(rules.whole ? Math.round(value) : value, props.text));
  };
  const up = () => {
    const start = drag.current;
    drag.current = undefined;
    if (!start) return;
    if (start.moved) {
      setTimeout(() => !isEdited() && setDraft(undefined), ANSWER_MS);
    } else {
      input.current?.focus();
      input.current?.select();
    }
  };
  const handle = { onPointerDown: down, onPointerMove: moved, onPointerUp: up, onPointerCancel: up, onLostPointerCapture: up };
  return (
    <label class={`field number ${wrong ? "wrong" : ""}`}>
      <span class={props.quiet ? "visually-hidden" : "handle"} {...handle}>{props.label}</span>
      <span class="group">
        <input
          ref={input}
          type="text"
          class="draggable"
          inputMode="decimal"
          spellcheck={false}
          autocomplete="off"
          value={text}
          placeholder={props.placeholder}
          disabled={props.disabled}
          aria-invalid={wrong !== undefined}
          aria-describedby={wrong ? `${id}-wrong` : undefined}
          title={wrong}
          onFocus={() => {
            before.current = props.text;
            props.begin?.();
          }}
          onInput={(event) => change(event.currentTarget.value)}
          onBlur={blur}
          onKeyDown={key}
          {...handle}
        />
        {props.unit && <span class="unit">{props.unit}</span>}
      </span>
      {wrong && <span class="why" id={`${id}-wrong`}>{wrong}</span>}
    </label>
  );
}
