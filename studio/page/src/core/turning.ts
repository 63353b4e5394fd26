// What a drag over the picture does to places and directions of lights and to angles of backgrounds, which fields of texts hold.

import { add, dot, frameOf, length, metresPerPixel, normalised, subtract, times, turned } from "./camera.js";
import { directionInAxes, directionInWorld, pointInAxes, pointInWorld } from "./axes.js";
import type { Axes, Field, FreeCamera, Vector } from "./protocol.js";

const WORLD: Axes = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
const DEGREES_PER_PIXEL = 0.35;
const DIGITS = 4;

const short = (value: number) => Number(value.toFixed(DIGITS)).toString();

const POSITION = /(^|[._])(position|origin|location)$/i;
const DIRECTION = /(^|[._])(direction|pointing)$/i;

/** What a drag is of. */
export interface Draggable {
  fields: readonly Field[];
  isLight: boolean;
  /** A light that has a place, too, is turned there, not moved. */
  turns: boolean;
}

/** The field that a drag changes: the place of a light or else its direction, or the angle of a panorama; nothing where the entity has none. */
export function draggable({ fields, isLight, turns }: Draggable): Field | undefined {
  const vector = (name: RegExp) => fields.find((field) => field.kind === "vector" && name.test(field.name) && field.locked === undefined);
  const direction = vector(DIRECTION);
  return (
    (isLight && !(turns && direction) ? vector(POSITION) : undefined) ??
    direction ??
    fields.find((field) => field.kind === "number" && /^panorama\.angle$/.test(field.name) && field.locked === undefined)
  );
}

/** A drag of so many pixels over a picture of that size. */
export interface PictureDrag {
  right: number;
  down: number;
  width: number;
  height: number;
}

/** The place after a drag along the plane through it that faces the camera: it stays under the pointer. */
export function movedPosition(position: Vector, camera: FreeCamera, { right: dx, down: dy, width, height }: PictureDrag): Vector {
  const { right, up, forward } = frameOf(camera);
  const depth = dot(subtract(position, camera.eye), forward);
  const distance = length(subtract(camera.target, camera.eye));
  // What is behind the eye moves as what is looked at does.
  const share = camera.orthographic === undefined && depth > 0 && distance > 0 ? depth / distance : 1;
  const metres = metresPerPixel(camera, width, height) * share;
  return add(position, add(times(right, dx * metres), times(up, -dy * metres)));
}

/** The direction of light after a drag, as if one turned a ball that it lights: what is lit follows the pointer. */
export function turnedDirection(direction: Vector, camera: FreeCamera, dx: number, dy: number): Vector {
  const { right, up } = frameOf(camera);
  return turned(turned(normalised(direction), up, dx * DEGREES_PER_PIXEL), right, dy * DEGREES_PER_PIXEL);
}

/** The text of the field, which is in those axes, after a drag from where it began. */
export function draggedText(field: Field, camera: FreeCamera, drag: PictureDrag, axes: Axes = WORLD): string | undefined {
  if (field.kind === "number") {
    const angle = Number(field.text);
    // What is seen follows the pointer; the angle grows to the left.
    return Number.isFinite(angle) ? short(angle - drag.right * DEGREES_PER_PIXEL) : undefined;
  }
  const numbers = field.text.trim().split(/[\s,]+/).map(Number);
  if (numbers.length !== 3 || !numbers.every(Number.isFinite)) return undefined;
  const vector = numbers as Vector;
  const changed = POSITION.test(field.name)
    ? pointInAxes(axes, movedPosition(pointInWorld(axes, vector), camera, drag))
    : directionInAxes(axes, turnedDirection(directionInWorld(axes, vector), camera, drag.right, drag.down));
  return changed.every(Number.isFinite) ? changed.map(short).join(" ") : undefined;
}
