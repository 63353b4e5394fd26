import { short } from "../core/view_words.js";
import * as state from "../state.js";

/** What the false colours of the view stand for, in numbers. */
export function Legend() {
  const { value: legend } = state.legend;
  if (!legend || !legend.scale || (legend.channel !== state.channel.value && legend.channel !== "cost")) return null;
  if (!legend.known) return <div class="legend">{`${legend.channel}: unknown yet, as each pixel has one sample`}</div>;
  return (
    <div class="legend" role="img" aria-label={`${legend.channel}: from ${short(legend.low)} to ${short(legend.high)}, mean ${short(legend.mean)}`}>
      <i />
      <span class="steps">{legend.steps.map((each) => <span key={each}>{short(each)}</span>)}</span>
      <span class="aside">{`${legend.channel}, mean ${short(legend.mean)}, most ${short(legend.high)}`}</span>
    </div>
  );
}
