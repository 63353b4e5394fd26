// Full pictures and exports: what is asked for of the program, and what becomes of it.

import { computed, effect, untracked } from "@preact/signals";
import { copyText } from "./clipboard.js";
import { askToReplace, question } from "./confirm.js";
import type { ExportWish, RenderReport, RenderSpec, ToPage, ToProgram } from "./core/protocol.js";
import * as documents from "./documents.js";
import * as program from "./program.js";
import * as state from "./state.js";
import { writeViewCamera } from "./view/write_camera.js";
import { goToWrongField } from "./wrong_field.js";

/** Hears that what was ordered is done or begun, or why not. */
export type Answer = (why?: string) => void;

const NO_CONNECTION = "There is no connection to the program.";

interface Order {
  answer: Answer;
  /** Orders the same over files that are there. */
  replace: () => void;
  /** Of a full picture. */
  file?: string;
  done?: ((job: RenderReport) => void) | undefined;
}
/** What the program has not answered yet, by number. */
const waiting = new Map<number, Order>();
/** What is done with full pictures once they are there. */
const whenDone = new Map<RenderReport["job"], (job: RenderReport) => void>();

export const notifyRefusal: Answer = (why) => {
  if (why !== undefined) state.notify(why, "error");
};

/** What is asked for, as the view's camera, tone and frame are now. */
function asSeen(spec: RenderSpec): RenderSpec {
  const at = spec.frames || state.frame.peek() === 0 ? {} : { frame: state.frame.peek() };
  return { camera: state.camera.peek(), tone: state.tone.peek(), ...at, ...spec };
}

/** Orders the full picture of the scene that is shown. `done` has the picture. Returns whether it was ordered; where not, `answer` has heard why. */
export function orderRender(spec: RenderSpec = {}, answer: Answer = notifyRefusal, done?: (job: RenderReport) => void): boolean {
  const file = state.sceneFile.peek();
  if (file === undefined) {
    answer("No scene is shown; expected one to render.");
    return false;
  }
  documents.flush();
  const replace = () => void orderRender({ ...spec, force: true }, answer, done);
  return send("render", { file, spec: asSeen(spec) }, { answer, replace, file, done });
}

/** Orders the full picture likewise, unless a field of the page has a wrong value: then that is gone to. */
export function orderRenderOfPage(spec: RenderSpec = {}): boolean {
  const why = goToWrongField(document);
  notifyRefusal(why);
  return why === undefined && orderRender(spec);
}

/** Has a file made of a picture that there is, or of the scene. Here as there it is asked about first where
    files would be replaced. */
export function orderExport(wish: ExportWish, answer: Answer = notifyRefusal): void {
  send("export", wish, { answer, replace: () => orderExport({ ...wish, force: true }, answer) });
}

function send<K extends "render" | "export">(kind: K, body: Omit<ToProgram[K], "number">, order: Order): boolean {
  const number = program.newNumber();
  const isSent = program.send(kind, { ...body, number } as ToProgram[K]);
  if (isSent) waiting.set(number, order);
  else order.answer(NO_CONNECTION);
  return isSent;
}

/** The order of that number, which is answered now; nothing where it is none of this page's. */
function taken(number: number): Order | undefined {
  const order = waiting.get(number);
  waiting.delete(number);
  return order;
}

export function ordered({ number, job }: ToPage["ordered"]): void {
  const order = taken(number);
  if (!order) return;
  if (order.done) whenDone.set(job, order.done);
  state.notify(`The full picture of ${order.file} is ordered.`);
  order.answer();
}

export function exported(number: number): void {
  taken(number)?.answer();
}

/** Takes the program's refusal of such an order; false for one of something else. */
export function orderRefused(number: number, { why, existing }: ToPage["refused"]): boolean {
  const refused = taken(number);
  if (!refused) return false;
  if (existing) askToReplace(existing, refused.replace, () => refused.answer(why));
  else refused.answer(why);
  return true;
}

function take(list: readonly RenderReport[]): void {
  for (const each of list) {
    if (each.state === "done") whenDone.get(each.job)?.(each);
    if (isOver(each)) whenDone.delete(each.job);
  }
}

/** Watches the list of full pictures for those that are done, and for the end of the connection. */
export function watchRenders(): void {
  effect(() => {
    const { value: list } = state.renders;
    untracked(() => take(list));
  });
  effect(() => {
    if (state.connection.value === "open") return;
    const lost = [...waiting.values()];
    waiting.clear();
    untracked(() => lost.forEach((each) => each.answer(NO_CONNECTION)));
  });
}

export function isOver(job: RenderReport): boolean {
  return ["done", "failed", "cancelled"].includes(job.state ?? "");
}

/** The full picture that is being made. */
export const active = computed(() => state.renders.value.find((each) => ["reading", "tracing", "writing"].includes(each.state ?? "")));

export function stopActive(): void {
  const { value: job } = active;
  if (job) program.send("order", { job: job.job, what: "cancel" });
}

function isFree(): boolean {
  const { value: camera } = state.camera;
  return camera !== null && "eye" in camera;
}

/** Tells why there is no command line for a camera that was moved, and offers what makes one. */
function explainCommand(words: string): void {
  question.value = isFree()
    ? { title: "No command line", words: `${words} Write the camera into the text, and its name is enough.`, accept: "Write camera", run: writeViewCamera }
    : { title: "No command line", words: `${words} Render again, now that the view has a camera of the text.`, run: () => {} };
}

/** Puts the command line into the clipboard that makes a full picture. */
export function copyCommandOf(job: RenderReport): void {
  if (job.command) void copyText(job.command);
  else explainCommand("Full picture " + job.job + " was seen from a camera that was moved, for which tessera render has no option.");
}

/** The same of a picture that was not ordered yet. */
export function copyCommand(spec: RenderSpec): void {
  if (isFree()) return explainCommand("The view is seen from a camera that was moved, for which tessera render has no option.");
  const file = state.sceneFile.peek();
  orderExport({ command: asSeen(spec), ...(file === undefined ? {} : { file }) });
}

/** The same of what the view shows, at its size. */
export function copyCommandOfView(outputs: string[]): void {
  if (state.hidden.peek().length + state.solo.peek().length > 0) {
    question.value = { title: "No command line", words: "The view leaves out parts of the scene, for which tessera render has no option.", run: () => {} };
    return;
  }
  const overrides = { ...state.overrides.peek(), size: state.viewSize.peek().join("x") } as NonNullable<RenderSpec["overrides"]>;
  copyCommand({ overrides, outputs });
}
