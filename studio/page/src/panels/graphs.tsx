import { areaPath, linePath, nearest, roundedUp } from "../core/series.js";
import { short } from "../core/view_words.js";
import * as measures from "../measures.js";
import * as state from "../state.js";
import { GraphsTable, isDrawn, latencyWords, tileTimeWords, TITLES, titleOf, WINDOW_MS } from "./graphs_table.js";
import { followsPointer, hover } from "./graph_pointer.js";
import { WorkerTimeline } from "./worker_timeline.js";

function Graph({ name }: { name: string }) {
  const [title, unit] = titleOf(name);
  const points = state.metrics.value.filter((each) => name in each.values).map((each) => ({ at: each.at, value: each.values[name]! }));
  const last = points[points.length - 1];
  if (!last) return null;
  const from = Math.max(points[0]!.at, last.at - WINDOW_MS);
  const near = hover.value === undefined ? undefined : nearest(points, from + hover.value * (last.at - from));
  const most = roundedUp(points.reduce((largest, each) => Math.max(largest, each.value), 0));
  return (
    <figure class="graph">
      <header>
        <span>{title}</span>
        <b>{short(last.value)}{unit}</b>
      </header>
      <svg
        viewBox="0 0 100 40"
        preserveAspectRatio="none"
        role="img"
        aria-label={`${title}: now ${short(last.value)}${unit}, at most ${short(most)}${unit}`}
        {...followsPointer}
      >
        <path class="area" d={areaPath(points, from, last.at, most)} />
        <path d={linePath(points, from, last.at, most)} />
      </svg>
      <output>{near && `${short(near.value)}${unit}, ${Math.round((last.at - near.at) / 1000)} s ago`}</output>
    </figure>
  );
}

function Latency() {
  const { latencies } = measures;
  if (latencies.length === 0) return null;
  const points = latencies.map(({ value }, at) => ({ at, value }));
  const last = Math.max(1, latencies.length - 1);
  const most = roundedUp(Math.max(...points.map((each) => each.value)));
  const words = latencyWords();
  const near = hover.value === undefined ? undefined : nearest(points, hover.value * last);
  return (
    <figure class="graph">
      <header>
        <span>Key to pixels</span>
        <b>{words}</b>
      </header>
      <svg viewBox="0 0 100 40" preserveAspectRatio="none" role="img" aria-label={`From a key to pixels: ${words}`} {...followsPointer}>
        <path d={linePath(points, 0, last, most)} />
      </svg>
      <output>{near && `${near.value.toFixed(0)} ms, ${latencies.length - 1 - near.at} keys ago`}</output>
    </figure>
  );
}

/** How many tiles took how long, in bars whose heights are logarithms. */
function TileTimes() {
  const { value: times } = state.tileTimes;
  const most = Math.max(0, ...(times?.counts ?? []));
  if (!times || most === 0) return null;
  const width = 100 / times.counts.length;
  const all = tileTimeWords(times);
  const words = all.filter((_, index) => times.counts[index]! > 0).join(", ");
  const near = hover.value === undefined ? undefined : all[Math.min(all.length - 1, Math.floor(hover.value * all.length))];
  return (
    <figure class="graph">
      <header>
        <span>Times of tiles</span>
        <b>{short(times.counts.reduce((sum, each) => sum + each, 0))}</b>
      </header>
      <svg viewBox="0 0 100 40" preserveAspectRatio="none" role="img" aria-label={`Times of tiles: ${words}`} {...followsPointer}>
        {times.counts.map((count, index) => {
          const height = count > 0 ? 4 + (36 * Math.log1p(count)) / Math.log1p(most) : 0;
          return <rect key={index} x={index * width} y={40 - height} width={width * 0.9} height={height} />;
        })}
      </svg>
      <output>{near}</output>
    </figure>
  );
}

export function GraphsPanel() {
  void state.painted.value;
  const latest = state.metrics.value[state.metrics.value.length - 1]?.values ?? {};
  const names = [...new Set([...Object.keys(TITLES), ...Object.keys(latest)])].filter(
    (each) => typeof latest[each] === "number" && isDrawn(each),
  );
  if (names.length === 0 && measures.latencies.length === 0) return <p class="empty">Nothing was measured yet.</p>;
  return (
    <div class="graphs" tabIndex={0}>
      <Latency />
      <TileTimes />
      <WorkerTimeline />
      {names.map((each) => <Graph key={each} name={each} />)}
      <GraphsTable names={names} />
    </div>
  );
}
