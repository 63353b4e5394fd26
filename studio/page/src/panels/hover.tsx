import { hexOf, probedNumber, probedRows } from "../core/probed.js";
import { frameAt } from "../core/zoom.js";
import * as state from "../state.js";
import { hoveredChain } from "../view/parts.js";
import { isProbing } from "../view/probe.js";

/** The values of the film under the pointer. */
function Probed() {
  const probed = state.probed.value;
  const pane = state.activePane.value;
  if (!probed || !pane.pointer.value) return <div class="hover-name">Point at the picture, or press Enter in it for a cross-hair</div>;
  const { shown } = probed;
  const rows = probedRows(probed.channels ?? [], probed.values ?? []);
  return (
    <table class="hover-name probed" aria-label="Values under the pointer">
      <tbody style={{ "--rows": rows.length + 2 }}>
        <tr><th scope="row">pixel</th><td>{probed.x}</td><td>{probed.y}</td></tr>
        {shown && (
          <tr>
            <th scope="row">8 bit</th>
            {shown.map((value, index) => <td key={index}>{value}</td>)}
            <td><i class="swatch" style={{ background: hexOf(shown) }} aria-hidden="true" />{hexOf(shown)}</td>
          </tr>
        )}
        {rows.map((row) => (
          <tr key={row.name}>
            <th scope="row">{row.name}</th>
            {row.values.map((value, index) => <td key={index}>{probedNumber(value)}</td>)}
          </tr>
        ))}
        {!shown && <tr><td>{pane.job.value?.state === "tracing" ? "refining" : "no pixel yet"}</td></tr>}
      </tbody>
    </table>
  );
}

function CrossHair({ pane }: { pane: state.Pane }) {
  const at = pane.pointer.value;
  const [width, height] = pane.size.value;
  if (!pane.hasCrossHair.value || !at) return null;
  const [right, down] = frameAt(pane.shown.value, (at[0] + 0.5) / width, (at[1] + 0.5) / height);
  return <div class="crosshair" aria-hidden="true" style={{ left: `${right * 100}%`, top: `${down * 100}%` }} />;
}

/** What lies over a pane's picture: the names of what is under the pointer, or the values there. */
export function Hover({ pane }: { pane: state.Pane }) {
  const isActive = state.activePane.value === pane;
  const names = hoveredChain(pane).filter((each) => each.kind !== "face" && each.kind !== "material").map((each) => each.name || each.kind);
  // What keys point at is spoken.
  return (
    <div role={pane.hasCrossHair.value ? "status" : undefined}>
      <CrossHair pane={pane} />
      {isActive && isProbing.value ? <Probed /> : names.length > 0 && <div class="hover-name">{names.join(" ‹ ")}</div>}
    </div>
  );
}
