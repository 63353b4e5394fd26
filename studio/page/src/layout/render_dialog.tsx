import { useState } from "preact/hooks";
import type { RenderSpec } from "../core/protocol.js";
import { copyCommand, orderRender } from "../renders.js";
import { Dialog } from "./dialog.js";
import { AS_THE_SCENE, Check, NameField, overridesOf, PictureFields, stem, useOrder } from "./picture_fields.js";

/** Size, samples, values beside light and files of a full picture. */
export function RenderDialog({ close }: { close: () => void }) {
  const [wish, setWish] = useState(AS_THE_SCENE);
  const [denoise, setDenoise] = useState(false);
  const [names, setNames] = useState(`${stem()}.png`);
  const [statistics, setStatistics] = useState(false);
  const { form, why, isWaiting, isRight, begin, forget } = useOrder(close);
  const spec = (): RenderSpec => ({
    overrides: { ...overridesOf(wish), ...(denoise ? { denoise } : {}) },
    outputs: names.split(",").map((each) => each.trim()).filter(Boolean),
    statistics,
  });
  const render = () => {
    if (isRight()) orderRender(spec(), begin());
  };
  return (
    <Dialog title="Full picture" close={close}>
      <form
        ref={form}
        onInput={forget}
        onSubmit={(event) => {
          event.preventDefault();
          render();
        }}
      >
        <div class="fields">
          <PictureFields wish={wish} change={(part) => setWish((before) => ({ ...before, ...part }))} />
          <NameField label="Files below the folder; endings tell the formats" value={names} set={setNames} />
          <Check label="Denoise" value={denoise} set={setDenoise} />
          <Check label="Statistics beside it" value={statistics} set={setStatistics} />
        </div>
        {why !== undefined && <p class="why" role="alert">{why}</p>}
        <div class="buttons">
          <button type="button" onClick={close}>Cancel</button>
          <button type="button" onClick={() => isRight() && copyCommand(spec())}>Copy command line</button>
          <button type="submit" class="primary" disabled={isWaiting}>Render</button>
        </div>
      </form>
    </Dialog>
  );
}
