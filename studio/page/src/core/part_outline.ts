// The rim of some of the parts that a part picture tells apart.

export interface PartImage {
  width: number;
  height: number;
  /** A number for each pixel; 0: nothing. */
  parts: Uint32Array;
}

/** Calls `mark` for each pixel of the parts that touches another pixel, or the picture's edge. */
export function eachRimPixel(image: PartImage, numbers: ReadonlySet<number>, mark: (x: number, y: number) => void): void {
  const { width, height, parts } = image;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const at = y * width + x;
      if (!numbers.has(parts[at]!)) continue;
      const isInside =
        x > 0 && x < width - 1 && y > 0 && y < height - 1 &&
        numbers.has(parts[at - 1]!) && numbers.has(parts[at + 1]!) &&
        numbers.has(parts[at - width]!) && numbers.has(parts[at + width]!);
      if (!isInside) mark(x, y);
    }
  }
}
