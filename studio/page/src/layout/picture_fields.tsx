// What the dialogs of full pictures and of exports ask for alike.

import type { RefObject } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { RenderSpec } from "../core/protocol.js";
import { NumberField } from "../panels/number_field.js";
import type { Answer } from "../renders.js";
import * as state from "../state.js";
import { goToWrongField } from "../wrong_field.js";

/** The scene's name without its ending. */
export function stem(): string {
  return (state.sceneFile.value ?? "picture").replace(/\.[^./]*$/, "");
}

export function Check({ label, value, set, disabled }: { label: string; value: boolean; set: (value: boolean) => void; disabled?: boolean }) {
  return (
    <label class="field">
      <span>{label}</span>
      <span><input type="checkbox" aria-label={label} checked={value} disabled={disabled ?? false} onChange={(event) => set(event.currentTarget.checked)} /></span>
    </label>
  );
}

/** The name of a file below the folder, whose stem is selected at first: what is typed takes its place. */
export function NameField({ label, value, set, focus }: { label: string; value: string; set: (value: string) => void; focus?: boolean }) {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (!focus || !input.current) return;
    const dot = input.current.value.lastIndexOf(".");
    input.current.focus();
    input.current.setSelectionRange(0, dot > 0 ? dot : input.current.value.length);
  }, []);
  return (
    <label class="field">
      <span>{label}</span>
      <input ref={input} type="text" spellcheck={false} autocomplete="off" value={value} onInput={(event) => set(event.currentTarget.value)} />
    </label>
  );
}

/** Size, samples and values beside light, in place of what the scene says. */
export interface PictureWish {
  width: string;
  height: string;
  samples: string;
  aovs: string[];
}

export const AS_THE_SCENE: PictureWish = { width: "", height: "", samples: "", aovs: [] };

export function overridesOf({ width, height, samples, aovs }: PictureWish): NonNullable<RenderSpec["overrides"]> {
  return {
    ...(width && height ? { size: `${width}x${height}` } : {}),
    ...(samples ? { spp: Number(samples) } : {}),
    ...(aovs.length > 0 ? { aovs: aovs.join(",") } : {}),
  };
}

export function PictureFields({ wish, change }: { wish: PictureWish; change: (part: Partial<PictureWish>) => void }) {
  const aovs = state.choicesOf("aovs");
  const lacks = (side: string, other: string) => (side === "" && other !== "" ? "found nothing; expected width and height, or neither" : undefined);
  const field = (label: string, name: "width" | "height" | "samples", most: number, wrong?: string) => (
    <NumberField label={label} text={wish[name]} placeholder="scene says" optional rules={{ whole: true, range: [1, most] }} wrong={wrong} commit={(text) => change({ [name]: text })} />
  );
  const toggle = (aov: string, isWanted: boolean) => change({ aovs: aovs.filter((each) => (each === aov ? isWanted : wish.aovs.includes(each))) });
  return (
    <>
      {field("Width", "width", state.mostOf("side"), lacks(wish.width, wish.height))}
      {field("Height", "height", state.mostOf("side"), lacks(wish.height, wish.width))}
      {field("Samples", "samples", state.mostOf("spp"))}
      <div class="field" role="group" aria-label="Values beside light, in EXR">
        <span>Values beside light, in EXR</span>
        <span class="group wrap">
          {aovs.map((each) => (
            <label key={each}>
              <input type="checkbox" checked={wish.aovs.includes(each)} onChange={(event) => toggle(each, event.currentTarget.checked)} /> {each}
            </label>
          ))}
        </span>
      </div>
    </>
  );
}

/** An order of a form, which stays open until it is done. */
export function useOrder(close: () => void): { form: RefObject<HTMLFormElement | null>; why: string | undefined; isWaiting: boolean; isRight: () => boolean; begin: () => Answer; forget: () => void } {
  const form = useRef<HTMLFormElement>(null);
  const [why, setWhy] = useState<string | undefined>(undefined);
  const [isWaiting, setWaiting] = useState(false);
  /** Whether no field of the form is wrong; one that is has the focus, and the form says why. */
  const isRight = () => {
    const wrong = goToWrongField(form.current!);
    setWhy(wrong);
    return wrong === undefined;
  };
  const begin = () => {
    setWhy(undefined);
    setWaiting(true);
    return (refused?: string) => {
      setWaiting(false);
      if (refused === undefined) close();
      else setWhy(refused);
    };
  };
  return { form, why, isWaiting, isRight, begin, forget: () => setWhy(undefined) };
}
