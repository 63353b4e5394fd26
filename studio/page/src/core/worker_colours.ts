// By what workers are told from each other: a number, which is never another's, and one of a few colours.

/** Okabe and Ito's colours, which most people tell apart, on dark and light alike. */
export const WORKER_COLOURS = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#ffffff"] as const;

export interface WorkerMark {
  /** From 1, in the order in which the workers were met. */
  number: number;
  colour: string;
}

/** Gives each worker a mark that it keeps. */
export class WorkerMarks {
  private readonly marks = new Map<number, WorkerMark>();

  of(worker: number): WorkerMark {
    let mark = this.marks.get(worker);
    if (!mark) {
      const number = this.marks.size + 1;
      this.marks.set(worker, (mark = { number, colour: WORKER_COLOURS[(number - 1) % WORKER_COLOURS.length]! }));
    }
    return mark;
  }
}
