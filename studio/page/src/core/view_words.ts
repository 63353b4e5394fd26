// What the view says of itself, in words.

import type { JobReport, Progress } from "./protocol.js";

export interface ViewState {
  connection: "connecting" | "open" | "lost" | "refused";
  file: string | undefined;
  /** The file whose picture is seen. */
  shown: string | undefined;
  job: JobReport | undefined;
  progress: Progress | undefined;
  paused: boolean;
  /** An edit has waited for a while to be read. */
  reading: boolean;
  workers: number;
}

/** The state's name, for styles, and its words. */
export interface ViewWords {
  state: string;
  words: string;
}

export function viewWords(view: ViewState): ViewWords {
  if (view.connection === "connecting") return { state: "waiting", words: "connecting" };
  if (view.connection !== "open") return { state: "disconnected", words: "disconnected" };
  if (view.file === undefined) return { state: "empty", words: "open or drop a scene" };
  const { job } = view;
  if (view.paused || job?.state === "paused") return { state: "paused", words: "paused" };
  if (!job) return { state: "waiting", words: view.workers === 0 ? "waiting for workers" : "reading" };
  if (view.reading) return { state: "reading", words: "reading" };
  // Without a picture of it there is none to be old.
  if (job.stale && job.stale.as_of === null && view.shown !== view.file) return { state: "failed", words: job.stale.why || "nothing is shown" };
  if (job.stale) return { state: "stale", words: `as of ${clock(job.stale.as_of)}${job.stale.why ? `: ${job.stale.why}` : ""}` };
  switch (job.state) {
    case "tracing":
      return { state: "refining", words: refining(job, view.progress) };
    case "done":
      return { state: "done", words: `done${job.samples ? `, ${count(job.samples, "sample")}` : ""}${seconds(totalOf(job))}` };
    case "failed":
      return { state: "failed", words: `failed${job.why ? `: ${job.why}` : ""}` };
    case "stopped":
      return { state: "stopped", words: `stopped${job.why ? `: ${job.why}` : ""}` };
  }
}

/** What the status bar says beside that while a pass is traced: tiles, rays a second, seconds that went by and are left. */
export function progressWords({ job, progress }: Pick<ViewState, "job" | "progress">, raysPerSecond: number | undefined): string[] {
  if (job?.state !== "tracing" || !progress || progress.serial !== job.serial) return [];
  const { tiles_done: done, tiles_total: total, elapsed, left } = progress;
  return [
    total > 0 ? `${done} of ${count(total, "tile")}` : "",
    raysPerSecond ? `${short(raysPerSecond)}rays/s` : "",
    elapsed === undefined ? "" : `${elapsed.toFixed(1)} s`,
    left === undefined || left < 0 ? "" : `${left.toFixed(1)} s left`,
  ].filter(Boolean);
}

function refining(job: JobReport, progress: Progress | undefined): string {
  const words = [(job.scale ?? 1) > 1 ? `1/${job.scale} size` : count(job.samples ?? 1, "sample")];
  if (progress && progress.serial === job.serial && progress.tiles_total > 0) {
    words.push(`${Math.floor((100 * progress.tiles_done) / progress.tiles_total)} %`);
  }
  return `refining, ${words.join(", ")}`;
}

export function count(number: number, what: string): string {
  return `${number} ${what}${number === 1 ? "" : "s"}`;
}

function seconds(time: number | undefined): string {
  return time === undefined ? "" : `, ${time < 10 ? time.toFixed(2) : time.toFixed(0)} s`;
}

/** Local time of milliseconds since 1970 with date and zone, as ISO 8601 has it. */
export function dateAndTime(time: number): string {
  const zone = -new Date(time).getTimezoneOffset(), ahead = Math.abs(zone);
  const two = (count: number) => String(count).padStart(2, "0");
  const local = new Date(time + zone * 60000).toISOString().slice(0, 19);
  return `${local}${zone < 0 ? "-" : "+"}${two(Math.floor(ahead / 60))}:${two(ahead % 60)}`;
}

/** HH:MM:SS of milliseconds since 1970, for what is of this hour. */
export function clock(time: number | null): string {
  return time === null ? "an earlier text" : dateAndTime(time).slice(11, 19);
}

/** A number in three significant digits; a whole one below 1000 in all of its own. */
export function short(value: number): string {
  const units = ["", "k", "M", "G", "T"];
  let unit = 0;
  while (Math.abs(value) >= 1000 && unit < units.length - 1) {
    value /= 1000;
    ++unit;
  }
  if (unit === 0) return String(Number.isInteger(value) ? value : Number(value.toPrecision(3)));
  const digits = Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : 2;
  return `${value.toFixed(digits)} ${units[unit]}`;
}

/** A place in three significant digits. */
export function placeWords(place: readonly number[]): string {
  return `(${place.map((each) => Number(each.toPrecision(3))).join(", ")})`;
}

/** Seconds that a pass took, all in all. */
function totalOf(job: JobReport): number | undefined {
  const { times } = job;
  if (!times) return undefined;
  return times.total ?? (times.parse ?? 0) + (times.build ?? 0) + (times.trace ?? 0);
}
