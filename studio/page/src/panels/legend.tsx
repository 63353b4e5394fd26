import { short } from "../core/view_words.js";
import * as state from "../state.js";
import { mode, numbers } from "../view/compare.js";

interface ScaleProps {
  /** What the colours stand for. */
  what: string;
  /** The numbers at even distances along the colours, from the least to the largest. */
  steps: readonly number[];
  low: number;
  high: number;
  mean: number;
}

function Scale({ what, steps, low, high, mean }: ScaleProps) {
  return (
    <div class="legend" role="img" aria-label={`${what}: from ${short(low)} to ${short(high)}, mean ${short(mean)}`}>
      <i />
      <span class="steps">{steps.map((each) => <span key={each}>{short(each)}</span>)}</span>
      <span class="aside">{`${what}, mean ${short(mean)}, most ${short(high)}`}</span>
    </div>
  );
}

/** Of the difference from the pinned picture, whose colours go by the root (difference_pixels() in picture_comparison.cpp). */
function DifferenceScale() {
  const { max_difference: most, mean_difference: mean } = numbers.value ?? {};
  if (typeof most !== "number" || typeof mean !== "number" || most === 0) return null;
  const steps = [0, 0.25, 0.5, 0.75, 1].map((share) => share * share * most);
  return <Scale what="difference" steps={steps} low={0} high={most} mean={mean} />;
}

/** What the false colours of the view stand for, in numbers. */
export function Legend() {
  const { value: legend } = state.legend;
  if (mode.value === "difference") return <DifferenceScale />;
  if (!legend || !legend.scale || (legend.channel !== state.channel.value && legend.channel !== "cost")) return null;
  if (!legend.known) return <div class="legend">{`${legend.channel}: unknown yet, as each pixel has one sample`}</div>;
  return <Scale what={legend.channel} {...legend} />;
}
