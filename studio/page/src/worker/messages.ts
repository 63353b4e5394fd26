// Between the thread that types and the worker, which has the socket and the canvases.

export interface Painted {
  pane: number;
  serial: number;
  version: number;
  scale: number;
  samples: number;
  width: number;
  height: number;
  endsPass: boolean;
  complete: boolean;
}

/** A pane's picture, or what lies over it to be compared. */
export type Layer = "rendered" | "pinned" | "difference";

export type ToWorker =
  | { kind: "connect"; url: string }
  | { kind: "send"; text: string }
  | { kind: "canvas"; pane: number; layer: Layer; canvas: OffscreenCanvas }
  | { kind: "size"; pane: number; width: number; height: number }
  | { kind: "restart" }
  | { kind: "retry" }
  | { kind: "put"; number: number; isLast: boolean; bytes: ArrayBuffer }
  | { kind: "pixels"; request: number; pane: number };

export type FromWorker =
  | { kind: "open" }
  | { kind: "lost"; code: number; retryIn: number }
  | { kind: "message"; text: string }
  | { kind: "painted"; painted: Painted }
  | { kind: "pixels"; request: number; width: number; height: number; pixels: Uint8ClampedArray<ArrayBuffer> }
  | { kind: "parts"; pane: number; serial: number; width: number; height: number; parts: Uint32Array }
  | { kind: "chunk"; number: number; isLast: boolean; bytes: Uint8Array<ArrayBuffer> };
