import { baseName } from "../core/paths.js";
import * as documents from "../documents.js";
import { closeFile } from "../commands.js";
import { compared } from "../layout/compare_dialog.js";
import { canBePlaced } from "../models.js";
import * as program from "../program.js";
import { Adopt } from "./adopt.js";
import { StartPage } from "./start.js";
import * as state from "../state.js";

let editor: HTMLElement | undefined;

export function setEditor(element: HTMLElement): void {
  editor = element;
}

/** Arrows go to the next file, Delete closes it. */
function tabKey(event: KeyboardEvent, file: string): void {
  const all = documents.documents.peek();
  const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
  if (event.key === "Delete") closeFile(file);
  else if (step !== 0) {
    const at = all.findIndex((each) => each.file === file);
    documents.activate(all[(at + step + all.length) % all.length]!.file);
    const list = (event.currentTarget as HTMLElement).closest('[role="tablist"]')!;
    requestAnimationFrame(() => list.querySelector<HTMLElement>('[aria-selected="true"]')?.focus());
  } else return;
  event.preventDefault();
}

function FileTabs() {
  void documents.revision.value;
  const all = documents.documents.value;
  return (
    <div class="file-tabs" role="tablist" aria-label="Open files">
      {all.map((each) => {
        const isActive = each.file === state.activeFile.value;
        return (
          <span key={each.file} class={`file-tab ${isActive ? "active" : ""}`} role="presentation">
            <button
              type="button"
              role="tab"
              class={`tab ${each.disk === "deleted" ? "gone" : ""}`}
              aria-selected={isActive}
              tabIndex={isActive ? 0 : -1}
              title={each.disk === "deleted" ? `${each.file} is no longer on the disk` : each.file}
              onClick={() => documents.activate(each.file)}
              onKeyDown={(event) => tabKey(event, each.file)}
              onAuxClick={(event) => event.button === 1 && closeFile(each.file)}
            >
              {baseName(each.file)}
              {each.disk === "deleted" && <span class="sign" role="img" aria-label="no longer on the disk">!</span>}
              {each.dirty && <span class="dot" role="img" aria-label="unsaved" />}
            </button>
            <span class="close" aria-hidden="true" title="Close (Alt-W)" onClick={() => closeFile(each.file)}>×</span>
          </span>
        );
      })}
    </div>
  );
}

/** What is to be said of the file above its text. */
function Banner() {
  void documents.revision.value;
  const shown = documents.find(state.activeFile.value);
  if (!shown) return null;
  if (shown.disk === "changed") {
    return (
      <div class="banner warning" role="alert">
        <span>{shown.file} was changed on the disk, and has changes here that are not saved.</span>
        {shown.diskText !== undefined && <button type="button" onClick={() => (compared.value = shown.file)}>Compare</button>}
        <button type="button" onClick={() => documents.keepMine(shown.file)}>Keep mine</button>
        <button type="button" onClick={() => documents.loadTheirs(shown.file)}>Load theirs</button>
      </div>
    );
  }
  if (shown.disk === "deleted") {
    return (
      <div class="banner warning" role="alert">
        <span>{shown.file} is no longer on the disk. The text is kept here; saving writes it anew.</span>
      </div>
    );
  }
  if (shown.readOnly) {
    return (
      <div class="banner" role="status">
        <span>{state.welcome.value?.read_only ? "Opened for reading alone." : "Open for editing in another tab; this one follows."}</span>
        {!state.welcome.value?.read_only && (
          <button type="button" onClick={() => program.send("take_over", { file: shown.file })}>Edit here</button>
        )}
      </div>
    );
  }
  if (!shown.editable) {
    return (
      <div class="banner" role="status">
        <span>{shown.why ?? "This file is shown, and cannot be edited."}</span>
        {state.files.value.some((each) => each.name === shown.file && canBePlaced(each)) && (
          <button type="button" title="Its place, size and material are edited there" onClick={() => program.send("create", { model: shown.file })}>Place it in a new scene</button>
        )}
      </div>
    );
  }
  return null;
}

export function ScriptPanel() {
  const isEmpty = documents.documents.value.length === 0;
  return (
    <>
      {!isEmpty && <FileTabs />}
      <Banner />
      {isEmpty && <StartPage />}
      <div class={isEmpty ? "hidden" : "editor-host"}>{editor && <Adopt element={editor} />}</div>
    </>
  );
}
