import { useLayoutEffect, useRef } from "preact/hooks";
import { shown } from "../view/frames.js";

/** A frame of the animation over the view, while it is played from pictures that are there. */
export function Playback() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { value: image } = shown;
  useLayoutEffect(() => {
    if (!image || !canvas.current) return;
    canvas.current.width = image.width;
    canvas.current.height = image.height;
    canvas.current.getContext("2d")!.putImageData(image, 0, 0);
  }, [image]);
  return image ? <canvas class="playback" ref={canvas} role="img" aria-label="Frame of the animation" /> : null;
}
