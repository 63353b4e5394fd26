/** Seconds until the next try to connect, after so many that failed. */
const SECONDS = [0.25, 0.5, 1, 2, 4, 5];

export function backoff(failures: number): number {
  return SECONDS[Math.min(failures, SECONDS.length - 1)]!;
}
