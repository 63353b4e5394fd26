// The values of one pixel as rows of a table.

/** "albedo" with its numbers; light, which the channels R, G and B are, is first. */
export interface ProbedRow {
  name: string;
  values: number[];
}

const LAYERS: Record<string, string> = { R: "light", G: "light", B: "light", N: "normal", Z: "depth", P: "position" };

/** Channels as pictures name them, "R" or "albedo.R", in the layers that they belong to. */
export function probedRows(channels: readonly string[], values: readonly number[]): ProbedRow[] {
  const rows: ProbedRow[] = [];
  channels.forEach((channel, index) => {
    const [layer] = channel.split(".") as [string];
    const name = LAYERS[layer] ?? layer;
    const last = rows[rows.length - 1];
    if (last?.name === name) last.values.push(values[index] ?? NaN);
    else rows.push({ name, values: [values[index] ?? NaN] });
  });
  return rows;
}

/** As short as tells it apart in a picture. */
export function probedNumber(value: number): string {
  return Number.isFinite(value) ? Number(value.toPrecision(5)).toString() : String(value);
}

export function hexOf(rgb: readonly number[]): string {
  return `#${rgb.map((each) => each.toString(16).padStart(2, "0")).join("")}`;
}
