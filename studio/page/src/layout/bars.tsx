import { redoDepth, undoDepth } from "@codemirror/commands";
import { languageName } from "../languages/language_of.js";
import { count, progressWords, short } from "../core/view_words.js";
import * as documents from "../documents.js";
import { currentWords } from "../panels/view.js";
import { keysOf, runCommand, type CommandName } from "../commands.js";
import * as program from "../program.js";
import { active } from "../renders.js";
import * as state from "../state.js";
import { showPanel } from "./layout_state.js";

function Tool({ command, label, title, primary, disabled }: { command: CommandName; label: string; title: string; primary?: boolean; disabled?: boolean }) {
  return (
    <button type="button" class={primary ? "primary" : ""} title={`${title}${keysOf(command)}`} disabled={disabled} onClick={() => runCommand(command)}>
      {label}
    </button>
  );
}

export function Toolbar() {
  void documents.revision.value;
  const shown = documents.find(state.activeFile.value);
  const text = shown && documents.stateOf(shown);
  const noScene = state.sceneFile.value === undefined;
  return (
    <header class="toolbar">
      <h1 class="brand"><img src="icon.svg" alt="" width={18} height={18} />Tessera</h1>
      <Tool command="New: empty scene" label="New" title="New scene" />
      <Tool command="Open: list of files" label="Open" title="Files of the folder" />
      <Tool command="Save" label="Save" title="Save" disabled={!shown?.dirty} />
      <span class="gap" />
      <Tool command="Undo" label="Undo" title="Undo" disabled={!text || undoDepth(text) === 0} />
      <Tool command="Redo" label="Redo" title="Redo" disabled={!text || redoDepth(text) === 0} />
      <span class="gap" />
      {active.value ? (
        <Tool command="Render: stop the full picture" label="Stop" title={`Stop full picture ${active.value.job}`} primary />
      ) : (
        <Tool command="Render: full picture" label="Render" title="Full picture" primary disabled={noScene} />
      )}
      <Tool command="Render: this view now" label="Preview" title="This view now" disabled={noScene} />
      <Tool command="Export picture or scene…" label="Export" title="Export picture or scene" disabled={noScene} />
      <span class="spacer" />
      <span class="where">{state.activeFile.value ?? ""}</span>
      <span class="spacer" />
      <Tool command="Full screen" label="Full screen" title="Full screen, or back" />
      <Tool command="Commands" label="Commands" title="Every command" />
      <Tool command="Settings" label="Settings" title="Settings" />
      <Tool command="About" label="About" title="About" />
    </header>
  );
}

const CONNECTION: Record<state.Connection, string> = {
  connecting: "connecting",
  open: "connected",
  lost: "no connection",
  refused: "token refused",
};

function JobWords() {
  const view = { job: state.job.value, progress: state.progress.value };
  const rays = state.metrics.value[state.metrics.value.length - 1]?.values.rays_per_second;
  return <span class="job-words">{[currentWords().words, ...progressWords(view, rays)].join(", ")}</span>;
}

export function StatusBar() {
  void documents.revision.value;
  const shown = documents.find(state.activeFile.value);
  const errors = state.problems.value.filter((each) => each.severity === "error").length;
  const warnings = state.problems.value.length - errors;
  const { line, column, length } = state.caret.value;
  const latest = state.metrics.value[state.metrics.value.length - 1]?.values;
  return (
    <footer class="status-bar" aria-label="Status">
      <button type="button" class={errors > 0 ? "error" : ""} onClick={() => showPanel("Problems", true)}>
        {count(errors, "error")}, {count(warnings, "warning")}
      </button>
      <JobWords />
      <span class="spacer" />
      {shown && (
        <>
          <span>Line {line}, column {column}{length > 0 ? ` (${length} selected)` : ""}</span>
          <span>{languageName(shown.file)}</span>
          <span>{shown.encoding}{shown.bom ? " with mark" : ""}</span>
          <span>{shown.eol.toUpperCase()}</span>
        </>
      )}
      <span>{count(state.workerCount.value, "worker")}</span>
      {latest?.memory !== undefined && <span>{short(latest.memory)}B</span>}
      {state.connection.value === "lost" ? (
        <button type="button" class="error" onClick={program.retryNow}>{CONNECTION.lost}: try now</button>
      ) : (
        <span class={`connection-${state.connection.value}`}>{CONNECTION[state.connection.value]}</span>
      )}
    </footer>
  );
}

export function Notices() {
  return (
    <div class="notices" aria-live="polite">
      {state.notices.value.map((each) => (
        <div key={each.serial} class={`notice ${each.kind}`}>
          <span>{each.text}</span>
          <button type="button" class="close" aria-label="Dismiss" onClick={() => state.dismiss(each.serial)}>×</button>
        </div>
      ))}
    </div>
  );
}
