// How the view is looked at.

export const MOST_STOPS = 10;

export interface KeptLook {
  channel?: string;
  exposure?: number;
  tone_map?: string;
  integrator?: string;
  filter?: string;
}

/** Of what was kept, whoever wrote it, what makes sense; `choices`: the names that the program knows. */
export function keptLook(kept: Record<string, unknown>, choices: Record<string, readonly string[]>): KeptLook {
  const { exposure } = kept;
  const isStops = typeof exposure === "number" && Math.abs(exposure) <= MOST_STOPS;
  const named = (name: keyof KeptLook, option: string = name) => (choices[option]?.includes(kept[name] as string) ? { [name]: kept[name] as string } : {});
  return { ...named("channel"), ...(isStops ? { exposure } : {}), ...named("tone_map", "tone-map"), ...named("integrator"), ...named("filter") };
}
