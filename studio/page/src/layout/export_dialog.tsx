import { useState } from "preact/hooks";
import type { ExportWish, RenderSpec } from "../core/protocol.js";
import { copyCommand, copyCommandOf, copyCommandOfView, orderExport, orderRender } from "../renders.js";
import * as state from "../state.js";
import { Dialog } from "./dialog.js";
import { AS_THE_SCENE, Check, NameField, overridesOf, PictureFields, stem, useOrder } from "./picture_fields.js";

/** A picture that is made for the file, with another size, other samples or values beside light. */
const ANEW = "anew";

/** A file of the view's picture, of a full one, of one that is made for it, or of the scene. */
export function ExportDialog({ close, copy }: { close: () => void; copy: () => Promise<void> }) {
  const pictures = state.renders.value.filter((each) => each.has_picture);
  const [name, setName] = useState(`${stem()}.png`);
  const [source, setSource] = useState(pictures.length > 0 ? String(pictures[pictures.length - 1]!.job) : "view");
  const [wish, setWish] = useState(AS_THE_SCENE);
  const [statistics, setStatistics] = useState(false);
  const { form, why, isWaiting, isRight, begin, forget } = useOrder(close);
  const isScene = /\.(tessera|tesserab|json)$/i.test(name.trim());
  const isAnew = source === ANEW && !isScene;
  const hasStatistics = statistics && !isScene && source !== "view";
  const anew = (): RenderSpec => ({ overrides: { ...state.overrides.peek(), ...overridesOf(wish) }, outputs: [name.trim()], statistics: hasStatistics });
  const exported = (more: Partial<ExportWish> = {}): ExportWish => ({
    ...(state.sceneFile.peek() === undefined ? {} : { file: state.sceneFile.peek()! }),
    ...(source === "view" || isScene ? { pane: 0 } : { job: Number(source) }),
    name: name.trim(),
    statistics: hasStatistics,
    ...more,
  });
  const write = () => {
    if (!isRight()) return;
    if (isAnew) orderRender(anew(), begin());
    else orderExport(exported(), begin());
  };
  const download = () => {
    if (!isRight()) return;
    if (!isAnew) return orderExport(exported({ download: true }), begin());
    const file = { name: name.trim(), statistics: hasStatistics, download: true };
    orderRender({ ...anew(), outputs: [] }, begin(), (job) => orderExport({ ...file, job: job.job }));
  };
  const command = () => {
    if (!isRight()) return;
    const job = state.renders.peek().find((each) => String(each.job) === source);
    if (job) return copyCommandOf(job);
    if (isAnew) copyCommand(anew());
    else copyCommandOfView(name.trim() ? [name.trim()] : []);
  };
  return (
    <Dialog title="Export" close={close}>
      <form
        ref={form}
        onInput={forget}
        onSubmit={(event) => {
          event.preventDefault();
          write();
        }}
      >
        <div class="fields">
          <NameField focus label="Name below the folder; the ending tells the format (.png .exr … or .tessera .tesserab .json for the scene)" value={name} set={setName} />
          <label class="field">
            <span>Picture</span>
            <select value={source} disabled={isScene} onChange={(event) => setSource(event.currentTarget.value)}>
              <option value="view">{`of the view, ${state.viewSize.value.join(" x ")} pixels`}</option>
              <option value={ANEW}>made anew, as follows</option>
              {pictures.map((each) => <option key={each.job} value={String(each.job)}>{`full picture ${each.job} of ${each.file}`}</option>)}
            </select>
          </label>
          {isAnew && <PictureFields wish={wish} change={(part) => setWish((before) => ({ ...before, ...part }))} />}
          <Check label="Statistics beside it" value={statistics} disabled={isScene || source === "view"} set={setStatistics} />
        </div>
        {why !== undefined && <p class="why" role="alert">{why}</p>}
        <div class="buttons">
          <button type="button" onClick={close}>Cancel</button>
          <button type="button" onClick={command}>Copy command line</button>
          <button type="button" onClick={() => void copy().then(close)}>Copy the view</button>
          <button type="button" onClick={download} disabled={isWaiting}>Download</button>
          <button type="submit" class="primary" disabled={isWaiting}>Export</button>
        </div>
      </form>
    </Dialog>
  );
}
