import { useRef, useState } from "preact/hooks";
import { baseName } from "../core/paths.js";
import { place } from "../entities.js";
import { wished, type ModelWish } from "../models.js";
import { PlacementFields } from "../panels/placement_fields.js";
import { goToWrongField } from "../wrong_field.js";
import { Dialog } from "./dialog.js";

const close = () => (wished.value = undefined);

/** "sphere.obj" is called "Sphere". */
function titleOf(file: string): string {
  const name = baseName(file).replace(/\..*$/, "");
  return name === "" ? "Model" : name.charAt(0).toUpperCase() + name.slice(1);
}

export function ModelDialog({ wish }: { wish: ModelWish }) {
  const [placement, setPlacement] = useState(wish.placement);
  const form = useRef<HTMLFormElement>(null);
  const isLocked = wish.locked !== undefined;
  const accept = () => {
    if (isLocked || goToWrongField(form.current!) !== undefined) return;
    place(wish.file, wish.entity, placement);
    close();
  };
  return (
    <Dialog title={titleOf(wish.placement.file)} close={close}>
      <form
        ref={form}
        onKeyDown={(event) => {
          if (event.key !== "Enter" || !event.ctrlKey) return;
          event.preventDefault();
          accept();
        }}
        onSubmit={(event) => {
          event.preventDefault();
          accept();
        }}
      >
        <PlacementFields wish={{ ...wish, placement }} set={setPlacement} />
        <div class="buttons">
          <button type="button" onClick={close}>Cancel</button>
          <button type="submit" class="primary" disabled={isLocked}>Accept</button>
        </div>
      </form>
    </Dialog>
  );
}
