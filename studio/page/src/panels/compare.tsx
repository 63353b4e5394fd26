import { probedNumber } from "../core/probed.js";
import { compareWithBefore, mode, moveWipe, numbers, pin, pinned, toggle, wipe, type CompareMode } from "../view/compare.js";

const STEP = 0.01;
const MODES: [CompareMode, string, string][] = [
  ["pinned", "Pinned", "The pinned picture in place of the other (B)"],
  ["wipe", "Wipe", "The pinned picture left of a line (V)"],
  ["difference", "Difference", "By how much they differ (N)"],
];

export function PinButton() {
  return (
    <>
      <button type="button" title="Pin this picture to compare others with it (C)" onClick={() => pin("shown")}>Pin</button>
      <button type="button" title="Compare with the picture before the last change of the scene" onClick={compareWithBefore}>Before</button>
    </>
  );
}

/** Whose numbers `tessera compare --metrics` tells, too. */
function Numbers() {
  const { value: compared } = numbers;
  if (!compared) return <p class="aside">comparing</p>;
  if (compared.why) return <p role="alert">{compared.why}</p>;
  const rows: [string, number | string | null | undefined][] = [
    ["max difference", compared.max_difference],
    ["mean difference", compared.mean_difference],
    ["rmse", compared.rmse],
    ["differing pixels", compared.differing_pixels],
    ["worst pixel", compared.worst_pixel?.join(", ")],
    ["relMSE", compared.rel_mse],
    ["SMAPE", compared.smape],
    ["FLIP", compared.flip],
    ["SSIM", compared.ssim],
    ["99.9 % are within", compared.within],
    ["mean ratio", compared.mean_ratio],
  ];
  return (
    <table class="numbers" aria-label="Difference from the pinned picture" data-serial={compared.serial}>
      <tbody>
        {rows.filter(([, value]) => value !== undefined).map(([name, value]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            <td>{typeof value === "number" ? probedNumber(value) : (value ?? "–")}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function WipeLine() {
  const drag = (event: PointerEvent) => {
    const line = event.currentTarget as HTMLElement;
    const box = line.parentElement!.getBoundingClientRect();
    line.setPointerCapture(event.pointerId);
    line.focus();
    line.onpointermove = (move) => moveWipe((move.clientX - box.left) / box.width);
    line.onpointerup = () => (line.onpointermove = line.onpointerup = null);
    event.preventDefault();
  };
  const key = (event: KeyboardEvent) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    moveWipe(wipe.peek() + (event.key === "ArrowRight" ? STEP : -STEP) * (event.shiftKey ? 5 : 1));
    event.preventDefault();
  };
  return (
    <div
      class="wipe-line"
      role="separator"
      aria-label="Line between the pinned picture and the other"
      aria-orientation="vertical"
      aria-valuenow={Math.round(wipe.value * 100)}
      aria-valuemin={0}
      aria-valuemax={100}
      tabIndex={0}
      style={{ left: `${wipe.value * 100}%` }}
      onPointerDown={drag}
      onKeyDown={key}
    />
  );
}

/** Over the picture, so that it keeps its size: how it is held against the pinned one. */
export function Compare() {
  if (!pinned.value) return null;
  return (
    <>
      {mode.value === "wipe" && <WipeLine />}
      <div class="compare" role="group" aria-label="Compare with the pinned picture">
        {MODES.map(([name, label, title]) => (
          <button key={name} type="button" title={title} aria-pressed={mode.value === name} onClick={() => toggle(name)}>{label}</button>
        ))}
        <button type="button" onClick={() => pin("none")}>Unpin</button>
        {mode.value === "difference" && (
          <details open>
            <summary>Numbers</summary>
            <Numbers />
          </details>
        )}
      </div>
    </>
  );
}
