// The messages between the page and the program: WebSocket `GET /studio`, subprotocol
// `tessera-studio.1`. A text frame is one object with one member, whose name is the kind.
// Lines and columns count from 1, columns and offsets in UTF-16 code units; texts have `\n` alone.

export const SUBPROTOCOL = "tessera-studio.1";

export type Vector = [number, number, number];
/** Replace the text from `from` to `to` by the third. */
export type Change = [from: number, to: number, text: string];

export interface FreeCamera {
  eye: Vector;
  target: Vector;
  up: Vector;
  /** Degrees. */
  fov: number;
  axis?: "smaller" | "horizontal" | "vertical";
  /** The height of what an orthographic camera sees. */
  orthographic?: number;
  /** The scene's camera that was moved, whose lens it has; nothing: the first. */
  name?: string;
}
export type CameraWish = null | { name: string } | FreeCamera;

/** Options of `tessera render` that make bytes of light, by their long names. */
export interface Tone {
  exposure?: number;
  "tone-map"?: string;
  transfer?: string;
  gamma?: number;
  "ocio-view"?: string;
}

/** Options of `tessera render` by their long names, in place of what the scene says. */
export interface Overrides {
  spp?: number;
  integrator?: string;
  "max-depth"?: number;
  shadows?: string;
  "target-error"?: number;
  pattern?: string;
  filter?: string;
  pinhole?: boolean;
  denoise?: boolean;
}

export type RenderMode = "typing" | "save" | "hand";

export interface ViewWish {
  pane: number;
  file: string;
  /** Whether the file is one of the samples that ship with the program. */
  sample?: boolean;
  size: [number, number];
  camera: CameraWish;
  frame: number;
  /** Whether the camera is still being moved. */
  moving?: boolean;
  mode: RenderMode;
  overrides: Overrides;
  channel: string;
  tone: Tone | null;
  /** Whether films are to have all values beside light, for the probe. */
  aovs?: boolean;
  /** Whether to tell which worker traced which tile. */
  tiles?: boolean;
  /** What is left out of the scene, and what is left alone; the text stays as it is. */
  hidden?: EntityRef[];
  solo?: EntityRef[];
  /** The digest of the scene whose picture the page has: of that scene none is made, and `unchanged` is told. */
  known?: string;
}

/** An entity of a file. */
export type EntityRef = [file: string, entity: EntityId];

/** What a request about a text is of: the version that it was asked for. */
export interface OfText {
  file: string;
  base: number;
}

/** What the page sends. */
export interface ToProgram {
  hello: { token: string; resume?: string; have?: Record<string, [version: number, hash: string]> };
  list: Record<string, never>;
  open: { file: string };
  /** `discard`: with all that was not saved. */
  close: { file: string; discard?: boolean };
  reload: { file: string };
  take_over: { file: string };
  edit: { file: string; base: number; changes: Change[] };
  save: { file: string; as?: string; force?: boolean };
  recover: { file: string; take: boolean };
  view: ViewWish;
  pause: { pane: number };
  resume: { pane: number };
  stop: { pane: number };
  refresh: { pane: number };
  close_view: { pane: number };
  pick: { pane: number; x: number; y: number };
  probe: { pane: number; x: number; y: number };
  parts: { pane: number };
  /** Keeps what the pane shows, or the last whole picture of the scene as it was before, to compare it. */
  pin: { pane: number; what: "shown" | "before" | "none" };
  compare: { pane: number };
  centers: { file: string };
  set: OfText & { entity: EntityId; field: string; text: string };
  /** Takes the field out of the text, so that it has its default again. */
  reset: OfText & { entity: EntityId; field: string };
  /** What the template `kind` makes, in `entity` or the scene; `include` places the file `text`, and `panorama` has it as the background. */
  add: OfText & { kind: string; entity?: EntityId; text?: string; position?: Vector };
  remove: OfText & { entity: EntityId };
  duplicate: OfText & { entity: EntityId };
  /** The camera called `text`, or the first, gets this pose. */
  write_camera: OfText & { camera: FreeCamera; aspect: number; text?: string };
  /** Options of `tessera render` become settings of the scene. */
  write_settings: OfText & { options: Record<string, string | number | boolean> };
  /** The entity, or without one a new include, gets the placement. */
  place: OfText & { entity?: EntityId; placement: Placement };
  fields: OfText & { entity: EntityId };
  placement: OfText & { entity?: EntityId; number: number };
  complete: OfText & { offset: number; number: number };
  hover: OfText & { offset: number; number: number };
  /** What `write_camera` would leave of the camera's text. */
  camera_text: OfText & { camera: FreeCamera; aspect: number; text: string; number: number };
  create: { template?: string; model?: string; sample?: string };
  /** The numbers of what is answered are the page's: each has another one. */
  render: { number: number; file: string; spec: RenderSpec };
  order: { job: string | number; what: "pause" | "resume" | "cancel" | "forget" };
  export: ExportWish & { number: number };
  settings: Settings;
  workspace: Workspace;
  /** A file that follows in chunks of that number. */
  put: { name: string; size: number; number: number };
}

/** A full picture, or one of each of the frames from the first to the last. */
export interface RenderSpec {
  camera?: CameraWish;
  frame?: number;
  frames?: [first: number, last: number];
  /** Of files that hold all frames, such as GIF; else the scene's. */
  per_second?: number;
  /** Options of `tessera render` by their long names. */
  overrides?: Record<string, string | number | boolean>;
  tone?: Tone | null;
  /** Files below the folder; none: the picture is kept by the program. */
  outputs?: string[];
  statistics?: boolean;
  /** Also over files that are there. */
  force?: boolean;
}

/** A file of a full picture, of what a pane shows, or of the scene, as its name's ending says; or a command line. */
export interface ExportWish {
  file?: string;
  name?: string;
  job?: string | number;
  pane?: number;
  download?: boolean;
  /** Of a download: it is for the page to show, not to save. */
  show?: boolean;
  statistics?: boolean;
  force?: boolean;
  command?: RenderSpec;
}

export interface Settings {
  theme?: "dark" | "light" | "system";
  contrast?: "normal" | "high" | "system";
  font_size?: number;
  font_family?: string;
  /** Of the program's next start. */
  workers?: number;
  nice?: number;
  mode?: RenderMode;
  /** How the view is looked at. */
  channel?: string;
  exposure?: number;
  tone_map?: string;
  integrator?: string;
  filter?: string;
  layout?: unknown;
  keys?: unknown;
  [name: string]: unknown;
}

/** What is open in the folder, which outlasts the program. */
export interface Workspace {
  /** In the order of their tabs. */
  open?: string[];
  /** The one in the editor, and the one that the view shows. */
  active?: string;
  scene?: string;
  /** By file. */
  selections?: Record<string, [anchor: number, head: number]>;
  /** By the scene's file; cameras by pane. */
  views?: Record<string, { cameras: CameraWish[]; pivot?: Vector }>;
}

export interface FileEntry {
  name: string;
  kind: "folder" | "scene" | "model" | "picture";
  size: number;
}

/** A text that was never saved; `saved_at`: milliseconds since 1970. */
export interface Draft {
  text: string;
  saved_at: number;
}

export interface ProgramDocument {
  file: string;
  version: number;
  text: string;
  hash: string;
  eol: "lf" | "crlf" | "cr" | "mixed";
  bom: boolean;
  encoding: string;
  editable: boolean;
  read_only: boolean;
  language: string;
  /** Whether this text is another than the one on the disk. */
  dirty?: boolean;
  draft?: Draft;
  /** Why it is not editable. */
  why?: string;
}

export interface Problem {
  severity: "error" | "warning";
  file: string;
  /** Of the file's text; 0 where it was not open. */
  version: number;
  line: number;
  column: number;
  end_line: number;
  end_column: number;
  message: string;
  found?: string;
  expected?: string;
  suggestion?: string;
}

export interface SceneCamera {
  name: string;
  eye?: Vector;
  target?: Vector;
  up?: Vector;
  fov?: number;
  axis?: "smaller" | "horizontal" | "vertical";
  orthographic?: number;
  /** Whether it sees all around. */
  panoramic?: boolean;
}

export interface Summary {
  file: string;
  version: number;
  /** Of all texts that are open: those that the file includes count, too. */
  revision: number;
  digest: string;
  counts: [what: string, count: number][];
  cameras: SceneCamera[];
  size?: [number, number];
  samples?: number;
  integrator?: string;
  /** What the scene says of its animation. */
  animation?: { first: number; last: number; per_second?: number };
  /** Whether another frame can be another picture. */
  depends_on_frame?: boolean;
  bounds?: [Vector, Vector];
}

/** How a scene places a file: scaled, flipped, turned about z, y, x (in a CRT script x, y, z) and moved. Numbers are as they are typed. */
export interface Placement {
  file: string;
  /** In place of its own ones; empty: its own. */
  material: string;
  position: [string, string, string];
  rotation: [string, string, string];
  scale: [string, string, string];
  flip: [boolean, boolean, boolean];
}

export interface Field {
  name: string;
  kind: string;
  text: string;
  from: number;
  to: number;
  /** Whether the text has it; else `text` is the default. */
  present?: boolean;
  default?: string;
  unit?: string;
  help?: string;
  /** What a number may be, null where there is no end. */
  range?: [number | null, number | null];
  /** Whether an end of the range is left out itself. */
  open?: [boolean, boolean];
  choices?: string[];
  /** Why it cannot be set. */
  locked?: string;
  /** How many values come from the literal that is set, where it is several. */
  uses?: number;
}

/** Its path among the entities of its text. */
export type EntityId = string;

export interface Entity {
  id: EntityId;
  parent: EntityId | null;
  kind: string;
  name: string;
  /** What its language calls it: "sphere", "Material". */
  type?: string;
  /** The file that it names. */
  target?: string;
  line: number;
  column: number;
  end_line: number;
  end_column: number;
  from: number;
  to: number;
}

export interface Outline {
  file: string;
  version: number;
  entities: Entity[];
  /** There are more. */
  truncated?: boolean;
  /** What can be added. */
  templates?: { name: string; type: string }[];
}

export interface Completions {
  from: number;
  to: number;
  items: { label: string; insert: string; detail?: string; help?: string }[];
  /** Names of files of that kind fit too; `quoted`: between quotes. */
  files?: "model" | "picture";
  quoted?: boolean;
}

export type JobState = "tracing" | "done" | "failed" | "paused" | "stopped";

export interface JobReport {
  pane: number;
  /** Of the pass, as scale and samples are; a message that tells of a state alone has none of them, and gets those of the pass before. */
  serial: number;
  file: string;
  version: number;
  /** As in Summary; of what is shown. */
  revision?: number;
  scale: number;
  samples: number;
  /** Whether the pass is the last of its picture. */
  last?: boolean;
  /** Whether the pass has ended. */
  ended?: boolean;
  rays?: number;
  /** Of the scene, where the pass has ended. */
  digest?: string;
  /** That frame is of the scene that the page knows the picture of. */
  unchanged?: boolean;
  frame?: number;
  width: number;
  height: number;
  state: JobState;
  why?: string;
  /** The text is wrong, and what is shown is that of an earlier one; when that was read: milliseconds since 1970. */
  stale?: { as_of: number | null; why: string };
  times?: { parse?: number; build?: number; trace?: number; total?: number };
}

export interface Progress {
  pane: number;
  serial: number;
  tiles_done: number;
  tiles_total: number;
  elapsed?: number;
  left?: number;
  waiting_for?: string;
}

export interface WorkerReport {
  id?: number;
  name: string;
  state?: string;
  threads?: number;
  tiles?: number;
  /** Of tiles, from their assignment to their end. */
  tile_seconds?: number;
  tiles_held?: number;
  memory?: number;
  /** The share of its threads' time in which it computed. */
  use?: number;
  [name: string]: unknown;
}

export interface Metrics {
  [name: string]: number;
}

export type WorkerTile = [x: number, y: number, width: number, height: number, worker: number];

/** How many tiles took how long, by the most that they took; the last is longer than all. */
export interface TileTimes {
  bounds: number[];
  counts: number[];
}

/** What the colours of a channel stand for. */
export interface Legend {
  pane: number;
  channel: string;
  scale: boolean;
  /** Whether the picture tells the channel, as errors are told from two samples a pixel on; else the numbers say nothing. */
  known: boolean;
  low: number;
  high: number;
  mean: number;
  steps: number[];
}

export interface LogLine {
  /** Milliseconds since 1970. */
  at: number;
  level: string;
  text: string;
}

export interface RenderReport {
  job: string | number;
  file?: string;
  state?: string;
  tiles_done?: number;
  tiles_total?: number;
  left?: number;
  elapsed?: number;
  /** Files below the folder: the newest, and how many there are of all. */
  written?: string[];
  written_count?: number;
  /** Whether the program still has the picture, for exports. */
  has_picture?: boolean;
  frames?: [first: number, last: number];
  frames_done?: number;
  size?: [number, number];
  samples?: number;
  why?: string;
  waiting_for?: string;
  /** The command line that makes this picture. */
  command?: string;
}

/** A farm elsewhere, which traces the full pictures. */
export interface FarmReport {
  endpoint: string;
  /** Why it does not answer. */
  trouble?: string;
  workers?: number;
  jobs?: FarmJob[];
}

export interface FarmJob {
  job: number;
  name: string;
  state: string;
  waits_for?: string | null;
  priority: number;
  frames: { done: number; total: number };
  tiles: { done: number; total: number };
  elapsed_seconds: number;
  remaining_seconds?: number | null;
  failure?: string;
}

/** Three rows of four numbers: what leads from the axes of something to those of the world. */
export type Axes = readonly number[];

export interface ChainLink {
  kind: string;
  name?: string;
  file?: string;
  entity?: EntityId;
  /** Of the text that the place is in, where that is open. */
  version?: number;
  line?: number;
  column?: number;
  end_line?: number;
  end_column?: number;
}

/** By how much the picture of a pass differs from the pinned one, as `tessera compare --metrics` tells it. */
export interface Comparison {
  pane: number;
  serial?: number;
  /** Why they cannot be compared. */
  why?: string;
  /** Whether the picture of their difference was sent, too. */
  drawn?: boolean;
  max_difference?: number | null;
  mean_difference?: number | null;
  rmse?: number | null;
  differing_pixels?: number;
  worst_pixel?: [number, number];
  rel_mse?: number | null;
  smape?: number | null;
  flip?: number | null;
  ssim?: number | null;
  within?: number | null;
  mean_ratio?: number | null;
}

/** What the program sends. */
export interface ToPage {
  welcome: {
    id: string;
    program: string;
    folder: string;
    file?: string;
    read_only: boolean;
    /** The largest numbers that may be asked for, those of options by their long names. */
    limits: Record<string, number>;
    /** The names that options take, by their long names, and those of channels. */
    choices: Record<string, string[]>;
    /** The nice level of workers where the settings have none. */
    workers_nice: number;
    settings: Settings;
    workspace: Workspace;
    workers: number;
    /** Has another process trace for this studio; empty: none can. */
    worker_command?: string;
    /** Files of the samples that ship with the program. */
    samples?: string[];
    templates?: { id: string; title: string }[];
    /** Folders that were opened before, the newest first, and what opens them. */
    recent?: { folder: string; command: string }[];
  };
  files: { entries: FileEntry[]; truncated: boolean };
  document: ProgramDocument;
  /** The next that is offered, once it was decided about the one before. */
  draft: Draft & { file: string };
  edited: { file: string; version: number };
  saved: { file: string; version: number; hash: string; as?: string };
  disk: { file: string; state: "same" | "changed" | "deleted"; text?: string; hash?: string };
  change: { file: string; base: number; changes: Change[]; why: string; changed?: number };
  problems: { file: string; version: number; list: Problem[] };
  summary: Summary;
  outline: Outline;
  fields: { file: string; version: number; entity: EntityId; fields: Field[] };
  /** `materials`: what the model can be made of in place of its own ones; absent where the language has no such choice. */
  placement: { file: string; number: number; placement: Placement; materials?: string[]; locked?: string };
  completions: Completions & { file: string; version: number; number: number };
  camera_text: { file: string; number: number; text: string };
  hovered: { file: string; number: number; from?: number; to?: number; title?: string; detail?: string; help?: string };
  created: { file: string };
  put: { number: number; name: string; received: number; whole: boolean };
  job: JobReport;
  progress: Progress;
  /** The innermost of the chain first; `at`: the one that a click selects. */
  picked: { pane: number; x: number; y: number; version: number; chain: ChainLink[]; at: number; point?: Vector; depth?: number };
  /** Before the frame of the part picture of that serial: part n of it has the chain n - 1. */
  parts: { pane: number; serial: number; version: number; links: ChainLink[]; chains: { links: number[]; at: number }[] };
  probed: { pane: number; x: number; y: number; channels?: string[]; values?: number[]; shown?: number[] };
  /** Without a size nothing is pinned. */
  pinned: { pane: number; size?: [number, number] };
  compared: Comparison;
  /** The entities that made something, with the centre of that where it ends; `times`: how many things are made by its text itself, 0 where that is not known; `axes`: where they are not the world's, the rows of the matrix that leads there. */
  centers: { file: string; version: number; list: [file: string, entity: EntityId, center: Vector | null, size: Vector | null, times: number, axes?: Axes][] };
  workers: { list: WorkerReport[] };
  metrics: Metrics & { tile_times?: TileTimes };
  legend: Legend;
  /** Of the pass, as its tiles end: where they lie in its picture, and who traced them. */
  tiles: { pane: number; serial: number; scale: number; list: WorkerTile[] };
  log: { lines: LogLine[] };
  renders: { list: RenderReport[] };
  farm: FarmReport;
  /** What became of an order of full pictures. */
  ordered: { number: number; job: RenderReport["job"] };
  exported: { number: number; name?: string; download?: number; show?: boolean; size?: number; command?: string };
  /** `existing`: the files that are replaced where that is ordered with force. */
  refused: { request: string; file?: string; why: string; found?: string; expected?: string; entity?: EntityId; field?: string; number?: number; upload?: number; existing?: { first: string; count: number } };
}

export type PageKind = keyof ToPage;
export type ProgramKind = keyof ToProgram;

/** The text frame of one message to the program. */
export function encode<K extends ProgramKind>(kind: K, body: ToProgram[K]): string {
  return JSON.stringify({ [kind]: body });
}

/** The kind and body of a text frame; nothing for what is no message. */
export function decode(text: string): { kind: string; body: unknown } | undefined {
  let message: unknown;
  try {
    message = JSON.parse(text);
  } catch {
    return undefined;
  }
  if (typeof message !== "object" || message === null || Array.isArray(message)) return undefined;
  const members = Object.entries(message);
  if (members.length !== 1) return undefined;
  const [kind, body] = members[0]!;
  if (typeof body !== "object" || body === null) return undefined;
  return { kind, body };
}
