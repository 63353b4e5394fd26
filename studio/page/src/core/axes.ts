// Points and directions in the axes of something, and in those of the world.

import { add, cross, dot, subtract, times } from "./camera.js";
import type { Axes, Vector } from "./protocol.js";

const column = (axes: Axes, index: number): Vector => [axes[index]!, axes[4 + index]!, axes[8 + index]!];

/** A direction of those axes, in the world's. */
export function directionInWorld(axes: Axes, v: Vector): Vector {
  return add(add(times(column(axes, 0), v[0]), times(column(axes, 1), v[1])), times(column(axes, 2), v[2]));
}

export function pointInWorld(axes: Axes, p: Vector): Vector {
  return add(directionInWorld(axes, p), column(axes, 3));
}

/** The other way round; without finite numbers where the axes are flat. */
export function directionInAxes(axes: Axes, v: Vector): Vector {
  const [x, y, z] = [column(axes, 0), column(axes, 1), column(axes, 2)];
  const volume = dot(x, cross(y, z));
  return [dot(v, cross(y, z)) / volume, dot(v, cross(z, x)) / volume, dot(v, cross(x, y)) / volume];
}

export function pointInAxes(axes: Axes, p: Vector): Vector {
  return directionInAxes(axes, subtract(p, column(axes, 3)));
}
