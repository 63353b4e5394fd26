// Values over time, as graphs draw them.

export interface Point {
  at: number;
  value: number;
}

/** The path of a line through the points, in a box of 100 by 40, from `from` to `to`, with its largest value at the top. */
export function linePath(points: readonly Point[], from: number, to: number, most: number): string {
  const scale = most > 0 ? 38 / most : 0;
  return points
    .map((point, index) => {
      const x = to > from ? (100 * (point.at - from)) / (to - from) : 100;
      return `${index === 0 ? "M" : "L"}${x.toFixed(2)} ${(39 - Math.min(most, point.value) * scale).toFixed(2)}`;
    })
    .join("");
}

/** The same, closed down to the ground. */
export function areaPath(points: readonly Point[], from: number, to: number, most: number): string {
  if (points.length === 0) return "";
  const line = linePath(points, from, to, most);
  const x = (at: number) => (to > from ? (100 * (at - from)) / (to - from) : 100).toFixed(2);
  return `${line}L${x(points[points.length - 1]!.at)} 40L${x(points[0]!.at)} 40Z`;
}

/** A round number at least as large: 1, 2 or 5 times a power of ten. */
export function roundedUp(value: number): number {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  for (const step of [1, 2, 5, 10]) if (step * power >= value * (1 - 1e-9)) return step * power;
  return 10 * power;
}

/** The value that so large a share of them is at most. */
export function quantile(values: readonly number[], share: number): number {
  if (values.length === 0) return 0;
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))]!;
}

/** The one of that time, or the next to it. */
export function nearest(points: readonly Point[], at: number): Point | undefined {
  let found = points[0];
  for (const point of points) if (found && Math.abs(point.at - at) < Math.abs(found.at - at)) found = point;
  return found;
}
