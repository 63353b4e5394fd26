import { signal } from "@preact/signals";
import { useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { placeIn } from "../core/log_places.js";
import { clock, dateAndTime } from "../core/view_words.js";
import * as documents from "../documents.js";
import * as state from "../state.js";

const filter = signal("");
const level = signal("all");
const RANK: Record<string, number> = { error: 3, critical: 3, warning: 2, warn: 2, info: 1, debug: 0, trace: 0 };

/** Goes to the place in a file of the folder that the line names. */
function Place({ text }: { text: string }) {
  const names = useMemo(() => new Set(state.files.value.map((each) => each.name)), [state.files.value]);
  const place = placeIn(text, state.welcome.value?.folder ?? "", names);
  if (!place) return null;
  return (
    <button type="button" class="link" onClick={() => documents.reveal(place.file, place.line, place.column)}>
      {`${place.file}:${place.line}`}
    </button>
  );
}

export function ConsolePanel() {
  const host = useRef<HTMLDivElement>(null);
  const following = useRef(true);
  const least = level.value === "all" ? 0 : RANK[level.value]!;
  const wanted = filter.value.toLowerCase();
  const lines = state.log.value.filter(
    (each) => (RANK[each.level] ?? 1) >= least && (wanted === "" || each.text.toLowerCase().includes(wanted)),
  );
  useLayoutEffect(() => {
    if (following.current && host.current) host.current.scrollTop = host.current.scrollHeight;
  }, [lines.length, lines[lines.length - 1]?.serial]);
  const copy = () => navigator.clipboard?.writeText(lines.map((each) => `${dateAndTime(each.at)} ${each.level} ${each.text}`).join("\n"));
  return (
    <>
      <div class="bar">
        <input type="search" placeholder="Filter" aria-label="Filter the log" value={filter.value} onInput={(event) => (filter.value = event.currentTarget.value)} />
        <select aria-label="Least level" value={level.value} onChange={(event) => (level.value = event.currentTarget.value)}>
          <option value="all">all</option>
          <option value="info">info</option>
          <option value="warning">warnings</option>
          <option value="error">errors</option>
        </select>
        <button type="button" onClick={copy}>Copy</button>
        <button type="button" onClick={() => (state.log.value = [])}>Clear</button>
      </div>
      <div
        class="log"
        role="log"
        aria-label="Log of the program"
        tabIndex={0}
        ref={host}
        onScroll={(event) => {
          const box = event.currentTarget;
          following.current = box.scrollTop + box.clientHeight >= box.scrollHeight - 4;
        }}
      >
        {lines.map((each) => (
          <div key={each.serial} class={`line level-${each.level}`}>
            <span class="aside" title={dateAndTime(each.at)}>{clock(each.at)}</span>
            <span class="words">{each.text}</span>
            <Place text={each.text} />
          </div>
        ))}
        {lines.length === 0 && <p class="empty">Nothing was logged.</p>}
      </div>
    </>
  );
}
