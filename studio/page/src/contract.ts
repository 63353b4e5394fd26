// `globalThis.tesseraStudio`: what tests and tools may read of the page, in every build. Nothing can be set by it.

import * as documents from "./documents.js";
import { layout, preset } from "./layout/layout_state.js";
import * as program from "./program.js";
import * as state from "./state.js";
import { currentCamera, pivot } from "./view/wish.js";

/** Whether the last pass of a picture in the pane's size is shown. */
function isFinal({ painted, size }: state.Pane): boolean {
  const { complete, width, height } = painted.peek() ?? {};
  return complete === true && width === size.peek()[0] && height === size.peek()[1];
}

function report() {
  const shown = documents.active();
  const { line, column, endLine, endColumn } = state.caret.peek();
  const wish = state.camera.peek();
  const camera = currentCamera();
  const [width, height] = state.viewSize.peek();
  const { value: summary } = state.summary;
  const overrides = state.overrides.peek();
  const painted = state.painted.peek();
  const job = state.job.peek();
  const progress = state.progress.peek();
  return {
    connection: state.connection.peek(),
    file: shown?.file ?? null,
    language: shown?.language ?? null,
    version: shown?.sync.version ?? 0,
    dirty: shown?.dirty ?? false,
    readOnly: shown ? shown.readOnly || !shown.editable : false,
    problems: state.problems.peek().map((each) => ({
      severity: each.severity,
      file: each.file,
      line: each.line,
      column: each.column,
      endLine: each.end_line,
      endColumn: each.end_column,
      message: each.message,
      suggestion: each.suggestion ?? null,
    })),
    selection: { entity: state.selectedEntity.peek() ?? null, line, column, endLine, endColumn },
    camera: {
      mode: wish && "eye" in wish ? "free" : "scene",
      eye: camera?.eye ?? null,
      target: camera?.target ?? null,
      up: camera?.up ?? null,
      fov: camera?.fov ?? null,
    },
    view: {
      width,
      height,
      kind: state.channel.peek(),
      integrator: overrides.integrator ?? summary?.integrator ?? null,
      samples: overrides.spp ?? summary?.samples ?? null,
      exposure: state.tone.peek()?.exposure ?? 0,
      toneMap: state.tone.peek()?.["tone-map"] ?? null,
      zoom: state.main.zoom.peek().scale === "fit" ? state.main.fit.peek() : state.main.zoom.peek().scale,
      pivot: pivot.peek() ?? null,
    },
    picture: {
      serial: painted?.serial ?? 0,
      // Of the texts that make the picture, the last.
      version: (job?.serial === painted?.serial ? job?.version : undefined) ?? painted?.version ?? 0,
      scale: painted?.scale ?? 0,
      samples: painted?.samples ?? 0,
      tilesDone: progress?.tiles_done ?? 0,
      tilesTotal: progress?.tiles_total ?? 0,
      final: isFinal(state.main),
      stale: job?.stale !== undefined,
    },
    panes: state.panes.slice(0, state.paneCount.peek()).map((pane) => ({
      side: pane.side.peek() ?? null,
      size: pane.size.peek(),
      camera: currentCamera(pane) ?? null,
      final: isFinal(pane),
      version: pane.painted.peek()?.version ?? 0,
      serial: pane.painted.peek()?.serial ?? 0,
    })),
    workers: state.workerCount.peek(),
    frame: state.frame.peek(),
    theme: state.theme.peek(),
    contrast: state.contrast.peek(),
    layout: { preset: preset.peek(), ...layout.peek() },
  };
}

export function publishContract(): void {
  const contract = Object.freeze({
    state: () => structuredClone(report()),
    text: () => {
      const shown = documents.active();
      return shown ? documents.stateOf(shown).doc.toString() : "";
    },
    pixels: (pane = 0) => program.pixels(pane),
  });
  Object.defineProperty(globalThis, "tesseraStudio", { value: contract, writable: false, configurable: false });
}
