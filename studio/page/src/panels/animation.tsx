import { signal } from "@preact/signals";
import { question } from "../confirm.js";
import { showPanel } from "../layout/layout_state.js";
import { orderRenderOfPage } from "../renders.js";
import * as state from "../state.js";
import * as frames from "../view/frames.js";
import { at, first, last, looping, perSecond, playOrPause, playing, show, step } from "../view/player.js";
import { NumberField } from "./number_field.js";

const names = signal("frame.png");

/** Which frames have pictures. */
function FrameStrip() {
  void frames.revision.value;
  const count = last.value - first.value + 1;
  if (count < 1 || count > 2000) return null;
  const states = Array.from({ length: count }, (_, index) => frames.stateOf(first.value + index));
  const counted = (state: frames.FrameState) => states.filter((each) => each === state).length;
  const words = [`${counted("whole")} of ${count} frames are there`];
  if (counted("coarse") > 0) words.push(`${counted("coarse")} are coarse`);
  if (counted("failed") > 0) words.push(`${counted("failed")} failed`);
  return (
    <div class="frames" role="img" aria-label={words.join(", ")}>
      {states.map((each, index) => <i key={index} class={each} title={`frame ${first.value + index}: ${each === "none" ? "not made" : each}`} />)}
    </div>
  );
}

/** Full pictures of all frames: files with the frames' numbers, or one of all of them where the name's ending is
    .gif or .apng. Where all would be the same, or files exist, it is asked about first. */
function exportFrames(): void {
  const name = names.peek().trim();
  const spec = { frames: [first.peek(), last.peek()] as [number, number], per_second: perSecond.peek(), outputs: name ? [name] : [] };
  const order = () => {
    if (orderRenderOfPage(spec)) showPanel("Farm");
  };
  const count = last.peek() - first.peek() + 1;
  if (count < 2 || state.summary.peek()?.depends_on_frame !== false) return order();
  question.value = {
    title: "All frames are the same",
    words: `Nothing in ${state.sceneFile.peek()} depends on the frame: all ${count} pictures will be the same.`,
    accept: `Render all ${count}`,
    run: order,
  };
}

export function AnimationPanel() {
  const whole = (least: number) => ({ whole: true, range: [least, state.mostOf("frames")] as [number, number] });
  return (
    <div class="animation">
      <div class="group">
        <button type="button" aria-label="One frame back" onClick={() => step(-1)}>◂</button>
        <button type="button" class="primary" onClick={playOrPause}>{playing.value ? "Pause" : "Play"}</button>
        <button type="button" aria-label="One frame on" onClick={() => step(1)}>▸</button>
        <input type="range" aria-label="Frame" min={first.value} max={Math.max(first.value, last.value)} step={1} value={at.value} onInput={(event) => show(Number(event.currentTarget.value))} />
        <output>frame {at.value}</output>
        <label><input type="checkbox" checked={looping.value} onChange={(event) => (looping.value = event.currentTarget.checked)} /> loop</label>
      </div>
      <FrameStrip />
      <div class="group">
        <button type="button" aria-pressed={frames.isCaching.value} onClick={() => (frames.isCaching.peek() ? frames.stopCaching() : frames.cache(first.peek(), last.peek()))}>
          {frames.isCaching.value ? "Stop making frames" : "Make frames"}
        </button>
        <label title="Files with the frames' numbers, such as frame.0001.png; or one of all frames: .gif, or .apng, which loses nothing">Files <input type="text" aria-label="Names of the files; .gif and .apng hold all frames" value={names.value} onInput={(event) => (names.value = event.currentTarget.value)} /></label>
        <button type="button" onClick={() => exportFrames()}>Render the frames to files</button>
      </div>
      <div class="fields">
        <NumberField label="First frame" text={String(first.value)} rules={whole(0)} commit={(text) => (first.value = Number(text))} />
        <NumberField label="Last frame" text={String(last.value)} rules={whole(first.value)} commit={(text) => (last.value = Number(text))} />
        <NumberField label="A second" text={String(perSecond.value)} rules={{ range: [0.1, 1000] }} commit={(text) => (perSecond.value = Number(text))} />
      </div>
    </div>
  );
}
