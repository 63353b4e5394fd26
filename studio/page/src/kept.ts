// What the program keeps of the page from one start to the next.

import { effect } from "@preact/signals";
import type { ToProgram } from "./core/protocol.js";
import * as program from "./program.js";
import * as state from "./state.js";

const KEEP_MS = 1000;

/** One object that the program keeps. */
export class Kept<K extends "settings" | "workspace"> {
  private kept: string | undefined;

  /** `current` tells it from signals; nothing while it is not to be kept. */
  constructor(
    private readonly kind: K,
    private readonly current: () => ToProgram[K] | undefined,
  ) {}

  /** What there is now is what the program has; changes are kept from now on. */
  begin(): void {
    this.kept = JSON.stringify(this.current()) ?? "";
  }

  /** Has the program keep what changed, a while after the last change. */
  watch(): void {
    let due: ReturnType<typeof setTimeout> | undefined;
    effect(() => {
      const text = JSON.stringify(this.current());
      clearTimeout(due);
      if (this.kept === undefined || text === undefined || text === this.kept || state.welcome.peek()?.read_only) return;
      due = setTimeout(() => {
        if (program.send(this.kind, JSON.parse(text) as ToProgram[K])) this.kept = text;
      }, KEEP_MS);
    });
  }
}
