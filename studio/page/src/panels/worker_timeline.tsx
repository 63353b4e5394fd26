import { nearest, type Point } from "../core/series.js";
import * as state from "../state.js";
import { followsPointer, hover } from "./graph_pointer.js";
import { WINDOW_MS } from "./graphs_table.js";

const percent = (share: number) => `${Math.round(100 * share)} %`;

/** One row: the fuller a second's bar, the more of it the worker worked. */
function Row({ name, points, from, to }: { name: string; points: readonly Point[]; from: number; to: number }) {
  const width = 100_000 / Math.max(1000, to - from);
  const near = hover.value === undefined ? undefined : nearest(points, from + hover.value * (to - from));
  const mean = points.reduce((sum, each) => sum + each.value, 0) / Math.max(1, points.length);
  return (
    <>
      <span>{name}</span>
      <svg viewBox="0 0 100 10" preserveAspectRatio="none" role="img" aria-label={`${name}: now ${percent(points[points.length - 1]?.value ?? 0)} in use, in the mean ${percent(mean)}`} {...followsPointer}>
        {points.map((each) => (
          <rect key={each.at} x={(100 * (each.at - from)) / Math.max(1000, to - from) - width} y={10 - 10 * each.value} width={width} height={10 * each.value} />
        ))}
      </svg>
      <output>{near && `${percent(near.value)}, ${Math.round((to - near.at) / 1000)} s ago`}</output>
    </>
  );
}

/** The use of each worker over time, one row each. */
export function WorkerTimeline() {
  const rows = [...state.workerUse.value];
  if (rows.length === 0) return null;
  const to = Math.max(...rows.map(([, points]) => points[points.length - 1]?.at ?? 0));
  const from = Math.max(to - WINDOW_MS, Math.min(...rows.map(([, points]) => points[0]?.at ?? to)) - 1000);
  return (
    <figure class="graph">
      <header><span>Workers at work</span></header>
      <div class="timeline">
        {rows.map(([name, points]) => <Row key={name} name={name} points={points} from={from} to={to} />)}
      </div>
    </figure>
  );
}
