// Pictures that the program makes for panes that nobody sees, one after another.

import type { JobReport, ViewWish } from "../core/protocol.js";
import * as program from "../program.js";
import type { Painted } from "../worker/messages.js";

/** Asks for one picture at a time; `What` tells the caller which one it is. */
export class HiddenPane<What> {
  private current: { what: What; wish: Omit<ViewWish, "pane">; revision: number; done?: JobReport; painted?: number } | undefined;

  /** `settle` is called with each picture that was asked for and the digest of its scene; with null where the program
      could make none, and with nothing where the one that is known is still right. */
  constructor(
    private readonly number: number,
    private readonly settle: (what: What, image: ImageData | null | undefined, digest?: string) => void,
  ) {}

  /** What is asked for and has not come yet. */
  get asked(): What | undefined {
    return this.current?.what;
  }

  /** `revision`: of the texts, at least, that what is known is held against. Returns false where there is no connection. */
  ask(what: What, wish: Omit<ViewWish, "pane">, revision = 0): boolean {
    program.toWorker({ kind: "size", pane: this.number, width: wish.size[0], height: wish.size[1] });
    if (!program.send("view", { ...wish, pane: this.number })) return false;
    this.current = { what, wish, revision };
    return true;
  }

  /** Whatever comes of what was asked for is not waited for any more. */
  forget(): void {
    this.current = undefined;
  }

  noteJob(job: JobReport): void {
    const { current } = this;
    if (job.pane !== this.number || job.file !== current?.wish.file) return;
    if (job.state === "failed" || job.stale) this.finish(null);
    else if (job.unchanged) {
      // Not of what was asked for before.
      const isMeant = job.frame === current.wish.frame && job.digest === current.wish.known && (job.revision ?? 0) >= current.revision;
      if (isMeant) this.finish(undefined);
    } else if (job.state === "done" && job.serial !== undefined) {
      current.done = job;
      this.take();
    }
  }

  notePainted(painted: Painted): void {
    if (painted.pane !== this.number || !this.current || !painted.endsPass) return;
    this.current.painted = painted.serial;
    this.take();
  }

  /** Once the last pass is told to be done and its pixels are there. */
  private take(): void {
    const { current } = this;
    if (current?.done === undefined || current.done.serial !== current.painted) return;
    const { digest } = current.done;
    void program.pixels(this.number).then((image) => {
      if (this.current === current) this.finish(image, digest);
    });
  }

  private finish(image: ImageData | null | undefined, digest?: string): void {
    const { what } = this.current!;
    this.current = undefined;
    this.settle(what, image, digest);
  }
}
