import { resize, type ShareName } from "../core/layout.js";
import { layout } from "./layout_state.js";

const STEP = 0.01;

interface SeparatorProps {
  label: string;
  /** Whether it stands upright, between what is left and what is right of it. */
  vertical: boolean;
  /** The share of the whole that it sets, from 0 to 1. */
  value: number;
  set: (value: number) => void;
  /** Whether the share is that of what comes after it. */
  after?: boolean;
}

/** A separator that is moved by mouse and by arrows. */
export function Separator({ label, vertical, value, set, after = false }: SeparatorProps) {
  const sign = after ? -1 : 1;
  const drag = (event: PointerEvent) => {
    const bar = event.currentTarget as HTMLElement;
    const box = bar.parentElement!.getBoundingClientRect();
    const [from, whole] = vertical ? [event.clientX, box.width] : [event.clientY, box.height];
    bar.setPointerCapture(event.pointerId);
    bar.focus();
    bar.onpointermove = (move) => set(value + (sign * ((vertical ? move.clientX : move.clientY) - from)) / whole);
    bar.onpointerup = () => (bar.onpointermove = bar.onpointerup = null);
    event.preventDefault();
  };
  const key = (event: KeyboardEvent) => {
    const [less, more] = vertical ? ["ArrowLeft", "ArrowRight"] : ["ArrowUp", "ArrowDown"];
    if (event.key !== less && event.key !== more) return;
    set(value + (event.key === more ? STEP : -STEP) * sign * (event.shiftKey ? 5 : 1));
    event.preventDefault();
  };
  return (
    <div
      class={`splitter ${vertical ? "vertical" : "horizontal"}`}
      role="separator"
      aria-label={label}
      aria-orientation={vertical ? "vertical" : "horizontal"}
      aria-valuenow={Math.round(value * 100)}
      aria-valuemin={6}
      aria-valuemax={94}
      tabIndex={0}
      onPointerDown={drag}
      onKeyDown={key}
    />
  );
}

/** Between two zones. */
export function Splitter({ share, label, vertical }: { share: ShareName; label: string; vertical: boolean }) {
  return (
    <Separator
      label={label}
      vertical={vertical}
      value={layout.value.shares[share]}
      set={(value) => (layout.value = resize(layout.peek(), share, value))}
      after={share === "bottom"}
    />
  );
}
