import type { FreeCamera, Vector } from "../core/protocol.js";
import { expectedOfPose } from "../core/camera.js";
import { written } from "../core/numbers.js";
import * as documents from "../documents.js";
import { select } from "../entities.js";
import { showPanel } from "../layout/layout_state.js";
import * as state from "../state.js";
import { currentCamera, isPanoramic, moveCamera } from "../view/wish.js";
import { NumberField } from "./number_field.js";

type VectorName = "eye" | "target" | "up";

function VectorField({ label, name, camera }: { label: string; name: VectorName; camera: FreeCamera }) {
  const withNumber = (index: number, value: number): FreeCamera => {
    const vector = [...camera[name]] as Vector;
    vector[index] = value;
    return { ...camera, [name]: vector };
  };
  return (
    <div class="field">
      <span>{label}</span>
      <span class="vector">
        {["x", "y", "z"].map((axis, index) => (
          <NumberField key={axis} quiet label={`${label} ${axis}`} text={written(camera[name][index]!)} rules={{ also: (value) => expectedOfPose(withNumber(index, value)) }} commit={(text) => moveCamera(withNumber(index, Number(text)), true)} />
        ))}
      </span>
    </div>
  );
}

/** Aperture, focus and the rest are properties of the scene's own camera. */
function Lens({ name }: { name: string | undefined }) {
  const outline = state.sceneFile.value === undefined ? undefined : state.outlines.value.get(state.sceneFile.value);
  const cameras = outline?.entities.filter((each) => each.kind === "camera") ?? [];
  const camera = name === undefined ? cameras[0] : (cameras.find((each) => each.name === name) ?? cameras[Number(name) - 1]);
  if (!outline || !camera) return null;
  return (
    <button
      type="button"
      title="Aperture, focus, shutter and all else that the scene says of its camera"
      onClick={() => {
        documents.activate(outline.file);
        select(camera);
        showPanel("Properties", true);
      }}
    >
      Lens of the camera…
    </button>
  );
}

/** The camera by its numbers, which follow the mouse. */
export function CameraFields() {
  const camera = currentCamera();
  if (!camera) return null;
  // A panorama keeps its own, and parallel rays have none.
  const hasAngle = camera.orthographic === undefined && !isPanoramic(state.main);
  return (
    <div class="camera-fields">
      <VectorField label="Eye" name="eye" camera={camera} />
      <VectorField label="Target" name="target" camera={camera} />
      <VectorField label="Up" name="up" camera={camera} />
      {hasAngle && <NumberField label="Field of view" unit="°" text={written(camera.fov)} rules={{ range: [0, 180], open: true }} commit={(text) => moveCamera({ ...camera, fov: Number(text) }, true)} />}
      {hasAngle && (
        <label class="field">
          <span>It spans</span>
          <select value={camera.axis ?? "smaller"} onChange={(event) => moveCamera({ ...camera, axis: event.currentTarget.value as FreeCamera["axis"] }, false)}>
            {["smaller", "horizontal", "vertical"].map((each) => <option key={each} value={each}>{each}</option>)}
          </select>
        </label>
      )}
      {camera.orthographic !== undefined && <NumberField label="Height seen" unit="m" text={written(camera.orthographic)} rules={{ range: [0, Infinity], open: true }} commit={(text) => moveCamera({ ...camera, orthographic: Number(text) }, true)} />}
      <Lens name={camera.name} />
    </div>
  );
}
