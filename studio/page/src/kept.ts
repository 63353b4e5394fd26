// What the program keeps of the page from one start to the next.

import { effect } from "@preact/signals";
import type { ToProgram } from "./core/protocol.js";
import * as program from "./program.js";
import * as state from "./state.js";

const KEEP_MS = 1000;

/** One object that the program keeps. */
export class Kept<K extends "settings" | "workspace"> {
  private kept: string | undefined;
  private due: ReturnType<typeof setTimeout> | undefined;

  /** `current` tells it from signals; nothing while it is not to be kept. */
  constructor(
    private readonly kind: K,
    private readonly current: () => ToProgram[K] | undefined,
  ) {}

  /** What there is now is what the program has; changes are kept from now on. */
  begin(): void {
    this.kept = JSON.stringify(this.current()) ?? "";
  }

  /** Has the program keep what changed, a while after the first change, and before the page goes. */
  watch(): void {
    effect(() => {
      // What may have been lost with the connection is sent once the program is there again.
      if (state.connection.value === "lost" && this.kept !== undefined) this.kept = "";
      if (this.news() !== undefined) this.due ??= setTimeout(() => this.send(), KEEP_MS);
    });
    window.addEventListener("beforeunload", () => this.send());
    document.addEventListener("visibilitychange", () => this.send());
  }

  private send(): void {
    clearTimeout(this.due);
    this.due = undefined;
    const text = this.news();
    if (text !== undefined && program.send(this.kind, JSON.parse(text) as ToProgram[K])) this.kept = text;
  }

  /** What the program is to keep, where it is not what it has. */
  private news(): string | undefined {
    const text = JSON.stringify(this.current());
    return this.kept === undefined || text === this.kept || state.welcome.peek()?.read_only ? undefined : text;
  }
}
