// Which panel stands where, as values: zones with tabs, and the shares of the window between them.

export const PANELS = [
  "Files", "Models", "Script", "View", "Scene", "Properties", "Problems", "Console", "Graphs", "Farm", "Animation",
] as const;
export type PanelName = (typeof PANELS)[number];

export const ZONES = ["left", "middle", "top", "low", "bottom"] as const;
/** `top` and `low` are the halves of the right. */
export type ZoneName = (typeof ZONES)[number];

export interface Zone {
  tabs: PanelName[];
  shown: PanelName | undefined;
}

export interface Shares {
  /** Of the width. */
  left: number;
  middle: number;
  /** Of the right's height. */
  top: number;
  /** Of the height. */
  bottom: number;
}
export type ShareName = keyof Shares;

export interface Layout {
  zones: Record<ZoneName, Zone>;
  shares: Shares;
  maximised?: ZoneName;
}

function zone(...tabs: PanelName[]): Zone {
  return { tabs, shown: tabs[0] };
}

export const PRESETS: Record<"Default" | "CRT" | "LUX", Layout> = {
  Default: {
    zones: {
      left: zone("Files", "Models"),
      middle: zone("Script"),
      top: zone("View"),
      low: zone("Scene", "Properties"),
      bottom: zone("Problems", "Console", "Graphs", "Farm", "Animation"),
    },
    shares: { left: 0.14, middle: 0.36, top: 0.62, bottom: 0.26 },
  },
  CRT: {
    zones: {
      left: zone("View", "Animation"),
      middle: zone("Script"),
      top: zone("Scene", "Files", "Models"),
      low: zone("Properties"),
      bottom: zone("Console", "Graphs", "Problems", "Farm"),
    },
    shares: { left: 0.4, middle: 0.4, top: 0.5, bottom: 0.3 },
  },
  LUX: {
    zones: {
      left: zone("Models", "Properties"),
      middle: zone(),
      top: zone("View"),
      low: zone(),
      bottom: zone(),
    },
    shares: { left: 0.3, middle: 0, top: 1, bottom: 0 },
  },
};

const LEAST = 0.06;

export function zoneOf(layout: Layout, panel: PanelName): ZoneName | undefined {
  return ZONES.find((name) => layout.zones[name].tabs.includes(panel));
}

/** Brings a panel to the top of its zone; a panel of no zone comes into the one at the bottom, or the first that has any. */
export function show(layout: Layout, panel: PanelName): Layout {
  const name = zoneOf(layout, panel);
  if (!name) {
    const target = layout.zones.bottom.tabs.length > 0 ? "bottom" : (ZONES.find((each) => layout.zones[each].tabs.length > 0) ?? "top");
    return move(layout, panel, target);
  }
  const maximised = layout.maximised && layout.maximised !== name ? name : layout.maximised;
  return { ...layout, maximised, zones: { ...layout.zones, [name]: { ...layout.zones[name], shown: panel } } };
}

/** Moves a panel to another zone, where it is shown. */
export function move(layout: Layout, panel: PanelName, target: ZoneName): Layout {
  const zones = { ...layout.zones };
  for (const name of ZONES) {
    const { tabs, shown } = zones[name];
    const index = tabs.indexOf(panel);
    if (index < 0) continue;
    const rest = tabs.filter((each) => each !== panel);
    zones[name] = { tabs: rest, shown: shown === panel ? rest[Math.min(index, rest.length - 1)] : shown };
  }
  zones[target] = { tabs: [...zones[target].tabs, panel], shown: panel };
  return { ...layout, zones };
}

/** Sets a share, so that everything keeps some room. */
export function resize(layout: Layout, name: ShareName, share: number): Layout {
  const most = name === "left" ? 1 - layout.shares.middle - LEAST : name === "middle" ? 1 - layout.shares.left - LEAST : 1 - LEAST;
  return { ...layout, shares: { ...layout.shares, [name]: Math.min(Math.max(LEAST, share), Math.max(LEAST, most)) } };
}

export function maximise(layout: Layout, name: ZoneName | undefined): Layout {
  return { ...layout, maximised: layout.maximised === name ? undefined : name };
}

/** A layout as it is kept: without a zone that is maximised, and with all panels that there were. */
export type KeptLayout = Omit<Layout, "maximised"> & { panels?: readonly PanelName[] };

export function keptLayout({ zones, shares }: Layout): KeptLayout {
  return { zones, shares, panels: PANELS };
}

/** A layout that was kept, if it is one; panels that it does not know are added where they are by default. */
export function restored(kept: unknown): Layout | undefined {
  if (typeof kept !== "object" || kept === null) return undefined;
  const { zones, shares, panels } = kept as Partial<KeptLayout>;
  if (!zones || !shares) return undefined;
  const seen = new Set<string>();
  const result: Layout = { zones: {} as Layout["zones"], shares: { ...PRESETS.Default.shares } };
  for (const name of ZONES) {
    const tabs = zones[name]?.tabs;
    if (!Array.isArray(tabs)) return undefined;
    const known = tabs.filter((each) => PANELS.includes(each) && !seen.has(each));
    known.forEach((each) => seen.add(each));
    const shown = zones[name].shown;
    result.zones[name] = { tabs: known, shown: shown && known.includes(shown) ? shown : known[0] };
  }
  // What it knew and does not have, as LUX has not all, stays away.
  const left = Array.isArray(panels) ? panels : [];
  for (const panel of PANELS) {
    if (seen.has(panel) || left.includes(panel)) continue;
    const name = zoneOf(PRESETS.Default, panel)!;
    const { tabs, shown } = result.zones[name];
    result.zones[name] = { tabs: [...tabs, panel], shown: shown ?? panel };
  }
  for (const name of Object.keys(result.shares) as ShareName[]) {
    const share = shares[name];
    if (typeof share === "number" && share >= 0 && share <= 1) result.shares[name] = share;
  }
  return result;
}
