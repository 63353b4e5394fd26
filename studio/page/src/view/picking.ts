// What was clicked on the picture: its text, and the chain of what it stands in.

import { signal } from "@preact/signals";
import type { ToPage, Vector } from "../core/protocol.js";
import * as documents from "../documents.js";
import * as program from "../program.js";
import * as state from "../state.js";
import { setPivot } from "./wish.js";

/** Which link of the chain is selected. */
export const chainAt = signal(0);
/** Whether the last click met nothing. */
export const metNothing = signal(false);
/** A kind of things that was walked to is picked until another one is. */
let keptKind: string | undefined;
let pivotDue = false;
/** Where the cursor stood when something was clicked last: an answer does not move one that was put elsewhere since. */
let cursorAtClick = "";
/** Who asked what is seen at a pixel, and selects nothing. */
let looking: { pane: state.Pane; x: number; y: number; done: (seen: Seen | undefined) => void } | undefined;
const PATIENCE_MS = 3000;

export type Seen = Pick<ToPage["picked"], "chain" | "point">;

/** What is seen at a pixel; nothing where the program does not say. */
export function look({ pane, pixel: [x, y] }: { pane: state.Pane; pixel: [number, number] }): Promise<Seen | undefined> {
  looking?.done(undefined);
  return new Promise((resolve) => {
    const asked = { pane, x, y, done: (seen: Seen | undefined) => {
      if (looking === asked) looking = undefined;
      resolve(seen);
    } };
    looking = asked;
    if (!program.send("pick", { pane: pane.number, x, y })) asked.done(undefined);
    setTimeout(() => asked.done(undefined), PATIENCE_MS);
  });
}

export function pick(pane: state.Pane, x: number, y: number, asPivot = false): void {
  pivotDue = asPivot;
  cursorAtClick = cursor();
  program.send("pick", { pane: pane.number, x, y });
}

export function picked(message: ToPage["picked"]): void {
  if (looking?.pane.number === message.pane && looking.x === message.x && looking.y === message.y) return looking.done(message);
  if (pivotDue) {
    pivotDue = false;
    setPivot(message.point as Vector | undefined);
  }
  state.chain.value = message.chain;
  metNothing.value = message.chain.length === 0;
  if (metNothing.peek()) return;
  const kept = keptKind === undefined ? -1 : message.chain.findIndex((each) => each.kind === keptKind);
  // A model's own text says little: what placed it is gone to, unless the model is open.
  const told = message.chain.findIndex((each, index) => index >= message.at && each.file !== undefined && !isClosedModel(each.file));
  const movesCursor = cursor() === cursorAtClick;
  goTo(kept >= 0 ? kept : told >= 0 ? told : message.at, movesCursor);
  if (movesCursor) cursorAtClick = cursor();
}

function cursor(): string {
  const { line, column, endLine, endColumn } = state.caret.peek();
  return [state.activeFile.peek(), line, column, endLine, endColumn].join(":");
}

function isClosedModel(file: string): boolean {
  return !documents.find(file) && state.files.peek().some((each) => each.name === file && each.kind === "model");
}

function goTo(at: number, movesCursor = true): void {
  chainAt.value = at;
  const link = state.chain.peek()[at];
  if (!link) return;
  if (link.entity !== undefined) state.selectedEntity.value = link.entity;
  if (movesCursor && link.file !== undefined && link.line !== undefined) {
    documents.revealPlace(link.file, { ...link, line: link.line }, false);
  }
}

/** Selects a link of the chain; from now on things of its kind are picked. */
export function chooseLink(at: number): void {
  const link = state.chain.peek()[at];
  if (!link) return;
  keptKind = link.kind === "material" ? link.kind : undefined;
  goTo(at);
}

/** Outwards from what was picked, or inwards. */
export function walkChain(step: number): void {
  const count = state.chain.peek().length;
  if (count > 0) chooseLink(Math.min(count - 1, Math.max(0, chainAt.peek() + step)));
}
