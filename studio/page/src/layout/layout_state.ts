import { signal } from "@preact/signals";
import { keptKeys } from "../core/keys.js";
import { PANELS, PRESETS, ZONES, keptLayout, move, restored, show, zoneOf, type Layout, type PanelName } from "../core/layout.js";
import { keptLook } from "../core/looks.js";
import type { Settings } from "../core/protocol.js";
import { Kept } from "../kept.js";
import * as state from "../state.js";

export const layout = signal<Layout>(PRESETS.Default);
/** Which preset the layout was last set to. */
export const preset = signal<string>("Default");
/** The panel that is shown where there is room for one alone. */
export const onlyPanel = signal<PanelName>("Script");
export const narrow = signal(false);

let known: Settings | undefined;

/** The panel that takes the focus once it is shown. */
let focusDue: PanelName | undefined;

export function showPanel(panel: PanelName, focus = false): void {
  layout.value = show(layout.peek(), panel);
  onlyPanel.value = panel;
  focusDue = focus ? panel : undefined;
  takeFocus(panel);
}

/** To be called for a panel that is shown from now on: it has the focus where that was asked for. */
export function takeFocus(panel: PanelName): void {
  const region = document.querySelector<HTMLElement>(`section[aria-label="${panel}"]`);
  if (focusDue !== panel || !region) return;
  focusDue = undefined;
  const choices = [".cm-content", ".view-frame", "[tabindex='0']", "button, input, select"];
  const isSeen = (each: HTMLElement) => each.getClientRects().length > 0 && !each.matches(":disabled");
  const found = choices.map((each) => [...region.querySelectorAll<HTMLElement>(each)].find(isSeen)).find(Boolean);
  (found ?? region).focus();
}

/** The panel that has the focus, or whose tab has it. */
export function focusedPanel(): PanelName | undefined {
  const { activeElement: focused } = document;
  const name = focused?.closest<HTMLElement>("[data-panel]")?.dataset.panel ?? focused?.closest("section[aria-label]")?.getAttribute("aria-label");
  return PANELS.find((each) => each === name);
}

/** Moves the panel with the focus by so many zones; the focus stays with it. */
export function movePanel(step: number): void {
  const panel = focusedPanel();
  const zone = panel && zoneOf(layout.peek(), panel);
  if (!panel || !zone || narrow.peek()) return;
  const target = ZONES[(ZONES.indexOf(zone) + step + ZONES.length) % ZONES.length]!;
  const isTab = document.activeElement?.getAttribute("role") === "tab";
  layout.value = { ...move(layout.peek(), panel, target), maximised: undefined };
  if (isTab) requestAnimationFrame(() => document.querySelector<HTMLElement>(`.tab[data-panel="${panel}"]`)?.focus());
  else showPanel(panel, true);
}

export function choosePreset(name: keyof typeof PRESETS): void {
  layout.value = PRESETS[name];
  preset.value = name;
}

/** Takes the settings that the program kept. */
export function takeSettings(settings: Settings): void {
  known = settings;
  if (settings.theme) state.themeChoice.value = settings.theme;
  if (settings.contrast) state.contrastChoice.value = settings.contrast;
  if (typeof settings.font_size === "number") state.fontSize.value = Math.min(40, Math.max(8, settings.font_size));
  if (typeof settings.font_family === "string") state.fontFamily.value = settings.font_family;
  if (typeof settings.workers === "number") state.keptWorkers.value = settings.workers;
  if (typeof settings.nice === "number") state.keptNice.value = settings.nice;
  if (settings.mode) state.renderMode.value = settings.mode;
  const { channel, exposure, tone_map: toneMap, integrator, filter } = keptLook(settings, state.welcome.peek()?.choices ?? {});
  if (channel !== undefined) state.channel.value = channel;
  if (exposure !== undefined) state.tone.value = { ...state.tone.peek(), exposure };
  if (toneMap !== undefined) state.tone.value = { ...state.tone.peek(), "tone-map": toneMap };
  if (integrator !== undefined) state.overrides.value = { ...state.overrides.peek(), integrator };
  if (filter !== undefined) state.overrides.value = { ...state.overrides.peek(), filter };
  const panes = settings.panes as { count?: unknown; across?: unknown; down?: unknown } | undefined;
  const isShare = (value: unknown): value is number => typeof value === "number" && value > 0 && value < 1;
  if (state.PANE_COUNTS.some((count) => count === panes?.count)) state.paneCount.value = panes!.count as number;
  if (isShare(panes?.across) && isShare(panes.down)) state.paneSplit.value = { across: panes.across, down: panes.down };
  state.changedKeys.value = keptKeys(settings.keys);
  const old = restored(settings.layout);
  if (old) layout.value = old;
  kept.begin();
}

function current(): Settings {
  return {
    ...known,
    theme: state.themeChoice.value,
    contrast: state.contrastChoice.value,
    font_size: state.fontSize.value,
    font_family: state.fontFamily.value,
    workers: state.keptWorkers.value,
    nice: state.keptNice.value,
    mode: state.renderMode.value,
    channel: state.channel.value,
    exposure: state.tone.value?.exposure,
    tone_map: state.tone.value?.["tone-map"],
    integrator: state.overrides.value.integrator,
    filter: state.overrides.value.filter,
    keys: state.changedKeys.value,
    layout: keptLayout(layout.value),
    panes: { count: state.paneCount.value, ...state.paneSplit.value },
  };
}

const kept = new Kept("settings", current);

export const watchSettings = (): void => kept.watch();
