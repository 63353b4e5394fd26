import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { viewWords, type ViewWords } from "../core/view_words.js";
import { scaleWords } from "../core/zoom.js";
import { isReading } from "../reading.js";
import * as state from "../state.js";
import { filterWords, showAll } from "../view/filter.js";
import { zoomOut, zoomToPixels } from "../view/magnifier.js";
import { moveCamera, pauseOrResume, refresh, sceneCameras, stop, titleOfCamera } from "../view/wish.js";
import { Chain } from "./chain.js";
import { PinButton } from "./compare.js";
import { PaneCount, Panes } from "./panes.js";
import { OwnSettings, ViewOptions } from "./view_options.js";

const SPOKEN_EVERY_MS = 2000;

/** What is spoken: seldom enough to be heard. */
const spoken = signal("");
let spokenAt = 0;
let spokenDue: ReturnType<typeof setTimeout> | undefined;

export function currentWords(): ViewWords {
  return viewWords({
    connection: state.connection.value,
    file: state.sceneFile.value,
    shown: state.main.shownFile.value,
    job: state.job.value,
    progress: state.progress.value,
    paused: state.paused.value,
    reading: isReading.value,
    workers: state.workerCount.value,
  });
}

function speak(words: string): void {
  clearTimeout(spokenDue);
  const wait = Math.max(0, spokenAt + SPOKEN_EVERY_MS - performance.now());
  spokenDue = setTimeout(() => {
    spokenAt = performance.now();
    spoken.value = words;
  }, wait);
}

function Cameras() {
  const wish = state.camera.value;
  const cameras = sceneCameras();
  const isFree = wish !== null && "eye" in wish;
  const name = wish?.name ?? cameras[0]?.name;
  return (
    <>
      <span class={`chip ${isFree ? "free" : ""}`}>{isFree ? "free" : name ? `scene’s: ${titleOfCamera(name)}` : "scene’s"}</span>
      {cameras.length > 1 && (
        <select
          aria-label="Camera"
          value={isFree ? "" : (wish?.name ?? "")}
          onChange={(event) => moveCamera(event.currentTarget.value === "" ? null : { name: event.currentTarget.value }, false)}
        >
          <option value="">first camera</option>
          {cameras.map(({ name: each }) => <option key={each} value={each}>{titleOfCamera(each)}</option>)}
        </select>
      )}
      {isFree && <button type="button" onClick={() => moveCamera(null, false)}>Home</button>}
    </>
  );
}

/** What the picture lacks of the scene. */
function Filtered() {
  const { value: words } = filterWords;
  if (words === "") return null;
  return <button type="button" class="chip free" title="Show all of the scene" onClick={showAll}>{words}: show all</button>;
}

function Zoomed() {
  const pane = state.activePane.value;
  const { scale } = pane.zoom.value;
  const { value: fit } = pane.fit;
  if (scale !== "fit") {
    const words = scaleWords(scale);
    return <button type="button" aria-label={`${words}: back to all of the picture`} title="Back to all of the picture (Shift-O)" onClick={() => zoomOut(pane)}>{words}</button>;
  }
  if (fit === 1 || pane.size.value[0] === 0) return null;
  return <button type="button" aria-label={`fit: all of the picture, ${scaleWords(fit)}; show it 1:1`} title={`All of the picture, ${scaleWords(fit)}; 1:1 (O)`} onClick={() => zoomToPixels(pane)}>fit</button>;
}

export function ViewPanel() {
  const words = currentWords();
  useEffect(() => speak(words.words), [words.words]);
  const busy = ["refining", "reading"].includes(words.state);
  const { progress, job } = { progress: state.progress.value, job: state.job.value };
  const share = progress && job && progress.serial === job.serial && progress.tiles_total > 0 ? progress.tiles_done / progress.tiles_total : 0;
  return (
    <>
      <div class="bar view-bar">
        <span id="view-words" class="view-words" title={words.words}><span class={`state-${words.state}`}>{words.words}</span></span>
        <Filtered />
        <OwnSettings />
        <Zoomed />
        <Cameras />
        <PinButton />
        <PaneCount />
        <button type="button" aria-pressed={state.paused.value} onClick={pauseOrResume}>{state.paused.value ? "Resume" : "Pause"}</button>
        <button type="button" disabled={!busy} onClick={stop}>Stop</button>
        <button type="button" onClick={refresh} title="Render now (Alt-P)">Refresh</button>
      </div>
      <div class={`progress ${busy ? "" : "idle"}`} aria-hidden="true"><i style={{ transform: `scaleX(${share})` }} /></div>
      <div class={`picture${state.sceneFile.value === undefined ? " without-scene" : ""}`}>
        <Panes />
      </div>
      <Chain />
      <ViewOptions />
      <span class="visually-hidden" role="status">{spoken.value}</span>
    </>
  );
}
