import { useLayoutEffect, useRef } from "preact/hooks";
import { SIDES, type Side } from "../core/camera.js";
import { Separator } from "../layout/splitter.js";
import * as state from "../state.js";
import { moveCamera, resized } from "../view/wish.js";
import { Adopt } from "./adopt.js";
import { Compare } from "./compare.js";
import { Hover } from "./hover.js";
import { Legend } from "./legend.js";
import { paneFrame } from "./pane_frame.js";
import { Playback } from "./playback.js";
import { WorkerLegend } from "./worker_legend.js";

const LEAST = 0.1;

export function PaneCount() {
  return (
    <select aria-label="Panes" value={state.paneCount.value} onChange={(event) => (state.paneCount.value = Number(event.currentTarget.value))}>
      {state.PANE_COUNTS.map((count) => <option key={count} value={count}>{count === 1 ? "1 pane" : `${count} panes`}</option>)}
    </select>
  );
}

/** Which side a pane shows, as long as nobody moves it. */
function SideChoice({ pane, side }: { pane: state.Pane; side: Side }) {
  const isMoved = pane.camera.value !== null;
  return (
    <div class="pane-side">
      <select
        aria-label={`Side that pane ${pane.number + 1} shows`}
        value={side}
        onChange={(event) => {
          pane.side.value = event.currentTarget.value as Side;
          moveCamera(null, false, pane);
        }}
      >
        {SIDES.map((each) => <option key={each} value={each}>{each}</option>)}
      </select>
      {isMoved && <button type="button" title="All of the scene (Home)" onClick={() => moveCamera(null, false, pane)}>Fit</button>}
    </div>
  );
}

/** A picture of another shape than its pane has the largest part of it that is of its own. */
function fitted(pane: state.Pane) {
  const [width, height] = pane.size.value;
  const { value: scale } = pane.fit;
  return width > 0 && pane.area.value[0] > 0 ? { width: `${width * scale}px`, height: `${height * scale}px` } : {};
}

function PaneView({ pane }: { pane: state.Pane }) {
  const { value: side } = pane.side;
  const isMain = pane === state.main;
  const host = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const observer = new ResizeObserver(([entry]) => {
      const { width, height } = entry!.contentRect;
      if (width > 0 && height > 0) resized(pane, width, height);
    });
    observer.observe(host.current!);
    return () => observer.disconnect();
  }, [pane]);
  return (
    <div ref={host} class={`pane ${state.activePane.value === pane ? "active" : ""}`} role="group" aria-label={side ? `Pane ${pane.number + 1}, ${side}` : "Pane 1, camera"}>
      <div class="pane-picture" style={fitted(pane)}>
        <Adopt element={paneFrame(pane)} />
        {side && <SideChoice pane={pane} side={side} />}
        <Hover pane={pane} />
        {isMain && <Legend />}
        {isMain && <WorkerLegend />}
        {isMain && <Compare />}
        {isMain && <Playback />}
      </div>
    </div>
  );
}

function setSplit(name: "across" | "down", share: number): void {
  state.paneSplit.value = { ...state.paneSplit.peek(), [name]: Math.min(1 - LEAST, Math.max(LEAST, share)) };
}

const tracks = (share: number) => `minmax(0, ${share}fr) 6px minmax(0, ${1 - share}fr)`;

/** One pane, two beside each other, or four. */
export function Panes() {
  const { value: count } = state.paneCount;
  const { across, down } = state.paneSplit.value;
  return (
    <div class={`panes panes-${count}`} style={{ gridTemplateColumns: count > 1 ? tracks(across) : "minmax(0, 1fr)", gridTemplateRows: count > 2 ? tracks(down) : "minmax(0, 1fr)" }}>
      {state.panes.slice(0, count).map((pane) => <PaneView key={pane.number} pane={pane} />)}
      {count > 1 && <Separator label="Width of the left panes" vertical value={across} set={(share) => setSplit("across", share)} />}
      {count > 2 && <Separator label="Height of the upper panes" vertical={false} value={down} set={(share) => setSplit("down", share)} />}
    </div>
  );
}
