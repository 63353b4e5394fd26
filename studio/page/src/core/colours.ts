// Linear colours and the bytes that screens show for them.

function toSrgb(linear: number): number {
  const value = Math.min(1, Math.max(0, linear));
  return value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
}

function toLinear(srgb: number): number {
  return srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4;
}

/** `#rrggbb` of a linear colour; what is brighter than white is white. */
export function hexOf(linear: readonly number[]): string {
  return `#${[0, 1, 2].map((index) => Math.round(toSrgb(linear[index] ?? 0) * 255).toString(16).padStart(2, "0")).join("")}`;
}

/** The linear colour of `#rrggbb`, to four decimals. */
export function linearOf(hex: string): [number, number, number] {
  const part = (index: number) => Number(toLinear(parseInt(hex.slice(1 + 2 * index, 3 + 2 * index), 16) / 255).toFixed(4));
  return [part(0), part(1), part(2)];
}
