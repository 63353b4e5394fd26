import { short } from "../core/view_words.js";
import type { FarmReport, RenderReport } from "../core/protocol.js";
import { copyText } from "../clipboard.js";
import { lookAt } from "../looked.js";
import * as program from "../program.js";
import { copyCommandOf, isOver, orderExport } from "../renders.js";
import * as state from "../state.js";

function number(value: number | undefined, unit = ""): string {
  return value === undefined ? "–" : `${short(value)}${unit}`;
}

function Workers() {
  return (
    <table aria-label="Workers">
      <thead>
        <tr><th>Worker</th><th>State</th><th class="number">Threads</th><th class="number">In use</th><th class="number">Tiles</th><th class="number">Now</th><th class="number">Mean</th><th class="number">Memory</th></tr>
      </thead>
      <tbody>
        {state.workers.value.map((each) => (
          <tr key={each.name}>
            <td>{each.name}</td>
            <td>{each.state ?? ""}</td>
            <td class="number">{each.threads ?? ""}</td>
            <td class="number">{each.use === undefined ? "" : `${Math.round(100 * each.use)} %`}</td>
            <td class="number">{number(each.tiles)}</td>
            <td class="number">{each.tiles_held ?? ""}</td>
            <td class="number">{each.tiles ? number((each.tile_seconds ?? 0) / each.tiles, "s") : ""}</td>
            <td class="number">{number(each.memory, "B")}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** How another process, on this machine or another one, comes to trace for this studio. */
function AddWorker() {
  const command = state.welcome.value?.worker_command;
  if (!command) return null;
  return (
    <details class="add-worker">
      <summary>Add a worker</summary>
      <p>
        {command.includes("ipc://") ? "On this machine; for others start the studio with --bind:" : "On a machine that reaches this one:"}
      </p>
      <div class="group">
        <code>{command}</code>
        <button type="button" onClick={() => void copyText(command)}>Copy the command</button>
      </div>
    </details>
  );
}

function share(job: RenderReport): string {
  const frames = job.frames ? `${job.frames_done ?? 0} of ${job.frames[1] - job.frames[0] + 1} frames, ` : "";
  return job.tiles_total ? `${frames}${Math.floor((100 * (job.tiles_done ?? 0)) / job.tiles_total)} %` : frames;
}

function Buttons({ job }: { job: RenderReport }) {
  const order = (what: "pause" | "resume" | "cancel" | "forget") => program.send("order", { job: job.job, what });
  const over = isOver(job);
  const isPaused = job.state === "paused";
  const name = `${(job.file ?? "picture").replace(/\.[^./]*$/, "")}.png`;
  return (
    <>
      {!over && <button type="button" onClick={() => order(isPaused ? "resume" : "pause")}>{isPaused ? "Resume" : "Pause"}</button>}
      {(job.has_picture || (job.state === "tracing" && !!job.tiles_done)) && <button type="button" onClick={() => lookAt(job.job)}>Look</button>}
      {job.has_picture && <button type="button" onClick={() => orderExport({ job: job.job, name, download: true })}>Download</button>}
      <button type="button" title={job.command ?? "No option of tessera render stands for a camera that was moved"} onClick={() => copyCommandOf(job)}>Command</button>
      <button type="button" onClick={() => order(over ? "forget" : "cancel")}>{over ? "Remove" : "Cancel"}</button>
    </>
  );
}

/** What was written for it, or what it is of. */
function filesOf(job: RenderReport): string {
  const { written = [], written_count: count = written.length } = job;
  if (written.length === 0) return job.file ?? String(job.job);
  const others = count - written.length;
  return written.join(", ") + (others > 0 ? ` and ${others} before` : "");
}

function Renders() {
  return (
    <table aria-label="Full pictures">
      <thead><tr><th>Full picture</th><th>State</th><th class="number">Done</th><th class="number">Time</th><th class="number">Left</th><th /></tr></thead>
      <tbody>
        {state.renders.value.map((each) => (
          <tr key={each.job}>
            <td>{filesOf(each)}</td>
            <td title={each.why ?? ""}>{stateOf(each)}</td>
            <td class="number">{share(each)}</td>
            <td class="number">{each.elapsed ? `${each.elapsed.toFixed(1)} s` : ""}</td>
            <td class="number">{each.left ? `${each.left.toFixed(0)} s` : ""}</td>
            <td class="orders"><Buttons job={each} /></td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** What waits for the farm elsewhere is told beside its state. */
function stateOf(job: RenderReport): string {
  const more = job.why ?? (job.state === "tracing" && job.waiting_for ? `waiting for ${job.waiting_for}` : "");
  return `${job.state ?? ""}${more ? `: ${more}` : ""}`;
}

/** The farm that full pictures are sent to, and all of its jobs. */
function Elsewhere({ farm }: { farm: FarmReport }) {
  return (
    <>
      <p class={farm.trouble ? "failed" : ""} role="status">
        {`Full pictures are traced by the farm at ${farm.endpoint}${farm.trouble ? `, which does not answer: ${farm.trouble}` : farm.workers === undefined ? "." : `, which has ${farm.workers} workers.`}`}
      </p>
      {farm.jobs && farm.jobs.length > 0 && (
        <table aria-label="Jobs of the farm">
          <thead><tr><th>Job</th><th>State</th><th class="number">Priority</th><th class="number">Frames</th><th class="number">Done</th><th class="number">Time</th><th class="number">Left</th></tr></thead>
          <tbody>
            {farm.jobs.map((each) => (
              <tr key={each.job}>
                <td>{`${each.job} ${each.name}`}</td>
                <td>{`${each.state}${each.failure ? `: ${each.failure}` : each.waits_for ? `, waits for ${each.waits_for}` : ""}`}</td>
                <td class="number">{each.priority}</td>
                <td class="number">{`${each.frames.done} of ${each.frames.total}`}</td>
                <td class="number">{each.tiles.total ? `${Math.floor((100 * each.tiles.done) / each.tiles.total)} %` : ""}</td>
                <td class="number">{`${each.elapsed_seconds.toFixed(1)} s`}</td>
                <td class="number">{typeof each.remaining_seconds === "number" ? `${each.remaining_seconds.toFixed(0)} s` : ""}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </>
  );
}

export function FarmPanel() {
  return (
    <div class="scroll" tabIndex={0}>
      {state.renders.value.length > 0 && <Renders />}
      {state.farm.value && <Elsewhere farm={state.farm.value} />}
      {state.workers.value.length > 0 ? <Workers /> : <p class="empty">{state.welcome.value?.workers ?? 0} workers.</p>}
      <AddWorker />
    </div>
  );
}
