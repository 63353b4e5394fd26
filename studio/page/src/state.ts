// What the page knows, as signals: panels read them and draw themselves again when they change.

import { computed, signal, type Signal } from "@preact/signals";
import type {
  CameraWish,
  ChainLink,
  EntityId,
  EntityRef,
  FarmReport,
  FileEntry,
  JobReport,
  Legend,
  LogLine,
  Metrics,
  Outline,
  Overrides,
  Problem,
  Progress,
  RenderMode,
  RenderReport,
  Summary,
  TileTimes,
  Tone,
  ToPage,
  WorkerReport,
} from "./core/protocol.js";
import { SIDES, type Side } from "./core/camera.js";
import type { Zoom } from "./core/zoom.js";
import { fitScale, shown, WHOLE } from "./core/zoom.js";
import type { Painted } from "./worker/messages.js";

export type Connection = "connecting" | "open" | "lost" | "refused";

export const connection = signal<Connection>("connecting");
/** Why the program does not answer, for the user. */
export const connectionWords = signal("");
export const welcome = signal<ToPage["welcome"] | undefined>(undefined);
/** The names that an option of `tessera render` takes. */
export function choicesOf(option: string): readonly string[] {
  return welcome.value?.choices[option] ?? [];
}
/** The largest number that may be asked for. */
export function mostOf(what: string): number {
  return welcome.value?.limits[what] ?? Infinity;
}
export const files = signal<FileEntry[]>([]);
export const filesTruncated = signal(false);

/** The file in the editor, and the scene file that the view shows: a .mtl or .obj beside it does not replace it. */
export const activeFile = signal<string | undefined>(undefined);
export const sceneFile = signal<string | undefined>(undefined);

/** Problems as the program told them last, by the scene file that was read. */
export const knownProblems = signal<Map<string, { version: number; list: Problem[] }>>(new Map());
/** What is shown of them: nothing while someone types. */
export const problems = signal<Problem[]>([]);
export const summary = signal<Summary | undefined>(undefined);
/** Of the open files, by their names. */
export const outlines = signal<Map<string, Outline>>(new Map());
export function forgetOutline(file: string): void {
  const rest = new Map(outlines.peek());
  if (rest.delete(file)) outlines.value = rest;
}
/** That of the file in the editor; of the scene where the editor's has none. */
export const outline = computed<Outline | undefined>(() => {
  const of = (file: string | undefined) => (file === undefined ? undefined : outlines.value.get(file));
  return of(activeFile.value) ?? of(sceneFile.value);
});
/** Unlike the outline, this outlives a text that cannot be read. */
export const selectedEntity = signal<EntityId | undefined>(undefined);
/** The fields of an entity that was selected, as the program told them last. */
export const fields = signal<ToPage["fields"] | undefined>(undefined);
/** Why a field was not set. */
export const refusedField = signal<{ entity: EntityId; field: string; words: string } | undefined>(undefined);
export const chain = signal<ChainLink[]>([]);

/** One picture of the view: from where it is seen, and how far its passes have come. */
export class Pane {
  readonly job = signal<JobReport | undefined>(undefined);
  readonly progress = signal<Progress | undefined>(undefined);
  readonly painted = signal<Painted | undefined>(undefined);
  /** The scene file that the picture is of. */
  readonly shownFile = signal<string | undefined>(undefined);
  /** Of the picture, in its pixels. */
  readonly size = signal<[number, number]>([0, 0]);
  /** Of what there is for it on the screen, in the screen's pixels; 0 where the pane is not seen. */
  readonly area = signal<[number, number]>([0, 0]);
  readonly camera = signal<CameraWish>(null);
  /** The same in points of the screen, which several of its pixels may make. */
  readonly points = signal<[number, number]>([0, 0]);
  readonly zoom = signal<Zoom>(WHOLE);
  /** The scale at which all of the picture is seen. */
  readonly fit = computed(() => fitScale(this.points.value, this.size.value));
  /** The part of the picture that is seen. */
  readonly shown = computed(() => shown(this.zoom.value, this.fit.value));
  /** The pixel that is pointed at. */
  readonly pointer = signal<[number, number] | undefined>(undefined);
  /** Whether keys move the pointer, as a cross-hair. */
  readonly hasCrossHair = signal(false);
  /** The side of the scene that is seen while the camera is not moved; nothing: what the scene's camera sees. */
  readonly side: Signal<Side | undefined>;
  /** The pass that was told of last. */
  lastPass: JobReport | undefined;

  constructor(readonly number: number, side?: Side) {
    this.side = signal(side);
  }
}
/** The one that is worked with most, which workers serve before all else. */
export const main = new Pane(0);
export const panes: readonly Pane[] = [main, ...SIDES.map((side, index) => new Pane(index + 1, side))];
/** The panes that nobody sees, whose pictures are made for something else. */
export const PANES_ASIDE = { samples: 6, frames: 7 } as const;
/** How many of them are seen. */
export const PANE_COUNTS = [1, 2, 4] as const;
export const paneCount = signal<number>(1);
/** The shares of the width and of the height that the first column and row have. */
export const paneSplit = signal<{ across: number; down: number }>({ across: 0.5, down: 0.5 });
export const { job, progress, painted, size: viewSize, camera } = main;
/** The one that was pointed at last, or had the focus. */
export const activePane = signal(main);
/** What the view leaves out of the scene; and what it shows alone, if any. */
export const hidden = signal<EntityRef[]>([]);
export const solo = signal<EntityRef[]>([]);
export const overrides = signal<Overrides>({});
/** The size of the first pane's picture in place of the pane's own; of a side that is missing the scene says. */
export const askedSize = signal<{ width?: number; height?: number }>({});
export const channel = signal("light");
export const tone = signal<Tone | null>(null);
export const renderMode = signal<RenderMode>("typing");
export const frame = signal(0);
export const paused = signal(false);
export const probed = signal<ToPage["probed"] | undefined>(undefined);

export const workers = signal<WorkerReport[]>([]);
/** How many there are, without those that were lost; before they are told of, how many were started. */
export const workerCount = computed(() =>
  workers.value.length === 0 ? (welcome.value?.workers ?? 0) : workers.value.filter((each) => each.state !== "lost").length,
);
export const legend = signal<Legend | undefined>(undefined);
/** Tiles since the page was loaded, by what they took. */
export const tileTimes = signal<TileTimes | undefined>(undefined);
export const metrics = signal<{ at: number; values: Metrics }[]>([]);
/** By the name of each worker, what share of its time it worked, a second each; the newest last. */
export const workerUse = signal<ReadonlyMap<string, readonly { at: number; value: number }[]>>(new Map());
export const log = signal<(LogLine & { serial: number })[]>([]);
export const renders = signal<RenderReport[]>([]);
/** The farm elsewhere that traces full pictures. */
export const farm = signal<FarmReport | undefined>(undefined);

export interface Caret {
  line: number;
  column: number;
  endLine: number;
  endColumn: number;
  /** UTF-16 units that are selected. */
  length: number;
}
export const caret = signal<Caret>({ line: 1, column: 1, endLine: 1, endColumn: 1, length: 0 });

export type ThemeChoice = "dark" | "light" | "system";
export const themeChoice = signal<ThemeChoice>("system");
export const systemIsDark = signal(true);
export const theme = computed<"dark" | "light">(() =>
  themeChoice.value === "system" ? (systemIsDark.value ? "dark" : "light") : themeChoice.value,
);
export type ContrastChoice = "normal" | "high" | "system";
export const contrastChoice = signal<ContrastChoice>("system");
export const systemWantsContrast = signal(false);
export const contrast = computed<"normal" | "high">(() =>
  contrastChoice.value === "system" ? (systemWantsContrast.value ? "high" : "normal") : contrastChoice.value,
);
export const fontSize = signal(14);
/** Of texts, by its name; empty: the one that the page has. */
export const fontFamily = signal("");
/** Worker processes, and their nice level, from the program's next start on; nothing: as many as cores, and 10. */
export const keptWorkers = signal<number | undefined>(undefined);
export const keptNice = signal<number | undefined>(undefined);
/** The keys of commands that have others than their own. */
export const changedKeys = signal<Record<string, string[]>>({});

/** The last thing that went wrong or is done, in words, for a while. */
export interface Notice {
  text: string;
  kind: "info" | "error";
  serial: number;
}
export const notices = signal<Notice[]>([]);
let noticeSerial = 0;

export function notify(text: string, kind: Notice["kind"] = "info"): void {
  const notice = { text, kind, serial: ++noticeSerial };
  notices.value = [...notices.value.slice(-3), notice];
  setTimeout(() => dismiss(notice.serial), kind === "error" ? 12000 : 5000);
}

export function dismiss(serial: number): void {
  notices.value = notices.value.filter((each) => each.serial !== serial);
}

export type DialogName = "commands" | "settings" | "about" | "token" | "save_as" | "keys" | "goto" | "render" | "export";
export const dialog = signal<DialogName | undefined>(undefined);
