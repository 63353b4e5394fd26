// The open files, their cursors and cameras, which come back when the page is opened again.

import type { Workspace } from "./core/protocol.js";
import { keptWorkspace } from "./core/workspace.js";
import * as documents from "./documents.js";
import { Kept } from "./kept.js";
import * as state from "./state.js";
import { restoreViews, viewsOf } from "./view/scenes.js";

function current(): Workspace | undefined {
  void [documents.revision.value, state.caret.value];
  if (documents.isOpening()) return undefined;
  const all = documents.documents.value;
  const open = all.map((each) => each.file);
  const selections = all.map((each): [string, [number, number]] => {
    const { anchor, head } = documents.stateOf(each).selection.main;
    return [each.file, [anchor, head]];
  });
  return {
    open,
    active: state.activeFile.value,
    scene: state.sceneFile.value,
    selections: Object.fromEntries(selections),
    views: viewsOf(open),
  };
}

const kept = new Kept("workspace", current);

/** Opens what was open before; in front `file`, where the program was started with one. */
export function takeWorkspace(workspace: Workspace | undefined, file: string | undefined): void {
  const { open, active, scene, selections, views } = keptWorkspace(workspace);
  kept.begin();
  restoreViews(views);
  documents.restore({ files: open, active: file ?? active, scene: file ?? scene, selections });
}

export const watchWorkspace = (): void => kept.watch();
