/** What a browser has, as far as tests use it: the worker with the socket, and where the page is from. */

/** What the page said to the program. */
export const said: Record<string, any>[] = [];
let worker: SocketWorker;

class SocketWorker {
  onmessage: ((event: { data: unknown }) => void) | undefined;
  constructor() {
    worker = this;
  }
  postMessage(message: { kind: string; text?: string }): void {
    if (message.kind === "send") said.push(JSON.parse(message.text!));
  }
}
Object.assign(globalThis, { Worker: SocketWorker, location: { href: "http://here/" } });

/** Has the page hear what the program says. */
export const hear = (message: object) => worker.onmessage!({ data: { kind: "message", text: JSON.stringify(message) } });
