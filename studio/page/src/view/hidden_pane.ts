// Pictures that the program makes for panes that nobody sees, one after another.

import type { JobReport, ViewWish } from "../core/protocol.js";
import * as program from "../program.js";
import type { Painted } from "../worker/messages.js";

/** Asks for one picture at a time; `What` tells the caller which one it is. */
export class HiddenPane<What> {
  private current: { what: What; file: string; done?: number; painted?: number } | undefined;

  /** `settle` is called with each picture that was asked for, or null where the program could make none. */
  constructor(
    private readonly number: number,
    private readonly settle: (what: What, image: ImageData | null) => void,
  ) {}

  /** What is asked for and has not come yet. */
  get asked(): What | undefined {
    return this.current?.what;
  }

  /** Returns false where there is no connection. */
  ask(what: What, wish: Omit<ViewWish, "pane">): boolean {
    program.toWorker({ kind: "size", pane: this.number, width: wish.size[0], height: wish.size[1] });
    if (!program.send("view", { ...wish, pane: this.number })) return false;
    this.current = { what, file: wish.file };
    return true;
  }

  /** Whatever comes of what was asked for is not waited for any more. */
  forget(): void {
    this.current = undefined;
  }

  noteJob(job: JobReport): void {
    const { current } = this;
    if (job.pane !== this.number || job.file !== current?.file) return;
    if (job.state === "failed" || job.stale) this.finish(null);
    else if (job.state === "done") {
      current.done = job.serial;
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
    if (!current || current.done === undefined || current.done !== current.painted) return;
    void program.pixels(this.number).then((image) => {
      if (this.current === current) this.finish(image);
    });
  }

  private finish(image: ImageData | null): void {
    const { what } = this.current!;
    this.current = undefined;
    this.settle(what, image);
  }
}
