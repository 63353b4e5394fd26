// Mouse and keys over the picture.

import * as maths from "../core/camera.js";
import type { FreeCamera } from "../core/protocol.js";
import * as state from "../state.js";
import { moveCrossHair, pan, toggleCrossHair, zoom } from "./magnifier.js";
import { pick } from "./picking.js";
import * as light from "./turning.js";
import { currentCamera, isPanoramic, moveCamera, pivot } from "./wish.js";

const DEGREES_PER_PIXEL = 0.35;
const CLICK_PIXELS = 3;
/** Pixels that a key moves the cross-hair by. */
const CROSS_HAIR_STEP = 16;

/** A pane's frame with the sheet in it, which holds the picture and may be larger. */
export interface PaneElements {
  frame: HTMLElement;
  sheet: HTMLElement;
}

/** Where on the picture an event is, in its pixels. */
export function pixelOf(pane: state.Pane, sheet: HTMLElement, event: { clientX: number; clientY: number }): [number, number] {
  const box = sheet.getBoundingClientRect();
  const [width, height] = pane.size.peek();
  const x = Math.floor(((event.clientX - box.left) * width) / box.width);
  const y = Math.floor(((event.clientY - box.top) * height) / box.height);
  return [Math.min(width - 1, Math.max(0, x)), Math.min(height - 1, Math.max(0, y))];
}

export function change(pane: state.Pane, make: (camera: FreeCamera) => FreeCamera): boolean {
  const camera = currentCamera(pane);
  if (!camera) return false;
  moveCamera(make(camera), true, pane);
  return true;
}

interface Drag {
  button: number;
  x: number;
  y: number;
  moved: number;
  shift: boolean;
  /** Of the picture on the screen, not of the camera. */
  ofSheet: boolean;
  /** Of light or the background; with where it began. */
  ofLight: [x: number, y: number] | undefined;
}

export function watchPointer(pane: state.Pane, { frame, sheet }: PaneElements): void {
  let drag: Drag | undefined;
  let last = { x: 0, y: 0 };
  frame.addEventListener("contextmenu", (event) => event.preventDefault());
  frame.addEventListener("focus", () => (state.activePane.value = pane));
  frame.addEventListener("pointerdown", (event) => {
    frame.setPointerCapture(event.pointerId);
    drag = { button: event.button, x: event.clientX, y: event.clientY, moved: 0, shift: event.shiftKey, ofSheet: event.altKey, ofLight: undefined };
    if (!event.ctrlKey || event.button !== 0) return;
    drag.ofLight = [event.clientX, event.clientY];
    light.beginDrag(event.shiftKey);
  });
  frame.addEventListener("pointermove", (event) => {
    if (!drag) {
      // Browsers tell of moves, too, when something moves under a pointer that rests.
      if (last.x === event.clientX && last.y === event.clientY) return;
      last = { x: event.clientX, y: event.clientY };
      state.activePane.value = pane;
      pane.hasCrossHair.value = false;
      pane.pointer.value = pixelOf(pane, sheet, event);
      return;
    }
    const dx = event.clientX - drag.x;
    const dy = event.clientY - drag.y;
    drag.moved += Math.abs(dx) + Math.abs(dy);
    if (drag.moved < CLICK_PIXELS) return;
    drag.x = event.clientX;
    drag.y = event.clientY;
    if (drag.ofLight) dragLight(pane, drag.ofLight, event, sheet);
    else if (drag.ofSheet) pan(pane, dx / frame.clientWidth, dy / frame.clientHeight);
    else change(pane, (camera) => dragged(pane, camera, drag!, dx, dy, sheet));
  });
  frame.addEventListener("pointerup", (event) => {
    if (drag && drag.moved < CLICK_PIXELS && drag.button === 0) pick(pane, ...pixelOf(pane, sheet, event), event.detail > 1);
    if (drag?.ofLight) light.endDrag();
    drag = undefined;
  });
  frame.addEventListener("dblclick", (event) => pick(pane, ...pixelOf(pane, sheet, event), true));
  frame.addEventListener("pointerleave", () => {
    if (!pane.hasCrossHair.peek()) pane.pointer.value = undefined;
  });
  frame.addEventListener("pointercancel", () => (drag = undefined));
  let turned = 0;
  frame.addEventListener("wheel", (event) => {
    event.preventDefault();
    const notches = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
    if (!event.altKey) return wheel(pane, sheet, event, notches);
    turned += notches;
    const steps = Math.trunc(turned);
    if (steps === 0) return;
    turned -= steps;
    const box = frame.getBoundingClientRect();
    zoom(pane, -steps, [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height]);
  }, { passive: false });
}

function dragLight(pane: state.Pane, [x, y]: [number, number], event: PointerEvent, sheet: HTMLElement): void {
  const { width, height } = sheet.getBoundingClientRect();
  light.dragTo(pane, { right: event.clientX - x, down: event.clientY - y, width, height });
}

function dragged(pane: state.Pane, camera: FreeCamera, drag: Drag, dx: number, dy: number, sheet: HTMLElement): FreeCamera {
  // What looks along an axis goes on doing so.
  if (pane.side.peek() !== undefined || drag.button === 1 || (drag.button === 0 && drag.shift)) {
    const box = sheet.getBoundingClientRect();
    const metres = maths.metresPerPixel(camera, box.width, box.height);
    return maths.move(camera, -dx * metres, dy * metres, 0);
  }
  // From the middle of a panorama there is nothing to go around.
  if (drag.button === 2 || isPanoramic(pane)) return maths.look(camera, dx * DEGREES_PER_PIXEL * 0.5, dy * DEGREES_PER_PIXEL * 0.5);
  return turn(maths.upright(camera), dx * DEGREES_PER_PIXEL, dy * DEGREES_PER_PIXEL);
}

/** Orbits about the pivot, or else about what the camera looks at. */
export function turn(camera: FreeCamera, right: number, over: number): FreeCamera {
  const about = pivot.peek();
  return about ? maths.orbitAbout(camera, about, right, over) : maths.orbit(camera, right, over);
}

function wheel(pane: state.Pane, sheet: HTMLElement, event: WheelEvent, notches: number): void {
  if (event.ctrlKey) {
    change(pane, (camera) => maths.zoom(camera, notches * 0.57));
    return;
  }
  const box = sheet.getBoundingClientRect();
  change(pane, (camera) => {
    const metres = maths.metresPerPixel(camera, box.width, box.height);
    const right = (event.clientX - box.left - box.width / 2) * metres;
    const up = (box.top + box.height / 2 - event.clientY) * metres;
    return maths.dolly(camera, 1.12 ** notches, [right, up]);
  });
}

/** What an arrow's key goes to, right and down. */
const ARROWS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** The keys of the cross-hair, while it is there; true where one did something. */
export function crossHairKey(pane: state.Pane, event: KeyboardEvent): boolean {
  if (event.ctrlKey || event.metaKey || event.altKey || !pane.hasCrossHair.peek() || !pane.pointer.peek()) return false;
  const arrow = ARROWS[event.key];
  const step = event.shiftKey ? 1 : CROSS_HAIR_STEP;
  if (arrow) moveCrossHair(pane, arrow[0] * step, arrow[1] * step);
  else if (event.key === "Enter") pick(pane, ...pane.pointer.peek()!);
  else if (event.key === "Escape") toggleCrossHair(pane);
  else return false;
  return true;
}
