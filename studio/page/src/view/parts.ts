// The part picture of each pane: which part of the scene each pixel shows, for hovering without asking the program.

import { computed, effect, signal } from "@preact/signals";
import { eachRimPixel } from "../core/part_outline.js";
import type { EntityId } from "../core/entities.js";
import type { ChainLink, JobReport, ToPage } from "../core/protocol.js";
import { rangeNow } from "../core/text_place.js";
import * as documents from "../documents.js";
import * as program from "../program.js";
import * as state from "../state.js";
import type { FromWorker } from "../worker/messages.js";

export type Parts = Extract<FromWorker, { kind: "parts" }>;

const STILL_MS = 200;

/** Whether a link of the outline's file is of that entity, which may be called otherwise since the picture was made. */
function isOf(link: ChainLink, entity: EntityId): boolean {
  const outline = state.outline.peek();
  const sync = documents.find(link.file)?.sync;
  const isOld = link.version !== undefined && link.version !== outline?.version;
  if (!isOld || !sync || outline?.version !== sync.version || link.line === undefined) return link.entity === entity;
  const found = outline.entities.find((each) => each.id === entity);
  const range = rangeNow(sync, { ...link, line: link.line });
  return range !== undefined && range[0] === found?.from && range[1] === found.to;
}

class PaneParts {
  readonly image = signal<Parts | undefined>(undefined);
  readonly table = signal<ToPage["parts"] | undefined>(undefined);
  private due: ReturnType<typeof setTimeout> | undefined;
  private asked = false;
  private last: JobReport | undefined;

  constructor(readonly pane: state.Pane) {}

  /** The part picture with its table, while it shows what the pane shows. */
  readonly picture = computed(() => {
    const [parts, chains] = [this.image.value, this.table.value];
    return parts && chains && parts.serial === chains.serial ? { image: parts, table: chains } : undefined;
  });
  readonly hovered = computed(() => {
    const [at, picture] = [this.pane.pointer.value, this.picture.value];
    return (at && picture?.image.parts[at[1] * picture.image.width + at[0]]) || 0;
  });
  /** The parts that the entity under the cursor made. */
  readonly selected = computed<ReadonlySet<number>>(() => {
    const [picture, entity, file] = [this.picture.value, state.selectedEntity.value, state.outline.value?.file];
    const numbers = new Set<number>();
    if (!picture || entity === undefined) return numbers;
    const { links, chains } = picture.table;
    const isChosen = links.map((each) => each.file === file && isOf(each, entity));
    chains.forEach((chain, index) => {
      if (chain.links.some((each) => isChosen[each])) numbers.add(index + 1);
    });
    return numbers;
  });

  private drop(): void {
    clearTimeout(this.due);
    this.due = undefined;
    this.asked = false;
    this.image.value = undefined;
    this.table.value = undefined;
  }

  /** Whether the pass refines the picture of the one before. */
  private refines(job: JobReport): boolean {
    const { last } = this;
    if (!last) return false;
    if (job.serial === last.serial) return true;
    return last.scale === job.scale ? job.samples > last.samples : job.scale < last.scale && job.samples >= last.samples;
  }

  /** Asks for the part picture once the pane is still. */
  watch(): void {
    effect(() => {
      void [state.sceneFile.value, this.pane.size.value, this.pane.camera.value, state.frame.value, state.overrides.value, state.hidden.value, state.solo.value];
      this.drop();
    });
    effect(() => {
      const job = this.pane.job.value;
      if (!job || (job.state !== "tracing" && job.state !== "done")) return;
      if (!this.refines(job)) this.drop();
      this.last = job;
      if (job.scale !== 1 || this.asked || this.due !== undefined) return;
      this.due = setTimeout(() => {
        this.due = undefined;
        this.asked = program.send("parts", { pane: this.pane.number });
      }, STILL_MS);
    });
  }
}

const all = state.panes.map((pane) => new PaneParts(pane));
const of = (number: number) => all.find((each) => each.pane.number === number);

/** What the part under the pointer is, and stands in. */
export function hoveredChain(pane: state.Pane): ChainLink[] {
  const parts = of(pane.number);
  const table = parts?.picture.value?.table;
  const chain = table?.chains[parts!.hovered.value - 1];
  return chain ? chain.links.map((each) => table!.links[each]!) : [];
}

export function parts(message: Parts): void {
  const found = of(message.pane);
  if (found) found.image.value = message;
}
export function partsCame(message: ToPage["parts"]): void {
  const found = of(message.pane);
  if (found) found.table.value = message;
}

export function watchParts(): void {
  for (const each of all) each.watch();
}

/** Draws the rims of what the cursor stands in and of what is under the pointer. */
export function drawOutlines(pane: state.Pane, canvas: HTMLCanvasElement): void {
  const { picture, selected, hovered } = of(pane.number)!;
  effect(() => {
    const [width, height] = pane.size.value;
    const shown = picture.value;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, width, height);
    canvas.dataset.selected = String(selected.value.size);
    canvas.dataset.hovered = String(hovered.value);
    if (!shown) return;
    const style = getComputedStyle(canvas);
    const rim = (numbers: ReadonlySet<number>, colour: string) => {
      if (numbers.size === 0) return;
      for (const [fill, size] of [["rgb(0 0 0 / 60%)", 2], [colour, 1]] as const) {
        context.fillStyle = fill;
        eachRimPixel(shown.image, numbers, (x, y) => context.fillRect(x - size + 1, y - size + 1, 2 * size - 1, 2 * size - 1));
      }
    };
    rim(selected.value, style.getPropertyValue("--warning") || "orange");
    rim(new Set(hovered.value ? [hovered.value] : []), style.getPropertyValue("--accent") || "cyan");
  });
}
