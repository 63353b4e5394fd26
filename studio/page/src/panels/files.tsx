import { signal } from "@preact/signals";
import { baseName, isModelFile, isText } from "../core/paths.js";
import type { FileEntry } from "../core/protocol.js";
import * as documents from "../documents.js";
import * as program from "../program.js";
import * as state from "../state.js";
import { showScene } from "../view/scenes.js";
import { listKey } from "./list_keys.js";

const closed = signal<Set<string>>(new Set());
const MARKS: Record<string, string> = { folder: "▸", scene: "◆", model: "△", picture: "▣" };

function isHidden(name: string): boolean {
  for (let slash = name.indexOf("/"); slash >= 0; slash = name.indexOf("/", slash + 1)) {
    if (closed.value.has(name.slice(0, slash))) return true;
  }
  return false;
}

function toggle(name: string): void {
  const next = new Set(closed.value);
  if (!next.delete(name)) next.add(name);
  closed.value = next;
}

export function sizeWords(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toFixed(bytes < 1e4 ? 1 : 0)} kB`;
  return `${(bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0)} MB`;
}

/** Opens or closes a folder, opens a text, shows a scene, and says of a picture how scenes use it. */
export function use({ name, kind, size }: FileEntry): void {
  if (kind === "folder") toggle(name);
  // A model by itself, or one without a text, is placed by a scene.
  else if (isModelFile(name) && (state.sceneFile.peek() === undefined || !isText(name))) program.send("create", { model: name });
  else if (kind === "picture") state.notify(`${name} is a picture of ${sizeWords(size)}. Scenes use it by its name, as the file of a texture or of a panorama.`);
  else if (isText(name)) documents.open(name);
  else if (kind === "scene" || kind === "model") showScene(name);
}

export function FilesPanel() {
  const shown = state.files.value.filter((each) => !isHidden(each.name));
  if (shown.length === 0) {
    return <p class="empty">{state.connection.value === "open" ? "The folder has no scenes." : "Connecting…"}</p>;
  }
  return (
    <div class="list" role="listbox" aria-label="Files of the folder" onKeyDown={listKey}>
      {shown.map((entry, index) => {
        const depth = entry.name.split("/").length - 1;
        const isActive = entry.name === state.activeFile.value;
        const open = entry.kind !== "folder" ? "" : closed.value.has(entry.name) ? " (closed)" : " (open)";
        return (
          <div
            key={entry.name}
            role="option"
            class={`row kind-${entry.kind}`}
            aria-selected={isActive}
            title={entry.name}
            tabIndex={isActive || (index === 0 && state.activeFile.value === undefined) ? 0 : -1}
            style={{ paddingInlineStart: `${10 + depth * 14}px` }}
            onClick={() => use(entry)}
            onKeyDown={(event) => {
              if (event.key === "Enter" || event.key === " ") {
                use(entry);
                event.preventDefault();
              }
            }}
          >
            <span class={`mark ${entry.kind === "folder" && !closed.value.has(entry.name) ? "open" : ""}`} aria-hidden="true">
              {MARKS[entry.kind] ?? "·"}
            </span>
            <span class="name">{baseName(entry.name)}</span>
            <span class="visually-hidden">{`${entry.kind}${open}`}</span>
            {entry.kind !== "folder" && <span class="aside">{sizeWords(entry.size)}</span>}
          </div>
        );
      })}
      {state.filesTruncated.value && <p class="empty">More files than are listed.</p>}
    </div>
  );
}
