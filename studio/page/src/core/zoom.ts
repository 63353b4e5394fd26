// How a picture is enlarged on the screen. A scale is how many points of the screen (device-independent pixels) a side of
// a picture's pixel takes. Those from 1 on are whole, so that each pixel is a square like all others.

/** `x` and `y`: which point of the picture is in the middle of its frame, by shares of the sides. */
export interface Zoom {
  /** "fit": as large as the frame has room for. */
  scale: number | "fit";
  x: number;
  y: number;
}

/** All of the picture. */
export const WHOLE: Zoom = { scale: "fit", x: 0.5, y: 0.5 };
const SCALES = [1 / 64, 1 / 48, 1 / 32, 1 / 24, 1 / 16, 1 / 12, 1 / 8, 1 / 6, 1 / 4, 1 / 3, 1 / 2, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];

type Size = readonly [width: number, height: number];

/** The scale at which a picture of so many pixels fills a place of so many points, and is whole points wide: browsers
    round other widths, and what is shown would not be at the scale that is told. One of SCALES by which the picture is
    less than a point larger or smaller is taken in its stead; 1 where either has no size yet. */
export function fitScale(points: Size, pixels: Size): number {
  const [across, down] = [points[0] / pixels[0], points[1] / pixels[1]];
  const fit = Math.min(across, down);
  if (!(fit > 0 && Number.isFinite(fit))) return 1;
  const near = SCALES.find((each) => Math.abs(each - fit) * (across < down ? pixels[0] : pixels[1]) < 1);
  return near ?? Math.max(1, Math.floor(fit * pixels[0])) / pixels[0];
}

/** The part of a picture that its frame shows; `factor`: how many times larger than the whole picture would be. */
export interface Shown {
  factor: number;
  x: number;
  y: number;
}

export function shown(zoom: Zoom, fit: number): Shown {
  return { factor: zoom.scale === "fit" ? 1 : zoom.scale / fit, x: zoom.x, y: zoom.y };
}

/** No side of the frame is left empty by a picture that is larger; one that is smaller is in its middle. */
function kept(zoom: Zoom, fit: number): Zoom {
  const rim = Math.min(0.5, 0.5 / shown(zoom, fit).factor);
  const within = (at: number) => Math.min(1 - rim, Math.max(rim, at));
  return { scale: zoom.scale, x: within(zoom.x), y: within(zoom.y) };
}

/** The point of the picture that is seen at a point of the frame, both by shares of the sides. */
export function pictureAt({ factor, x, y }: Shown, right: number, down: number): [number, number] {
  return [x + (right - 0.5) / factor, y + (down - 0.5) / factor];
}

/** Where in the frame a point of the picture is seen; the inverse of pictureAt(). */
export function frameAt(seen: Shown, x: number, y: number): [number, number] {
  return [(x - seen.x) * seen.factor + 0.5, (y - seen.y) * seen.factor + 0.5];
}

/** At that scale; what is seen at that point of the frame stays there. */
export function scaledTo(zoom: Zoom, fit: number, scale: Zoom["scale"], right = 0.5, down = 0.5): Zoom {
  const [x, y] = pictureAt(shown(zoom, fit), right, down);
  const wanted: Zoom = { scale: scale === fit ? "fit" : scale, x, y };
  const { factor } = shown(wanted, fit);
  return kept({ ...wanted, x: x - (right - 0.5) / factor, y: y - (down - 0.5) / factor }, fit);
}

/** So many scales larger, from 1:1 or what fits, whichever is smaller. */
export function zoomed(zoom: Zoom, fit: number, steps: number, right = 0.5, down = 0.5): Zoom {
  const scales = [...new Set([...SCALES.filter((each) => each > Math.min(1, fit)), 1, fit])].sort((a, b) => a - b);
  const now = zoom.scale === "fit" ? fit : zoom.scale;
  // The frame may have become another since the scale was chosen.
  const nearest = scales.reduce((best, each, index) => (Math.abs(each - now) < Math.abs(scales[best]! - now) ? index : best), 0);
  return scaledTo(zoom, fit, scales[Math.min(scales.length - 1, Math.max(0, nearest + steps))]!, right, down);
}

/** What is seen is moved by shares of the frame. */
export function panned(zoom: Zoom, fit: number, right: number, down: number): Zoom {
  const { factor } = shown(zoom, fit);
  return kept({ ...zoom, x: zoom.x - right / factor, y: zoom.y - down / factor }, fit);
}

/** Moved no further than is needed to see that point of the picture. */
export function showing(zoom: Zoom, fit: number, x: number, y: number): Zoom {
  const half = 0.5 / shown(zoom, fit).factor;
  const near = (at: number, middle: number) => Math.min(at + half, Math.max(at - half, middle));
  return kept({ ...zoom, x: near(x, zoom.x), y: near(y, zoom.y) }, fit);
}

/** For a sheet as large as the frame, whose origin is its corner. */
export function transformOf(seen: Shown): string {
  const [right, down] = frameAt(seen, 0, 0);
  return `translate(${right * 100}%, ${down * 100}%) scale(${seen.factor})`;
}

/** What a scale is called: "2:1" is two points for a pixel. */
export function scaleWords(scale: number): string {
  return scale >= 1 ? `${Number(scale.toPrecision(3))}:1` : `1:${Number((1 / scale).toPrecision(3))}`;
}
