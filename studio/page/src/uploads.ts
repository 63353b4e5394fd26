// Files that the page sends in chunks: the next one once the program has the one before.

import type { ToPage } from "./core/protocol.js";
import * as program from "./program.js";
import * as state from "./state.js";

const CHUNK_BYTES = 2 ** 20;

interface Upload {
  file: File;
  done: (name: string | undefined) => void;
}
const uploads = new Map<number, Upload>();

/** Copies a file into the opened folder; the name that it got there, or nothing where it was refused. */
export function upload(file: File, folder: string): Promise<string | undefined> {
  const number = program.newNumber();
  return new Promise((done) => {
    if (!program.send("put", { name: folder + file.name, size: file.size, number })) {
      state.notify(`${file.name} is not copied: there is no connection to the program.`, "error");
      done(undefined);
    } else uploads.set(number, { file, done });
  });
}

/** The program has so many bytes. */
export async function putCame(message: ToPage["put"]): Promise<void> {
  const { number, received, whole, name } = message;
  const current = uploads.get(number);
  if (!current) return;
  if (whole) {
    uploads.delete(number);
    program.send("list", {});
    current.done(name);
    return;
  }
  try {
    const bytes = await current.file.slice(received, received + CHUNK_BYTES).arrayBuffer();
    const isLast = received + bytes.byteLength >= current.file.size;
    program.toWorker({ kind: "put", number, isLast, bytes }, [bytes]);
  } catch {
    failed(number, `${current.file.name} cannot be read.`);
  }
}

export function failed(number: number, why: string): void {
  const current = uploads.get(number);
  uploads.delete(number);
  state.notify(why, "error");
  current?.done(undefined);
}

/** What was begun is given up by the program when the connection ends. */
export function forgetAll(): void {
  for (const [number, { file }] of [...uploads]) failed(number, `${file.name} is not copied: the connection was lost.`);
}
