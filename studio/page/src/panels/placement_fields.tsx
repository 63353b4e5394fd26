import { useId, useState } from "preact/hooks";
import type { Placement } from "../core/protocol.js";
import { candidates, faultOfFile, type ModelWish } from "../models.js";
import { NumberField } from "./number_field.js";

const AXES = ["x", "y", "z"] as const;
type Triple = Placement["position"];

function replaced<T>(all: [T, T, T], index: number, value: T): [T, T, T] {
  return all.map((each, at) => (at === index ? value : each)) as [T, T, T];
}

interface TripleProps {
  label: string;
  unit?: string;
  value: Triple;
  positive?: boolean;
  disabled: boolean;
  begin: (() => void) | undefined;
  set: (value: Triple) => void;
}

function TripleField({ label, unit, value, positive, disabled, begin, set }: TripleProps) {
  return (
    <div class="field" role="group" aria-label={label}>
      <span>{label}</span>
      <span class="vector">
        {AXES.map((axis, index) => (
          <NumberField
            key={axis} quiet label={`${label} ${axis}`} text={value[index]!} disabled={disabled} unit={unit} begin={begin}
            rules={positive ? { range: [0, Infinity], open: true } : {}} commit={(text) => set(replaced(value, index, text))}
          />
        ))}
      </span>
    </div>
  );
}

/** A name that is none of a file that can be placed is not set. */
function FileField({ wish, begin, set }: { wish: ModelWish; begin: (() => void) | undefined; set: (file: string) => void }) {
  const [draft, setDraft] = useState<string | undefined>(undefined);
  const id = useId();
  const { file: text } = wish.placement;
  const known = candidates(wish.file);
  const disabled = wish.locked !== undefined;
  const fault = faultOfFile(draft ?? text, wish);
  return (
    <label class={`field ${fault ? "wrong" : ""}`}>
      <span>File</span>
      <input
        type="text" autofocus={begin === undefined} spellcheck={false} autocomplete="off" list={`${id}-files`} value={draft ?? text} disabled={disabled}
        aria-invalid={fault !== undefined} aria-describedby={fault ? `${id}-wrong` : undefined}
        onFocus={begin}
        onInput={({ currentTarget: { value } }) => {
          setDraft(value);
          if (faultOfFile(value, wish) === undefined) set(value);
        }}
        onBlur={() => fault === undefined && setDraft(undefined)}
      />
      {fault && <span class="why" id={`${id}-wrong`}>{fault}</span>}
      <datalist id={`${id}-files`}>{known.map((each) => <option key={each} value={each} />)}</datalist>
    </label>
  );
}

export interface PlacementProps {
  wish: ModelWish;
  /** Hears that what is set from now on belongs together, where it is set at once. */
  begin?: () => void;
  set: (placement: Placement) => void;
}

/** File, position, rotation, scale, flip and material of a model. */
export function PlacementFields({ wish, begin, set: setAll }: PlacementProps) {
  const { placement } = wish;
  const [parts, setParts] = useState(false);
  const isUneven = parts || new Set(placement.scale).size > 1;
  const isLocked = wish.locked !== undefined;
  const set = (changes: Partial<Placement>) => setAll({ ...placement, ...changes });
  const choose = (changes: Partial<Placement>) => {
    begin?.();
    set(changes);
  };
  return (
    <>
      <div class="fields">
        <FileField wish={wish} begin={begin} set={(file) => set({ file })} />
        <TripleField label="Position" value={placement.position} disabled={isLocked} begin={begin} set={(position) => set({ position })} />
        <TripleField label="Rotation" unit="°" value={placement.rotation} disabled={isLocked} begin={begin} set={(rotation) => set({ rotation })} />
        {isUneven ? (
          <TripleField label="Scale" positive value={placement.scale} disabled={isLocked} begin={begin} set={(scale) => set({ scale })} />
        ) : (
          <NumberField label="Scale" text={placement.scale[0]} rules={{ range: [0, Infinity], open: true }} disabled={isLocked} begin={begin} commit={(text) => set({ scale: [text, text, text] })} />
        )}
        <label class="field">
          <span>Each axis by itself</span>
          <span><input type="checkbox" aria-label="Scale each axis by itself" checked={isUneven} disabled={isLocked} onChange={(event) => {
            setParts(event.currentTarget.checked);
            const [first] = placement.scale;
            if (!event.currentTarget.checked) choose({ scale: [first, first, first] });
          }} /></span>
        </label>
        <div class="field" role="group" aria-label="Flip">
          <span>Flip</span>
          <span class="group">
            {AXES.map((axis, index) => (
              <label key={axis}>
                <input type="checkbox" aria-label={`Flip ${axis}`} checked={placement.flip[index]} disabled={isLocked} onChange={(event) => choose({ flip: replaced(placement.flip, index, event.currentTarget.checked) })} /> {axis}
              </label>
            ))}
          </span>
        </div>
        {wish.materials && (
          <label class="field">
            <span>Material</span>
            <select value={placement.material} disabled={isLocked} onChange={(event) => choose({ material: event.currentTarget.value })}>
              <option value="">its own</option>
              {[...new Set([...wish.materials, placement.material])].filter(Boolean).map((each) => <option key={each} value={each}>{each}</option>)}
            </select>
          </label>
        )}
      </div>
      {isLocked && <p class="aside">Nothing is set here: {wish.locked}.</p>}
    </>
  );
}
