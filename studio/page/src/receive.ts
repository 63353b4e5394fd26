// What the page does with each message of the program.

import { copyText } from "./clipboard.js";
import * as downloads from "./downloads.js";
import * as documents from "./documents.js";
import { problemsCame } from "./editor/problem_marks.js";
import { answered, changesText, receiveChange } from "./entities.js";
import { takeSettings } from "./layout/layout_state.js";
import * as looked from "./looked.js";
import * as measures from "./measures.js";
import type { Metrics, Problem, WorkerReport } from "./core/protocol.js";
import type { ProgramEvents } from "./program.js";
import * as program from "./program.js";
import { answer, refuse } from "./questions.js";
import { sceneWasRead } from "./reading.js";
import { exported, ordered, orderRefused } from "./renders.js";
import * as state from "./state.js";
import * as compare from "./view/compare.js";
import * as filter from "./view/filter.js";
import * as uploads from "./uploads.js";
import { takeWorkspace } from "./workspace.js";
import * as frames from "./view/frames.js";
import * as smallPictures from "./view/small_pictures.js";
import { partsCame } from "./view/parts.js";
import { picked } from "./view/picking.js";
import { resend } from "./view/wish.js";
import { workerTilesCame } from "./view/worker_tiles.js";
import type { Painted } from "./worker/messages.js";

const MOST_LOG_LINES = 2000;
const MOST_METRICS = 600;
let logSerial = 0;
let firstWelcome = true;
let runId: string | undefined;

export const handlers: ProgramEvents["handlers"] = {
  welcome(message) {
    state.welcome.value = message;
    if (runId !== message.id) program.toWorker({ kind: "restart" });
    compare.forget();
    // The program tells all that it keeps of it anew.
    state.log.value = [];
    runId = message.id;
    if (firstWelcome) takeSettings(message.settings ?? {});
    documents.reopen(message.id);
    program.send("list", {});
    if (firstWelcome) takeWorkspace(message.workspace, message.file);
    firstWelcome = false;
    resend();
    frames.askAnew();
  },
  files(message) {
    state.files.value = message.entries;
    state.filesTruncated.value = message.truncated;
  },
  document(message) {
    documents.settle(message.file);
    documents.receive(message);
    documents.revealPending(message.file);
  },
  edited: documents.receiveEdited,
  saved: documents.receiveSaved,
  draft: documents.receiveDraft,
  disk: documents.receiveDisk,
  change: receiveChange,
  problems(message) {
    if (message.file !== state.sceneFile.peek()) return;
    state.knownProblems.value = new Map([[message.file, { version: message.version, list: message.list.map(withoutEmpty) }]]);
    problemsCame();
    sceneWasRead(message);
  },
  summary(message) {
    if (message.file === state.sceneFile.peek()) state.summary.value = message;
  },
  outline(message) {
    state.outlines.value = new Map(state.outlines.peek()).set(message.file, message);
  },
  fields: (message) => (state.fields.value = message),
  completions: answer,
  hovered: answer,
  placement: answer,
  camera_text: answer,
  created(message) {
    program.send("list", {});
    documents.open(message.file);
  },
  put: (message) => void uploads.putCame(message),
  job(message) {
    frames.pane.noteJob(message);
    smallPictures.pane.noteJob(message);
    const pane = state.panes[message.pane];
    if (!pane) return;
    if (message.serial !== undefined) pane.lastPass = message;
    // What tells of a state alone is about the pass that is shown.
    pane.job.value = pane.lastPass?.file === message.file ? { ...pane.lastPass, ...message, stale: message.stale } : message;
    if (message.state === "tracing" || message.state === "done") state.paused.value = false;
  },
  progress(message) {
    const pane = state.panes[message.pane];
    if (pane) pane.progress.value = message;
  },
  picked,
  parts: partsCame,
  probed: (message) => (state.probed.value = message),
  pinned: compare.pinnedCame,
  compared: compare.comparedCame,
  centers: filter.centersCame,
  workers(message) {
    state.workers.value = message.list;
    noteUse(message.list);
  },
  metrics({ tile_times: times, ...values }) {
    state.metrics.value = [...state.metrics.peek().slice(1 - MOST_METRICS), { at: Date.now(), values: values as Metrics }];
    if (!times) return;
    const before = state.tileTimes.peek()?.counts ?? [];
    state.tileTimes.value = { ...times, counts: times.counts.map((count, index) => count + (before[index] ?? 0)) };
  },
  legend(message) {
    if (message.pane === 0) state.legend.value = message;
  },
  tiles: workerTilesCame,
  log(message) {
    const lines = message.lines.map((each) => ({ ...each, serial: ++logSerial }));
    state.log.value = [...state.log.peek(), ...lines].slice(-MOST_LOG_LINES);
  },
  renders(message) {
    const before = filesWritten();
    state.renders.value = message.list;
    if (filesWritten() > before) program.send("list", {});
    looked.ask();
  },
  farm(message) {
    const before = state.farm.peek();
    state.farm.value = message;
    if (message.trouble && !before?.trouble) state.notify(`The farm at ${message.endpoint}: ${message.trouble}`, "error");
    if (!message.trouble && before?.trouble) state.notify(`The farm at ${message.endpoint} answers again.`);
  },
  ordered,
  exported(message) {
    exported(message.number);
    if (message.command !== undefined) return void copyText(message.command);
    if (message.download !== undefined) return downloads.expect(message.download, message.name ?? "picture", message.show ?? false);
    state.notify(`Written: ${message.name}`);
    program.send("list", {});
  },
  refused(message) {
    if (message.request === "open" && message.file !== undefined) documents.openRefused(message.file);
    if (message.request === "edit" && message.file !== undefined) documents.editRefused(message.file);
    if (message.request === "save" && message.file !== undefined) documents.saveRefused(message.file);
    if (message.upload !== undefined) return uploads.failed(message.upload, message.why);
    if (message.number !== undefined && (orderRefused(message.number, message) || refuse(message.number))) return;
    if (changesText(message.request)) answered();
    if (message.entity !== undefined && message.field !== undefined && message.found !== undefined) {
      state.refusedField.value = { entity: message.entity, field: message.field, words: message.why };
      return;
    }
    const where = message.file ? `${message.file}: ` : "";
    state.notify(`${where}${message.why}`, "error");
  },
};

export function painted(message: Painted): void {
  frames.pane.notePainted(message);
  smallPictures.pane.notePainted(message);
  const pane = state.panes[message.pane];
  if (pane) pane.painted.value = message;
  if (pane?.lastPass?.serial === message.serial) pane.shownFile.value = pane.lastPass.file;
  if (pane !== state.main) return;
  measures.shown(state.sceneFile.peek(), message);
}

/** By the full pictures that are listed. */
function filesWritten(): number {
  return state.renders.peek().reduce((sum, { written = [], written_count: count = written.length }) => sum + count, 0);
}

/** Of workers that are gone nothing is kept. */
function noteUse(list: WorkerReport[]): void {
  const before = state.workerUse.peek();
  const at = Date.now();
  state.workerUse.value = new Map(
    list.filter((each) => each.use !== undefined).map((each) => [each.name, [...(before.get(each.name) ?? []).slice(1 - MOST_METRICS), { at, value: each.use! }]]),
  );
}

/** A problem whose parts that say nothing are left out. */
function withoutEmpty(problem: Problem): Problem {
  const { found, expected, suggestion, ...rest } = problem;
  if (!(rest.end_line >= rest.line)) Object.assign(rest, { end_line: rest.line, end_column: rest.column });
  return { ...rest, ...(found ? { found } : {}), ...(expected ? { expected } : {}), ...(suggestion ? { suggestion } : {}) };
}
