// Which scene the view shows; from where each was seen, and what was picked in it, while another one is shown.

import { batch } from "@preact/signals";
import type { CameraWish, ChainLink, EntityId, Vector, Workspace } from "../core/protocol.js";
import * as state from "../state.js";
import { chainAt, metNothing } from "./picking.js";
import { pivot } from "./wish.js";

interface SeenScene {
  /** By pane. */
  cameras: CameraWish[];
  pivot: Vector | undefined;
  /** What is selected, in the text that it is an entity of. */
  selected: { file: string; entity: EntityId } | undefined;
  chain: ChainLink[];
  chainAt: number;
}

const seen = new Map<string, SeenScene>();

function current(): SeenScene {
  const entity = state.selectedEntity.peek();
  const file = state.outline.peek()?.file;
  return {
    cameras: state.panes.map((each) => each.camera.peek()),
    pivot: pivot.peek(),
    selected: entity === undefined || file === undefined ? undefined : { file, entity },
    chain: state.chain.peek(),
    chainAt: chainAt.peek(),
  };
}

type Views = Required<Workspace>["views"];

/** From where those of the files are seen whose view was moved. */
export function viewsOf(files: string[]): Views {
  const shown = state.sceneFile.value;
  const views: [string, Views[string]][] = [];
  for (const file of files) {
    const { cameras, pivot: point } =
      file === shown ? { cameras: state.panes.map((each) => each.camera.value), pivot: pivot.value } : (seen.get(file) ?? { cameras: [], pivot: undefined });
    if (cameras.some((each) => each !== null)) views.push([file, { cameras, ...(point ? { pivot: point } : {}) }]);
  }
  return Object.fromEntries(views);
}

/** Has scenes seen from there once they are shown. */
export function restoreViews(views: Views): void {
  for (const [file, view] of Object.entries(views)) {
    seen.set(file, { cameras: view.cameras, pivot: view.pivot, selected: undefined, chain: [], chainAt: 0 });
  }
}

/** Turns the view to the scene of that file, as it was seen before. */
export function showScene(file: string | undefined): void {
  const before = state.sceneFile.peek();
  if (file === before) return;
  if (before !== undefined) seen.set(before, current());
  const known = file === undefined ? undefined : seen.get(file);
  batch(() => {
    state.sceneFile.value = file;
    state.panes.forEach((pane, index) => (pane.camera.value = known?.cameras[index] ?? null));
    pivot.value = known?.pivot;
    // The editor turns to the scene's own text.
    state.selectedEntity.value = known?.selected?.file === file ? known?.selected?.entity : undefined;
    state.chain.value = known?.chain ?? [];
    chainAt.value = known?.chainAt ?? 0;
    metNothing.value = false;
  });
}

/** The scene was saved under another name, which changes nothing of how it is seen. */
export function seeAlike(file: string, as: string): void {
  const scene = state.sceneFile.peek() === file ? current() : seen.get(file);
  if (!scene) return;
  const { selected } = scene;
  seen.set(as, { ...scene, selected: selected?.file === file ? { ...selected, file: as } : selected });
}
