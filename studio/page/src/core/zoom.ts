// How a picture is enlarged on the screen: by whole factors, so that each of its pixels is a square like all others.

/** `x` and `y`: which point of the picture is in the middle of its frame, by shares of the sides. */
export interface Zoom {
  factor: number;
  x: number;
  y: number;
}

/** All of the picture. */
export const WHOLE: Zoom = { factor: 1, x: 0.5, y: 0.5 };
const FACTORS = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];

/** No side of the frame is left empty. */
function kept(zoom: Zoom): Zoom {
  const rim = 0.5 / zoom.factor;
  const within = (at: number) => Math.min(1 - rim, Math.max(rim, at));
  return { factor: zoom.factor, x: within(zoom.x), y: within(zoom.y) };
}

/** The point of the picture that is seen at a point of the frame, both by shares of the sides. */
export function pictureAt(zoom: Zoom, right: number, down: number): [number, number] {
  return [zoom.x + (right - 0.5) / zoom.factor, zoom.y + (down - 0.5) / zoom.factor];
}

/** Where in the frame a point of the picture is seen; the inverse of pictureAt(). */
export function frameAt(zoom: Zoom, x: number, y: number): [number, number] {
  return [(x - zoom.x) * zoom.factor + 0.5, (y - zoom.y) * zoom.factor + 0.5];
}

/** So many factors larger; what is seen at that point of the frame stays there. */
export function zoomed(zoom: Zoom, steps: number, right = 0.5, down = 0.5): Zoom {
  const index = FACTORS.indexOf(zoom.factor) + steps;
  const factor = FACTORS[Math.min(FACTORS.length - 1, Math.max(0, index))]!;
  const [x, y] = pictureAt(zoom, right, down);
  return kept({ factor, x: x - (right - 0.5) / factor, y: y - (down - 0.5) / factor });
}

/** What is seen is moved by shares of the frame. */
export function panned(zoom: Zoom, right: number, down: number): Zoom {
  return kept({ ...zoom, x: zoom.x - right / zoom.factor, y: zoom.y - down / zoom.factor });
}

/** Moved no further than is needed to see that point of the picture. */
export function showing(zoom: Zoom, x: number, y: number): Zoom {
  const half = 0.5 / zoom.factor;
  const near = (at: number, middle: number) => Math.min(at + half, Math.max(at - half, middle));
  return kept({ ...zoom, x: near(x, zoom.x), y: near(y, zoom.y) });
}

/** For a sheet as large as the frame, whose origin is its corner. */
export function transformOf(zoom: Zoom): string {
  const [right, down] = frameAt(zoom, 0, 0);
  return `translate(${right * 100}%, ${down * 100}%) scale(${zoom.factor})`;
}
