// The way to the program: through the worker that owns the socket.

import { encode, decode, type ProgramKind, type ToPage, type ToProgram } from "./core/protocol.js";
import type { FromWorker, Painted, ToWorker } from "./worker/messages.js";
import * as downloads from "./downloads.js";
import * as state from "./state.js";
import * as uploads from "./uploads.js";

type Handlers = { [K in keyof ToPage]?: (body: ToPage[K]) => void };

const TOKEN_KEY = "tessera-studio-token";
const CLOSED_UNAUTHORISED = 4401;

let worker: Worker | undefined;
let handlers: Handlers = {};
let greeting: () => Omit<ToProgram["hello"], "token"> = () => ({});
let onPainted: (painted: Painted) => void = () => {};
let onParts: (parts: Extract<FromWorker, { kind: "parts" }>) => void = () => {};
let greeted = false;
let lastNumber = 0;
const pixelRequests = new Map<number, (image: ImageData) => void>();

/** Takes the token off the address bar, where it would be seen and kept in the history. */
export function takeToken(): void {
  const found = /(?:^#|&)token=([^&]+)/.exec(location.hash);
  if (!found) return;
  history.replaceState(null, "", location.pathname + location.search);
  setToken(decodeURIComponent(found[1]!));
}

export function setToken(token: string): void {
  sessionStorage.setItem(TOKEN_KEY, token.trim());
  if (isConnected()) return;
  state.connection.value = "connecting";
  toWorker({ kind: "retry" });
}

export interface ProgramEvents {
  handlers: Handlers;
  greeting: typeof greeting;
  painted: typeof onPainted;
  parts: typeof onParts;
}

export function connect(events: ProgramEvents): void {
  handlers = events.handlers;
  greeting = events.greeting;
  onPainted = events.painted;
  onParts = events.parts;
  worker = new Worker("worker.js", { name: "studio" });
  worker.onmessage = (event: MessageEvent<FromWorker>) => receive(event.data);
  // Beside the page, which a proxy may serve below a path; ws for http, wss for https.
  toWorker({ kind: "connect", url: new URL("studio", location.href.split("#")[0]).href.replace(/^http/, "ws") });
}

/** Sends a message; what is said while nobody listens is not kept. */
export function send<K extends ProgramKind>(kind: K, body: ToProgram[K]): boolean {
  if (!isConnected()) return false;
  toWorker({ kind: "send", text: encode(kind, body) });
  return true;
}

export function isConnected(): boolean {
  return greeted;
}

export function retryNow(): void {
  toWorker({ kind: "retry" });
}

export function toWorker(message: ToWorker, transfer: Transferable[] = []): void {
  worker?.postMessage(message, transfer);
}

/** By which an answer is known, whatever it was that was asked. */
export function newNumber(): number {
  return ++lastNumber;
}

/** The picture that a pane shows. */
export function pixels(pane = 0): Promise<ImageData> {
  const request = newNumber();
  return new Promise((resolve) => {
    pixelRequests.set(request, resolve);
    toWorker({ kind: "pixels", request, pane });
  });
}

function receive(message: FromWorker): void {
  switch (message.kind) {
    case "open": {
      const token = sessionStorage.getItem(TOKEN_KEY) ?? "";
      toWorker({ kind: "send", text: encode("hello", { token, ...greeting() }) });
      break;
    }
    case "lost":
      greeted = false;
      downloads.forgetAll();
      uploads.forgetAll();
      if (message.code === CLOSED_UNAUTHORISED) {
        state.connection.value = "refused";
        state.connectionWords.value = "The program does not know this page's token.";
        state.dialog.value = "token";
      } else {
        state.connection.value = "lost";
        state.connectionWords.value = "No connection to the program; editing goes on.";
      }
      break;
    case "message":
      dispatch(message.text);
      break;
    case "painted":
      onPainted(message.painted);
      break;
    case "parts":
      onParts(message);
      break;
    case "chunk":
      downloads.chunkCame(message.number, message.bytes, message.isLast);
      break;
    case "pixels":
      // Before anything is painted, one pixel of nothing.
      pixelRequests.get(message.request)?.(
        message.width > 0 ? new ImageData(message.pixels, message.width, message.height) : new ImageData(1, 1),
      );
      pixelRequests.delete(message.request);
      break;
  }
}

function dispatch(text: string): void {
  const message = decode(text);
  if (!message) return;
  if (message.kind === "welcome") {
    greeted = true;
    state.connection.value = "open";
    state.connectionWords.value = "";
    if (state.dialog.value === "token") state.dialog.value = undefined;
  }
  const handler = Object.hasOwn(handlers, message.kind) ? handlers[message.kind as keyof ToPage] : undefined;
  (handler as ((body: unknown) => void) | undefined)?.(message.body);
}
