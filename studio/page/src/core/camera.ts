// What the mouse and the keys do to a camera. Angles are degrees; nothing here rounds.

import type { FreeCamera, Vector } from "./protocol.js";

export const add = (a: Vector, b: Vector): Vector => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const times = (a: Vector, by: number): Vector => [a[0] * by, a[1] * by, a[2] * by];
export const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const length = (a: Vector): number => Math.hypot(...a);

export function normalised(a: Vector): Vector {
  const size = length(a);
  return size > 0 ? times(a, 1 / size) : [0, 0, 0];
}

/** `vector` turned about `axis`, which has length 1, by the right-hand rule. */
export function turned(vector: Vector, axis: Vector, degrees: number): Vector {
  const angle = (degrees * Math.PI) / 180;
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  const along = times(axis, dot(axis, vector) * (1 - cosine));
  return add(add(times(vector, cosine), times(cross(axis, vector), sine)), along);
}

export interface Frame {
  forward: Vector;
  right: Vector;
  up: Vector;
}

/** The directions of a camera; where it looks along its own up, some right is taken. */
export function frameOf(camera: FreeCamera): Frame {
  const forward = normalised(subtract(camera.target, camera.eye));
  let right = normalised(cross(forward, camera.up));
  if (length(right) < 0.5) right = normalised(cross(forward, Math.abs(forward[1]) < 0.9 ? [0, 1, 0] : [0, 0, 1]));
  return { forward, right, up: cross(right, forward) };
}

/** How nearly up may lie along the view. */
const LEAST_ASIDE = 1e-9;

/** What is expected of a camera's eye, target and up, in words; nothing where they make a frame. */
export function expectedOfPose({ eye, target, up }: FreeCamera): string | undefined {
  const view = subtract(target, eye);
  if (length(view) === 0) return "an eye that is not at the target";
  if (length(up) === 0) return "an up that is not 0 0 0";
  return length(cross(normalised(view), normalised(up))) < LEAST_ASIDE ? "an up that is not along the view" : undefined;
}

/** What counts as up where a camera is turned: the axis of the world that a camera without roll stands by, else its own up. */
export function uprightOf(camera: FreeCamera): Vector {
  const { right, up } = frameOf(camera);
  let best = normalised(camera.up);
  let nearest = 0.5;
  for (const axis of [0, 1, 2]) {
    const direction: Vector = [0, 0, 0];
    direction[axis] = up[axis]! < 0 ? -1 : 1;
    const near = dot(direction, up);
    if (Math.abs(dot(direction, right)) > 1e-6 || near <= nearest) continue;
    nearest = near;
    best = direction;
  }
  return best;
}

/** How near to its pole an orbit comes. */
const POLE = 0.5;

/** Turns about the target: `right` about what is up, `over` about the camera's right. */
export function orbit(camera: FreeCamera, right: number, over: number): FreeCamera {
  const axis = uprightOf(camera);
  const eye = turned(subtract(camera.eye, camera.target), axis, -right);
  const height = (Math.asin(Math.min(1, Math.max(-1, dot(normalised(eye), axis)))) * 180) / Math.PI;
  const wanted = Math.min(90 - POLE, Math.max(POLE - 90, height + over));
  const sideways = normalised(cross(axis, eye));
  const risen = length(sideways) > 0 ? turned(eye, sideways, height - wanted) : eye;
  return { ...camera, eye: add(camera.target, risen), up: axis };
}

/** Turns camera and target about a point: what is seen there stays where it is in the picture. */
export function orbitAbout(camera: FreeCamera, pivot: Vector, right: number, over: number): FreeCamera {
  const axis = uprightOf(camera);
  const { forward, right: sideways } = frameOf(camera);
  const height = (Math.asin(Math.min(1, Math.max(-1, -dot(forward, axis)))) * 180) / Math.PI;
  const wanted = Math.min(90 - POLE, Math.max(POLE - 90, height + over));
  const turn = (point: Vector) => add(pivot, turned(turned(subtract(point, pivot), sideways, height - wanted), axis, -right));
  return { ...camera, eye: turn(camera.eye), target: turn(camera.target), up: axis };
}

/** Looks around: the eye stays. */
export function look(camera: FreeCamera, right: number, over: number): FreeCamera {
  const swapped = orbit({ ...camera, eye: camera.target, target: camera.eye }, right, -over);
  return { ...camera, target: swapped.eye, up: swapped.up };
}

/** Metres at the target's distance that one pixel spans, in a view of that size. */
export function metresPerPixel(camera: FreeCamera, width: number, height: number): number {
  if (camera.orthographic !== undefined) return camera.orthographic / Math.min(width, height);
  const spanned = { smaller: Math.min(width, height), horizontal: width, vertical: height }[camera.axis ?? "smaller"];
  const distance = length(subtract(camera.target, camera.eye));
  return (2 * distance * Math.tan((camera.fov * Math.PI) / 360)) / spanned;
}

/** Moves eye and target in the camera's own directions, in metres. */
export function move(camera: FreeCamera, right: number, up: number, forward: number): FreeCamera {
  const frame = frameOf(camera);
  const step = add(add(times(frame.right, right), times(frame.up, up)), times(frame.forward, forward));
  return { ...camera, eye: add(camera.eye, step), target: add(camera.target, step) };
}

/** Nearer to the target by that factor; what lies under `aside` (metres right and up of the target) stays there. */
export function dolly(camera: FreeCamera, factor: number, aside: [number, number] = [0, 0]): FreeCamera {
  const frame = frameOf(camera);
  const share = 1 - factor;
  const shift = add(times(frame.right, aside[0] * share), times(frame.up, aside[1] * share));
  const target = add(camera.target, shift);
  // Parallel rays would lose what they begin behind.
  if (camera.orthographic !== undefined) {
    return { ...camera, eye: add(camera.eye, shift), target, orthographic: camera.orthographic * factor };
  }
  const eye = add(camera.target, times(subtract(camera.eye, camera.target), factor));
  return { ...camera, eye: add(eye, shift), target };
}

/** Widens or narrows, within (0, 180). */
export function zoom(camera: FreeCamera, degrees: number): FreeCamera {
  return { ...camera, fov: Math.min(179, Math.max(0.5, camera.fov + degrees)) };
}

/** The box with that centre and size. */
export function around(center: Vector, size: Vector): [Vector, Vector] {
  return [subtract(center, times(size, 0.5)), add(center, times(size, 0.5))];
}

/** A box of that diagonal, where the box's own is shorter, as that of a point is. */
export function noSmaller(bounds: [Vector, Vector], least: number): [Vector, Vector] {
  if (length(subtract(bounds[1], bounds[0])) >= least) return bounds;
  const side = least / Math.sqrt(3);
  return around(times(add(bounds[0], bounds[1]), 0.5), [side, side, side]);
}

/** Looks along `direction` at what a box holds, from where all of it is seen. */
export function fit(camera: FreeCamera, bounds: [Vector, Vector], direction?: Vector, up?: Vector): FreeCamera {
  const target = times(add(bounds[0], bounds[1]), 0.5);
  const radius = Math.max(1e-6, length(subtract(bounds[1], bounds[0])) / 2);
  const isParallel = camera.orthographic !== undefined;
  // Parallel rays would lose what they begin behind.
  const distance = isParallel
    ? Math.max(radius, length(subtract(camera.target, camera.eye)))
    : radius / Math.sin((Math.min(170, camera.fov) * Math.PI) / 360);
  const forward = direction ?? frameOf(camera).forward;
  const eye = subtract(target, times(normalised(forward), distance));
  return { ...camera, eye, target, up: up ?? camera.up, ...(isParallel ? { orthographic: 2 * radius } : {}) };
}

export const SIDES = ["top", "front", "side"] as const;
export type Side = (typeof SIDES)[number];

/** From where each side is seen, and what is up there. */
const DIRECTIONS: Record<Side, [from: Vector, up: Vector]> = {
  top: [[0, 1, 0], [0, 0, -1]],
  front: [[0, 0, 1], [0, 1, 0]],
  side: [[1, 0, 0], [0, 1, 0]],
};

/** The views along the axes: from above, from the front, from the side. */
export function along(camera: FreeCamera, side: Side): FreeCamera {
  const distance = length(subtract(camera.target, camera.eye));
  const [from, up] = DIRECTIONS[side];
  return { ...camera, eye: add(camera.target, times(from, distance)), up };
}

/** More than a box, so that its edges are not those of the picture. */
const MARGIN = 1.1;

/** By parallel rays along an axis, all of a box in a picture of that size. */
export function fittedAlong(bounds: [Vector, Vector], side: Side, width: number, height: number): FreeCamera {
  const size = subtract(bounds[1], bounds[0]);
  const target = times(add(bounds[0], bounds[1]), 0.5);
  const [from, up] = DIRECTIONS[side];
  const wide = side === "side" ? size[2] : size[0];
  const high = side === "top" ? size[2] : size[1];
  // What is told spans the shorter side of the picture.
  const spanned = width >= height ? Math.max(high, (wide * height) / width) : Math.max(wide, (high * width) / height);
  const least = Math.max(1e-6, length(size) * 1e-3);
  return {
    eye: add(target, times(from, Math.max(1e-6, length(size)))),
    target,
    up,
    fov: 40,
    orthographic: Math.max(least, spanned) * MARGIN,
  };
}

/** The axis that is up most, for a camera that may have come from above. */
export function upright(camera: FreeCamera): FreeCamera {
  const { forward } = frameOf(camera);
  return Math.abs(dot(forward, normalised(camera.up))) > 0.999 ? { ...camera, up: frameOf(camera).up } : camera;
}
