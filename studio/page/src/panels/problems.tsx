import * as documents from "../documents.js";
import { fix, wordsOf } from "../editor/problem_marks.js";
import type { Problem } from "../core/protocol.js";
import { placeWords } from "../core/view_words.js";
import * as state from "../state.js";
import { listKey } from "./list_keys.js";

function go(problem: Problem): void {
  documents.reveal(problem.file, problem.line, problem.column, problem.end_line, problem.end_column);
}

function Row({ problem, first }: { problem: Problem; first: boolean }) {
  return (
    <div
      role="option"
      aria-selected="false"
      class={`row problem ${problem.severity}`}
      tabIndex={first ? 0 : -1}
      onClick={() => go(problem)}
      onKeyDown={(event) => {
        if (event.key === "Enter") go(problem);
        if (event.key === "." && event.ctrlKey) fix(problem);
      }}
    >
      <span class={`severity ${problem.severity}`}>{problem.severity === "error" ? "● error" : "▲ warning"}</span>
      <span class="words">{wordsOf(problem)}</span>
      {problem.suggestion && (
        <span
          class="fix"
          title="Replace (Ctrl-.)"
          onClick={(event) => {
            event.stopPropagation();
            fix(problem);
          }}
        >
          use “{problem.suggestion}”
        </span>
      )}
      <span class="aside">{`${problem.file}:${problem.line}:${problem.column}`}</span>
    </div>
  );
}

function SceneSummary() {
  const summary = state.summary.value;
  if (!summary) return null;
  return (
    <div class="summary">
      <span class="summary-file">{summary.file}</span>
      {summary.size && <span>{summary.size.join(" × ")}</span>}
      {(summary.counts ?? []).map(([what, count]) => (
        <span key={what}>{`${what}: ${count}`}</span>
      ))}
      {summary.bounds && <span>{`bounds: ${summary.bounds.map(placeWords).join(" to ")}`}</span>}
      {summary.digest && <span class="aside" title={summary.digest}>{summary.digest.slice(0, 12)}</span>}
    </div>
  );
}

export function ProblemsPanel() {
  const list = state.problems.value;
  return (
    <>
      {list.length === 0 ? (
        <p class="empty list">No problems.</p>
      ) : (
        <div class="list" role="listbox" aria-label="Problems of the scene" onKeyDown={listKey}>
          {list.map((problem, index) => (
            <Row key={index} problem={problem} first={index === 0} />
          ))}
        </div>
      )}
      <SceneSummary />
    </>
  );
}
