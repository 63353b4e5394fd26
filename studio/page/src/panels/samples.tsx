import { useEffect, useRef } from "preact/hooks";
import { baseName } from "../core/paths.js";
import * as program from "../program.js";
import * as state from "../state.js";
import { pictures, SIZE, stop, want } from "../view/small_pictures.js";

/** "still_life.tessera" is called "still life". */
function titleOf(name: string): string {
  return baseName(name).replace(/\.[^.]*$/, "").replaceAll("_", " ");
}

function Sample({ name }: { name: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const picture = pictures.value.get(name);
  useEffect(() => {
    if (picture) canvas.current!.getContext("2d")!.putImageData(picture, 0, 0);
  }, [picture]);
  useEffect(() => {
    if (picture !== undefined || state.connection.value !== "open") return;
    const observer = new IntersectionObserver((entries) => {
      if (entries.some((each) => each.isIntersecting)) want(name);
    });
    observer.observe(canvas.current!);
    return () => observer.disconnect();
  }, [name, picture, state.connection.value]);
  return (
    <li>
      <button type="button" title="Opens an untitled copy" onClick={() => program.send("create", { sample: name })}>
        <canvas ref={canvas} width={SIZE[0]} height={SIZE[1]} aria-hidden="true" />
        <span class="name">{titleOf(name)}</span>
        <span class="aside">{picture === null ? "no picture could be made" : name}</span>
      </button>
    </li>
  );
}

/** The scenes that ship with the program, as small pictures. */
export function Samples() {
  useEffect(() => stop, []);
  const names = state.welcome.value?.samples ?? [];
  if (names.length === 0) return null;
  return (
    <div role="group" aria-label="Samples">
      <h2>Samples</h2>
      <ul class="cards samples">
        {names.map((each) => <Sample key={each} name={each} />)}
      </ul>
    </div>
  );
}
