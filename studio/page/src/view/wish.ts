// What each picture of the view is to show: sent whole whenever any of it changes, at most once a frame.

import { effect, signal, untracked } from "@preact/signals";
import { fittedAlong } from "../core/camera.js";
import type { CameraWish, FreeCamera, SceneCamera, Vector, ViewWish } from "../core/protocol.js";
import * as documents from "../documents.js";
import * as program from "../program.js";
import * as state from "../state.js";
import { isProbing } from "./probe.js";
import { showsWorkerTiles } from "./worker_tiles.js";

/** Between two wishes of a pane, whatever the screen's frames: the program counts messages. */
const LEAST_BETWEEN_MS = 14;
const AFTER_MOVEMENT_MS = 150;
/** What is fitted where a scene has nothing that ends. */
const NOTHING: [Vector, Vector] = [[-1, -1, -1], [1, 1, 1]];

/** What a pane's wishes are in the midst of. */
class Sender {
  private due = false;
  private sent = "";
  private sentAt = -Infinity;
  private stillDue: ReturnType<typeof setTimeout> | undefined;
  private moving = false;

  constructor(private readonly pane: state.Pane) {}

  /** Sends the wish with the next frame, or soon where there are none as nobody looks. */
  schedule(): void {
    if (this.due) return;
    this.due = true;
    let done = false;
    const once = () => {
      if (done) return;
      done = true;
      this.due = false;
      this.send();
    };
    const frame = () => {
      if (performance.now() - this.sentAt < LEAST_BETWEEN_MS) requestAnimationFrame(frame);
      else once();
    };
    requestAnimationFrame(frame);
    setTimeout(once, 100);
  }

  forget(): void {
    this.sent = "";
  }

  /** The pane is not seen any more. */
  hide(): void {
    if (this.pane.area.peek()[0] !== 0) this.pane.area.value = [0, 0];
    this.close();
  }

  /** The pane shows no scene any more. */
  close(): void {
    this.pane.job.value = undefined;
    this.pane.painted.value = undefined;
    this.pane.shownFile.value = undefined;
    if (this.sent !== "") program.send("close_view", { pane: this.pane.number });
    this.sent = "";
  }

  move(byHand: boolean): void {
    this.moving = byHand;
    clearTimeout(this.stillDue);
    if (!byHand) return;
    this.stillDue = setTimeout(() => {
      this.moving = false;
      this.schedule();
    }, AFTER_MOVEMENT_MS);
  }

  private send(): void {
    const file = state.sceneFile.peek();
    const { number, size } = this.pane;
    const [width, height] = size.peek();
    const camera = wishedCamera(this.pane);
    if (file === undefined || width < 1 || height < 1 || camera === undefined) return;
    const isOfSide = this.pane.side.peek() !== undefined;
    const wish: ViewWish = {
      pane: number,
      file,
      size: [width, height],
      camera,
      frame: state.frame.peek(),
      mode: state.renderMode.peek(),
      // A lens is focused for its own camera.
      overrides: { ...state.overrides.peek(), ...(isOfSide ? { pinhole: true } : {}) },
      channel: state.channel.peek(),
      tone: state.tone.peek(),
      ...(state.hidden.peek().length > 0 ? { hidden: state.hidden.peek() } : {}),
      ...(state.solo.peek().length > 0 ? { solo: state.solo.peek() } : {}),
      ...(isProbing.peek() ? { aovs: true } : {}),
      ...(showsWorkerTiles.peek() ? { tiles: true } : {}),
      ...(this.moving ? { moving: true } : {}),
    };
    const text = JSON.stringify(wish);
    if (text === this.sent) return;
    program.toWorker({ kind: "size", pane: number, width, height });
    if (!program.send("view", wish)) return;
    this.sent = text;
    this.sentAt = performance.now();
  }
}

function seenPanes(): state.Pane[] {
  return state.panes.slice(0, state.paneCount.peek());
}

const senders = new Map<state.Pane, Sender>();

function senderOf(pane: state.Pane): Sender {
  let found = senders.get(pane);
  if (!found) senders.set(pane, (found = new Sender(pane)));
  return found;
}

/** From where a pane is seen; nothing where that is not known yet. */
function wishedCamera(pane: state.Pane): CameraWish | undefined {
  const { value: camera } = pane.camera;
  const { value: side } = pane.side;
  if (camera && "eye" in camera && camera.name !== undefined && !isOfScene(camera.name)) {
    // What it was moved from is there no more.
    const { name: _, ...rest } = camera;
    return rest;
  }
  if (camera || !side) return camera;
  const { value: summary } = state.summary;
  const [width, height] = pane.size.value;
  if (summary?.file !== state.sceneFile.value || width < 1) return undefined;
  return fittedAlong(summary?.bounds ?? NOTHING, side, width, height);
}

/** How large the pane's picture is to be: as the pane is, unless another size is asked for. */
function wishedSize(pane: state.Pane): [number, number] {
  const { width, height } = state.askedSize.value;
  const { value: area } = pane.area;
  if (pane !== state.main || area[0] === 0 || (width === undefined && height === undefined)) return area;
  const [sceneWidth, sceneHeight] = state.summary.value?.size ?? area;
  return [width ?? sceneWidth, height ?? sceneHeight];
}

/** Watches all that a wish is made of. */
export function watchWishes(): void {
  for (const pane of state.panes) {
    effect(() => {
      const [width, height] = wishedSize(pane);
      const [oldWidth, oldHeight] = pane.size.peek();
      if (width !== oldWidth || height !== oldHeight) pane.size.value = [width, height];
    });
    effect(() => {
      const isSeen = pane.number < state.paneCount.value;
      const hasScene = state.sceneFile.value !== undefined;
      void [
        pane.size.value,
        wishedCamera(pane),
        state.overrides.value,
        state.channel.value,
        state.tone.value,
        state.renderMode.value,
        state.frame.value,
        state.hidden.value,
        state.solo.value,
        isProbing.value,
        showsWorkerTiles.value,
      ];
      untracked(() => {
        if (!isSeen) senderOf(pane).hide();
        else if (hasScene) senderOf(pane).schedule();
        else senderOf(pane).close();
      });
    });
  }
}

/** Sends the wishes anew, to a program that does not know them. */
export function resend(): void {
  for (const pane of seenPanes()) {
    senderOf(pane).forget();
    senderOf(pane).schedule();
  }
}

/** Takes what a pane's element has for its picture. The program waits until it no longer changes. */
export function resized(pane: state.Pane, width: number, height: number): void {
  if (pane.number >= state.paneCount.peek()) return;
  const screen = globalThis.devicePixelRatio || 1;
  const ratio = Math.min(screen, Math.sqrt(state.mostOf("pixels") / Math.max(1, width * height)));
  const whole = ratio < screen ? Math.floor : Math.round;
  const area: [number, number] = [whole(width * ratio), whole(height * ratio)];
  pane.points.value = [width, height];
  const old = pane.area.peek();
  if (area[0] !== old[0] || area[1] !== old[1]) pane.area.value = area;
}

/** What the camera orbits about; nothing: what it looks at. */
export const pivot = signal<Vector | undefined>(undefined);

/** The view stays where it is. */
export function setPivot(point: Vector | undefined): void {
  pivot.value = point;
}

/** Shows the scene from another camera; `byHand` while it is still moved. */
export function moveCamera(camera: CameraWish, byHand: boolean, pane = state.main): void {
  senderOf(pane).move(byHand);
  pane.camera.value = camera;
  if (camera === null && pane === state.main) pivot.value = undefined;
}

/** The cameras of the scene that is shown, each by what `--camera` takes: its name, or else its number. */
export function sceneCameras(): SceneCamera[] {
  const cameras = state.summary.value?.cameras ?? [];
  return cameras.map((each, index) => ({ ...each, name: each.name || String(index + 1) }));
}

/** What users are told of a camera: a number is none of a name. */
export function titleOfCamera(name: string): string {
  const { value: summary } = state.summary;
  return summary?.cameras.some((each) => each.name === name) ? name : `camera ${name}`;
}

function isOfScene(camera: string): boolean {
  return sceneCameras().some((each) => each.name === camera);
}

/** The scene's camera that is seen through, or that was moved. */
function sceneCameraOf(wish: CameraWish | undefined): SceneCamera | undefined {
  const cameras = sceneCameras();
  return wish?.name === undefined ? cameras[0] : cameras.find((each) => each.name === wish.name);
}

/** Whether the pane sees all around, as from the middle of a panorama. */
export function isPanoramic(pane: state.Pane): boolean {
  return pane.side.peek() === undefined && sceneCameraOf(pane.camera.peek())?.panoramic === true;
}

/** The camera that the picture is seen from, by its numbers; nothing where the program has not told them. */
export function currentCamera(pane = state.main): FreeCamera | undefined {
  const wish = wishedCamera(pane);
  if (wish && "eye" in wish) return wish;
  if (pane.side.value) return undefined;
  const scene = sceneCameraOf(wish);
  if (!scene?.eye || !scene.target) return undefined;
  return {
    eye: scene.eye,
    target: scene.target,
    up: scene.up ?? [0, 1, 0],
    fov: scene.fov ?? 40,
    axis: scene.axis ?? "smaller",
    ...(scene.orthographic === undefined ? {} : { orthographic: scene.orthographic }),
    ...(wish ? { name: wish.name } : {}),
  };
}

/** Tells the program what to do with all pictures of the view. */
function order(what: "pause" | "resume" | "stop" | "refresh"): boolean {
  return seenPanes().map((pane) => program.send(what, { pane: pane.number })).some(Boolean);
}

export function pauseOrResume(): void {
  const pausing = !state.paused.peek();
  order(pausing ? "pause" : "resume");
  state.paused.value = pausing;
}

export function stop(): void {
  order("stop");
}

export function refresh(): void {
  state.paused.value = false;
  // The picture is that of the text that is seen.
  documents.flush();
  order("refresh");
}

const HIDDEN_PAUSE_MS = 10_000;

/** A page that nobody sees renders nothing after a while. */
export function watchVisibility(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let pausedByUs = false;
  document.addEventListener("visibilitychange", () => {
    clearTimeout(timer);
    if (document.hidden) {
      timer = setTimeout(() => {
        if (state.paused.peek()) return;
        pausedByUs = order("pause");
      }, HIDDEN_PAUSE_MS);
    } else if (pausedByUs) {
      pausedByUs = false;
      order("resume");
    }
  });
}
