// How the view is looked at.

export const MOST_STOPS = 10;

/** Of what was kept, whoever wrote it, what makes sense; `choices`: the names that the program knows. */
export function keptLook(kept: Record<string, unknown>, choices: Record<string, readonly string[]>): { channel?: string; exposure?: number; integrator?: string } {
  const { exposure } = kept;
  const isStops = typeof exposure === "number" && Math.abs(exposure) <= MOST_STOPS;
  const named = (name: "channel" | "integrator") => (choices[name]?.includes(kept[name] as string) ? { [name]: kept[name] as string } : {});
  return { ...named("channel"), ...(isStops ? { exposure } : {}), ...named("integrator") };
}
