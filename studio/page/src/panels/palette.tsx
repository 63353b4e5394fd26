import { addToScene } from "../entities.js";
import * as state from "../state.js";
import { look } from "../view/picking.js";
import { spotAt, type Spot } from "./pane_frame.js";

const PRIMITIVES = ["sphere", "box", "plane", "disc", "rectangle", "cylinder", "cone", "torus"];

async function place(name: string, spot: Spot | undefined): Promise<void> {
  const seen = spot ? await look(spot) : undefined;
  addToScene(name, { position: seen?.point });
}

/** Shapes that are added at the origin, or dragged onto the picture. */
export function Palette() {
  const scene = state.sceneFile.value;
  const templates = (scene === undefined ? undefined : state.outlines.value.get(scene)?.templates) ?? [];
  const shapes = PRIMITIVES.filter((name) => templates.some((each) => each.name === name));
  if (shapes.length === 0) return null;
  return (
    <div class="bar palette" role="toolbar" aria-label="Shapes: Enter adds one at the origin, dragging onto the picture places it">
      {shapes.map((name) => (
        <button
          key={name}
          type="button"
          onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
          onPointerUp={(event) => {
            const spot = spotAt(event);
            if (spot) void place(name, spot);
          }}
          onClick={(event) => {
            // Where a drag ends elsewhere, the button is clicked all the same.
            const isOver = event.detail === 0 || document.elementFromPoint(event.clientX, event.clientY)?.closest("button") === event.currentTarget;
            if (isOver) void place(name, undefined);
          }}
        >
          {name}
        </button>
      ))}
    </div>
  );
}
