// A full picture in the page.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import * as looked from "../looked.js";
import { orderExport } from "../renders.js";
import { copyCanvas } from "../clipboard.js";
import { Dialog } from "./dialog.js";

function words(): string {
  const of = looked.report();
  if (!of) return "";
  const share = of.state === "tracing" && of.tiles_total ? `, ${Math.floor((100 * (of.tiles_done ?? 0)) / of.tiles_total)} %` : "";
  const image = looked.image.value;
  const size = image ? `, ${image.width} × ${image.height}` : ", no picture yet";
  return `Full picture ${of.job} of ${of.file ?? ""}: ${of.state ?? ""}${share}${size}`;
}

export function PictureDialog() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [isActualSize, setActualSize] = useState(false);
  const { value: image } = looked.image;
  const of = looked.report();
  useLayoutEffect(() => {
    if (!image || !canvas.current) return;
    canvas.current.width = image.width;
    canvas.current.height = image.height;
    canvas.current.getContext("2d")!.drawImage(image, 0, 0);
  }, [image]);
  const name = `${(of?.file ?? "picture").replace(/\.[^./]*$/, "")}.png`;
  return (
    <Dialog title="Picture" close={looked.close} wide>
      <div class={`looked${isActualSize ? " actual" : ""}`} tabIndex={0} role="group" aria-label="The picture; arrows scroll it">
        <canvas ref={canvas} role="img" aria-label={words()} />
      </div>
      <p role="status">{words()}</p>
      <div class="buttons">
        <button type="button" aria-pressed={isActualSize} onClick={() => setActualSize(!isActualSize)}>Actual size</button>
        <button type="button" disabled={!image} onClick={() => void copyCanvas(canvas.current!, "The picture is in the clipboard.")}>Copy</button>
        <button type="button" disabled={!of?.has_picture} onClick={() => orderExport({ job: looked.job.peek()!, name, download: true })}>Download</button>
        <button type="button" class="primary" autofocus onClick={looked.close}>Close</button>
      </div>
    </Dialog>
  );
}
