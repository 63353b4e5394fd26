// Reports of a whole text, which the page takes long to show: in a burst of edits it gets the last of each alone.

import { decode } from "../core/protocol.js";

/** Edits of one burst follow each other within this time; reports wait until as long after the last. */
export const BURST_MS = 400;
/** A burst may go on; reports do not wait longer than this. */
export const LONGEST_WAIT_MS = 1000;

const KINDS = ["outline", "centers"];

export class HeldReports {
  private lastEdit = -Infinity;
  private isBurst = false;
  private since = 0;
  private readonly held = new Map<string, string>();

  /** To be called for each message that the page sends. */
  sent(text: string, now: number): void {
    if (!text.startsWith('{"edit"')) return;
    this.isBurst = now - this.lastEdit < BURST_MS;
    this.lastEdit = now;
  }

  /** Whether a message of the program waits here; one about the same file is dropped for it. */
  holds(text: string, now: number): boolean {
    const isDuring = this.isBurst && now - this.lastEdit < BURST_MS;
    const kind = KINDS.find((each) => text.startsWith(`{"${each}"`));
    if (kind === undefined || (!isDuring && this.held.size === 0)) return false;
    const key = `${kind} ${(decode(text)?.body as { file?: string } | undefined)?.file}`;
    if (this.held.size === 0) this.since = now;
    // What comes after the burst is newer than what waits of it.
    this.held.delete(key);
    if (!isDuring) return false;
    this.held.set(key, text);
    return true;
  }

  /** When what is held is due; nothing where nothing is. */
  get due(): number | undefined {
    return this.held.size > 0 ? Math.min(this.lastEdit + BURST_MS, this.since + LONGEST_WAIT_MS) : undefined;
  }

  /** Takes what is held, in the order in which it came. */
  take(): string[] {
    const texts = [...this.held.values()];
    this.held.clear();
    return texts;
  }
}
