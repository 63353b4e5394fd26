// When a connection that brings nothing counts as lost. Its silence is counted in looks, not by the clock: what came
// while the worker was busy, or its timers were held back, is heard before the next look.

export const LOOK_MS = 250;
const LEAST = 12;
const LONGEST = 96;
/** A program that welcomed the page tells it something each second. */
const IN_GOOD_TIME = 8;

export class Silence {
  /** A slow line is silent while a large message comes: each loss by silence doubles it, until the program was heard in
      good time for as long as its silence would have counted as a loss. */
  private most = LEAST;
  private silent = 0;
  private steady = 0;

  /** To be called when a connection begins. */
  begin(): void {
    this.silent = this.steady = 0;
  }

  /** To be called for whatever comes. */
  heard(): void {
    this.steady = this.silent > IN_GOOD_TIME ? 0 : this.steady + this.silent;
    this.silent = 0;
    if (this.steady >= LEAST) this.most = LEAST;
  }

  /** To be called each LOOK_MS. Returns whether the connection counts as lost. */
  look(): boolean {
    if (++this.silent < this.most) return false;
    this.most = Math.min(LONGEST, 2 * this.most);
    return true;
  }
}
