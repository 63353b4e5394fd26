// The commands that move the view: by keys while a picture has the focus, and by their names.

import * as maths from "../core/camera.js";
import { pathTo } from "../core/entities.js";
import type { FreeCamera } from "../core/protocol.js";
import * as state from "../state.js";
import { boundsOf, whenPlacesAreKnown } from "./filter.js";
import { pan, toggleCrossHair } from "./magnifier.js";
import { change, turn } from "./navigation.js";
import { pick } from "./picking.js";
import { isPanoramic, moveCamera, setPivot } from "./wish.js";

/** Of the frame, which a key moves the enlarged picture by. */
const PAN_STEP = 0.1;
/** Of the scene's size, which is seen of what has none, such as a light. */
const LEAST_SHARE = 0.01;
/** Degrees, and shares of the distance to the target. */
const COARSE = { degrees: 5, stride: 0.05 };
const FINE = { degrees: 1, stride: 0.01 };
type Step = typeof COARSE;

interface ViewCommand {
  name: string;
  keys: readonly string[];
  inView: readonly string[];
  run: () => void;
}

type Act = (pane: state.Pane) => unknown;

function command(name: string, key: string, act: Act): ViewCommand {
  return { name, keys: [], inView: [key], run: () => void act(state.activePane.peek()) };
}

/** The same in two steps, the smaller one with Shift. */
function stepped(name: string, key: string, act: (pane: state.Pane, step: Step) => unknown): ViewCommand[] {
  return [command(name, key, (pane) => act(pane, COARSE)), command(`${name}, by a smaller step`, `Shift-${key}`, (pane) => act(pane, FINE))];
}

/** Turns what a camera sees; what looks along an axis is moved. */
function orbit(right: number, over: number): (pane: state.Pane, step: Step) => unknown {
  return (pane, { degrees }) =>
    change(pane, (camera) => {
      if (isPanoramic(pane)) return maths.look(camera, right * degrees, over * degrees);
      if (pane.side.peek() === undefined) return turn(camera, right * degrees, over * degrees);
      const share = ((camera.orthographic ?? 1) * degrees) / 100;
      return maths.move(camera, -right * share, over * share, 0);
    });
}

/** Turns the camera where it stands; what looks along an axis goes on doing so. */
function look(right: number, over: number): Act {
  return (pane) => pane.side.peek() === undefined && change(pane, (camera) => maths.look(camera, right * COARSE.degrees, over * COARSE.degrees));
}

/** What is seen at the cross-hair or under the pointer, or else in the middle, is orbited about. */
function pivotAtCrossHair(pane: state.Pane): void {
  const [width, height] = pane.size.peek();
  pick(pane, ...(pane.pointer.peek() ?? ([width >> 1, height >> 1] as const)), true);
}

function move(right: number, up: number, forward: number): (pane: state.Pane, step: Step) => unknown {
  return (pane, { stride }) =>
    change(pane, (camera: FreeCamera) => {
      const metres = stride * maths.length(maths.subtract(camera.target, camera.eye));
      return maths.move(camera, right * metres, up * metres, forward * metres);
    });
}

function see(side: maths.Side): Act {
  return (pane) => {
    if (pane.side.peek() === undefined) return change(pane, (camera) => maths.along(camera, side));
    pane.side.value = side;
    return moveCamera(null, false, pane);
  };
}

function fitAll(pane: state.Pane): void {
  if (pane.side.peek()) return moveCamera(null, false, pane);
  const bounds = state.summary.peek()?.bounds;
  if (bounds) change(pane, (camera) => maths.fit(camera, bounds));
}

/** Of the selected entity and those that it stands in, the innermost that is somewhere; else all. */
function fitSelected(pane: state.Pane): void {
  const outline = state.outline.peek();
  const chosen = state.selectedEntity.peek();
  if (!outline || chosen === undefined) return fitAll(pane);
  whenPlacesAreKnown(() => {
    const path = pathTo(outline.entities, chosen).reverse();
    const found = path.map((each) => boundsOf(outline.file, each.id)).find(Boolean);
    if (!found) return fitAll(pane);
    const all = state.summary.peek()?.bounds;
    const bounds = maths.noSmaller(found, all ? LEAST_SHARE * maths.length(maths.subtract(all[1], all[0])) : LEAST_SHARE);
    const side = pane.side.peek();
    if (side) moveCamera(maths.fittedAlong(bounds, side, ...pane.size.peek()), false, pane);
    else change(pane, (camera) => maths.fit(camera, bounds));
    setPivot(undefined);
  });
}

export const VIEW_COMMANDS: readonly ViewCommand[] = [
  ...stepped("Camera: orbit to the left", "Left", orbit(1, 0)),
  ...stepped("Camera: orbit to the right", "Right", orbit(-1, 0)),
  ...stepped("Camera: orbit upwards", "Up", orbit(0, 1)),
  ...stepped("Camera: orbit downwards", "Down", orbit(0, -1)),
  ...stepped("Camera: move forward", "W", move(0, 0, 1)),
  ...stepped("Camera: move back", "S", move(0, 0, -1)),
  ...stepped("Camera: move to the left", "A", move(-1, 0, 0)),
  ...stepped("Camera: move to the right", "D", move(1, 0, 0)),
  ...stepped("Camera: move down", "Q", move(0, -1, 0)),
  ...stepped("Camera: move up", "E", move(0, 1, 0)),
  command("Camera: look to the left", "Alt-Shift-Left", look(1, 0)),
  command("Camera: look to the right", "Alt-Shift-Right", look(-1, 0)),
  command("Camera: look upwards", "Alt-Shift-Up", look(0, 1)),
  command("Camera: look downwards", "Alt-Shift-Down", look(0, -1)),
  command("Camera: set the pivot at the cross-hair", "X", pivotAtCrossHair),
  command("Camera: nearer", "+", (pane) => change(pane, (camera) => maths.dolly(camera, 1 / 1.12))),
  command("Camera: farther", "-", (pane) => change(pane, (camera) => maths.dolly(camera, 1.12))),
  command("Camera: from the top", "1", see("top")),
  command("Camera: from the front", "2", see("front")),
  command("Camera: from the side", "3", see("side")),
  command("Camera: frame the selection", "F", fitSelected),
  command("Camera: frame all of the scene", "Shift-F", fitAll),
  command("Pick: cross-hair, on or off", "Enter", toggleCrossHair),
  command("Zoom: move the enlarged picture to the left", "Ctrl-Left", (pane) => pan(pane, PAN_STEP, 0)),
  command("Zoom: move the enlarged picture to the right", "Ctrl-Right", (pane) => pan(pane, -PAN_STEP, 0)),
  command("Zoom: move the enlarged picture up", "Ctrl-Up", (pane) => pan(pane, 0, PAN_STEP)),
  command("Zoom: move the enlarged picture down", "Ctrl-Down", (pane) => pan(pane, 0, -PAN_STEP)),
];
