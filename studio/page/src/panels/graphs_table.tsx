import { useState } from "preact/hooks";
import type { TileTimes } from "../core/protocol.js";
import { quantile } from "../core/series.js";
import { count, short } from "../core/view_words.js";
import * as measures from "../measures.js";
import * as state from "../state.js";

/** What is measured, in the order in which it is shown. */
export const TITLES: Record<string, [title: string, unit: string]> = {
  rays_per_second: ["Rays a second", ""],
  tiles_per_second: ["Tiles a second", ""],
  cpu_program: ["CPU of the program", "%"],
  cpu_workers: ["CPU of the workers", "%"],
  cpu_machine: ["CPU of the machine", "%"],
  worker_use: ["Use of the workers", "%"],
  memory: ["Memory of program and workers", "B"],
  memory_machine: ["Memory of the machine", "B"],
  latency_median: ["Key to pixels in the program, median", "s"],
  latency_p95: ["Key to pixels in the program, 95 %", "s"],
};
/** Told beside others, not drawn. */
const NOT_DRAWN = new Set(["memory_machine_total"]);
export const WINDOW_MS = 600_000;

export function titleOf(name: string): [title: string, unit: string] {
  return Object.hasOwn(TITLES, name) ? TITLES[name]! : [name.replaceAll("_", " "), ""];
}

export function isDrawn(name: string): boolean {
  return !NOT_DRAWN.has(name);
}

export function latencyWords(): string {
  const latencies = measures.latencies.map((each) => each.value);
  return `${quantile(latencies, 0.5).toFixed(0)} ms, 95 %: ${quantile(latencies, 0.95).toFixed(0)} ms`;
}

/** How many tiles took how long, in words. */
export function tileTimeWords({ counts, bounds }: TileTimes): string[] {
  return counts.map((each, index) => `${count(each, "tile")} ${index < bounds.length ? `up to ${bounds[index]} s` : "longer"}`);
}

interface Row {
  title: string;
  values: readonly number[];
  words: (value: number) => string;
}

/** What was measured in the time that graphs show. */
export function rowsOf(names: readonly string[]): Row[] {
  const since = Date.now() - WINDOW_MS;
  const recent = <Measured extends { at: number }>(all: readonly Measured[]) => all.filter((each) => each.at >= since);
  const metrics = recent(state.metrics.value);
  const percent = (value: number) => `${Math.round(100 * value)} %`;
  return [
    { title: "Key to pixels", values: recent(measures.latencies).map((each) => each.value), words: (value: number) => `${value.toFixed(0)} ms` },
    ...names.map((name) => {
      const [title, unit] = titleOf(name);
      return { title, values: metrics.filter((each) => name in each.values).map((each) => each.values[name]!), words: (value: number) => `${short(value)}${unit}` };
    }),
    ...[...state.workerUse.value].map(([name, points]) => ({ title: `Use of ${name}`, values: recent(points).map((each) => each.value), words: percent })),
  ].filter((each) => each.values.length > 0);
}

/** All that is drawn, as a table: who reads it by ear always has it, others where they ask for it. */
export function GraphsTable({ names }: { names: readonly string[] }) {
  const [isSeen, setSeen] = useState(false);
  const { value: times } = state.tileTimes;
  return (
    <div class="graphs-table">
      <button type="button" aria-pressed={isSeen} onClick={() => setSeen(!isSeen)}>As a table</button>
      <div class={isSeen ? "" : "visually-hidden"}>
        <table aria-label="What was measured in the last ten minutes">
          <thead><tr><th>What</th><th class="number">Now</th><th class="number">Least</th><th class="number">Median</th><th class="number">Most</th></tr></thead>
          <tbody>
            {rowsOf(names).map(({ title, values, words }) => (
              <tr key={title}>
                <th scope="row">{title}</th>
                {[values[values.length - 1]!, Math.min(...values), quantile(values, 0.5), Math.max(...values)].map((each, index) => <td key={index} class="number">{words(each)}</td>)}
              </tr>
            ))}
          </tbody>
        </table>
        {times && (
          <table aria-label="Times of tiles">
            <thead><tr><th>Time</th><th class="number">Tiles</th></tr></thead>
            <tbody>
              {times.counts.map((each, index) => <tr key={index}><th scope="row">{index < times.bounds.length ? `up to ${times.bounds[index]} s` : "longer"}</th><td class="number">{each}</td></tr>)}
            </tbody>
          </table>
        )}
      </div>
    </div>
  );
}
