// The worker: it owns the socket and the canvases, so that pixels never meet the thread that types.

import { backoff } from "../core/backoff.js";
import { PartBands } from "../core/part_bands.js";
import { FrameKind, decodeFrame, encodeChunk, type PixelFrame } from "../core/pixel_frame.js";
import { SUBPROTOCOL } from "../core/protocol.js";
import { LOOK_MS, Silence } from "../core/silence.js";
import { HeldReports } from "./held_reports.js";
import { Pane } from "./pane.js";
import type { FromWorker, Layer, ToWorker } from "./messages.js";

interface Scope {
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
}
const scope = self as unknown as Scope;

/** How long a program may take to accept a connection. */
const PATIENCE_MS = 2500;
const CLOSED_SILENTLY = 1006;

let url = "";
let socket: WebSocket | undefined;
let failures = 0;
let retry: ReturnType<typeof setTimeout> | undefined;
let listening: ReturnType<typeof setInterval> | undefined;
const silence = new Silence();
const panes = new Map<number, Pane>();
/** What lies over the panes, by layer and pane. */
const overlays = new Map<string, Pane>();
/** Frames are painted one after another: inflating takes turns of its own. */
let painting: Promise<void> = Promise.resolve();
/** Part pictures that are not whole yet, by pane. */
const partBands = new Map<number, PartBands>();

function pane(number: number): Pane {
  let found = panes.get(number);
  if (!found) panes.set(number, (found = new Pane(number, (painted) => scope.postMessage({ kind: "painted", painted }))));
  return found;
}

function layerOf(number: number, layer: Layer): Pane {
  if (layer === "rendered") return pane(number);
  const key = `${layer} ${number}`;
  let found = overlays.get(key);
  if (!found) overlays.set(key, (found = new Pane(number)));
  return found;
}

function connect(): void {
  if (retry !== undefined) clearTimeout(retry);
  retry = undefined;
  const opened = new WebSocket(url, SUBPROTOCOL);
  opened.binaryType = "arraybuffer";
  socket = opened;
  const impatience = setTimeout(() => opened.close(), PATIENCE_MS);
  opened.onopen = () => {
    clearTimeout(impatience);
    silence.begin();
    scope.postMessage({ kind: "open" });
  };
  opened.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
    if (socket !== opened) return;
    failures = 0;
    heard();
    if (typeof event.data === "string") pass(event.data);
    else receive(event.data);
  };
  opened.onclose = (event) => {
    clearTimeout(impatience);
    if (socket === opened) lost(event.code);
  };
}

const reports = new HeldReports();
let reportsDue: ReturnType<typeof setTimeout> | undefined;

function pass(text: string): void {
  if (!reports.holds(text, performance.now())) scope.postMessage({ kind: "message", text });
  else reportsDue ??= setTimeout(passReports, reports.due! - performance.now());
}

/** Passes on the reports that are due; edits may have put that off. */
function passReports(): void {
  reportsDue = undefined;
  const { due } = reports;
  const now = performance.now();
  if (due === undefined) return;
  if (due > now) reportsDue = setTimeout(passReports, due - now);
  else for (const text of reports.take()) scope.postMessage({ kind: "message", text });
}

function heard(): void {
  silence.heard();
  listening ??= setInterval(() => {
    if (!silence.look()) return;
    // Its end of the connection may never close.
    socket?.close();
    lost(CLOSED_SILENTLY);
  }, LOOK_MS);
}

function lost(code: number): void {
  socket = undefined;
  reports.take();
  clearInterval(listening);
  listening = undefined;
  const seconds = backoff(failures++);
  scope.postMessage({ kind: "lost", code, retryIn: seconds });
  retry = setTimeout(connect, seconds * 1000);
}

function receive(bytes: ArrayBuffer): void {
  painting = painting.then(async () => {
    const frame = decodeFrame(bytes);
    try {
      if (frame) await paint(frame);
    } catch {
      // A body that does not inflate is as good as none: the next whole picture repairs it.
    }
  });
}

async function paint(frame: PixelFrame): Promise<void> {
  if (frame.kind === FrameKind.Chunk) {
    const bytes = frame.body;
    scope.postMessage({ kind: "chunk", number: frame.serial, isLast: frame.endsPass, bytes }, [bytes.buffer]);
    return;
  }
  if (frame.kind === FrameKind.Pinned || frame.kind === FrameKind.Difference) {
    const overlay = layerOf(frame.pane, frame.kind === FrameKind.Pinned ? "pinned" : "difference");
    overlay.paint(frame, frame.deflated ? await inflate(frame.body) : frame.body);
    return;
  }
  const target = pane(frame.pane);
  if (frame.kind === FrameKind.Tile || frame.kind === FrameKind.Whole) {
    if (!target.picture.wants(frame.serial)) return;
    target.paint(frame, frame.deflated ? await inflate(frame.body) : frame.body);
  } else if (frame.kind === FrameKind.Parts) {
    const rows = frame.deflated ? await inflate(frame.body) : frame.body;
    partBands.set(frame.pane, (partBands.get(frame.pane) ?? new PartBands()).add(frame, rows));
    if (!frame.endsPass) return;
    const { serial, width, height, parts } = partBands.get(frame.pane)!;
    partBands.delete(frame.pane);
    scope.postMessage({ kind: "parts", pane: frame.pane, serial, width, height, parts }, [parts.buffer]);
  }
}

async function inflate(body: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const stream = new Blob([body]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function send(text: string): void {
  reports.sent(text, performance.now());
  if (socket?.readyState === WebSocket.OPEN) socket.send(text);
}

scope.onmessage = ({ data }) => {
  switch (data.kind) {
    case "connect":
      url = data.url;
      connect();
      break;
    case "retry":
      if (retry !== undefined) connect();
      break;
    case "send":
      send(data.text);
      break;
    case "put":
      if (socket?.readyState === WebSocket.OPEN) socket.send(encodeChunk(data.number, data.isLast, data.bytes));
      break;
    case "canvas":
      layerOf(data.pane, data.layer).attach(data.canvas);
      break;
    case "size":
      pane(data.pane).size = [data.width, data.height];
      break;
    case "restart":
      for (const each of [...panes.values(), ...overlays.values()]) each.picture.restart();
      break;
    case "pixels": {
      const { picture } = pane(data.pane);
      const pixels = picture.pixels.slice();
      scope.postMessage(
        { kind: "pixels", request: data.request, width: picture.width, height: picture.height, pixels },
        [pixels.buffer],
      );
      break;
    }
  }
};
