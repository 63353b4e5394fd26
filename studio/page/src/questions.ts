// Questions about a text whose answers are waited for.

import type { EntityId, FreeCamera, ToPage, ToProgram } from "./core/protocol.js";
import * as documents from "./documents.js";
import * as program from "./program.js";

interface Answers {
  complete: ToPage["completions"];
  hover: ToPage["hovered"];
  placement: ToPage["placement"];
  camera_text: ToPage["camera_text"];
}

/** What a question is about. */
interface Abouts {
  complete: { offset: number };
  hover: { offset: number };
  placement: { entity?: EntityId };
  camera_text: { camera: FreeCamera; aspect: number; text: string };
}

const PATIENCE_MS = 2000;
const waiting = new Map<number, (answer: unknown) => void>();

/** Sends what was typed, so that a question is of the text that is seen. Returns false where that cannot be done. */
async function sendAll(document: documents.OpenDocument): Promise<boolean> {
  for (const begin = Date.now(); Date.now() < begin + PATIENCE_MS; await new Promise((resolve) => setTimeout(resolve, 10))) {
    documents.flush();
    if (!document.sync.hasPending) return true;
  }
  return false;
}

/** The answer about something of a file's text, nothing where none comes. */
export async function ask<K extends keyof Answers>(kind: K, file: string, about: Abouts[K]): Promise<Answers[K] | undefined> {
  const document = documents.find(file);
  if (!document || !(await sendAll(document))) return undefined;
  const number = program.newNumber();
  const body = { file, base: document.sync.sentVersion, ...about, number } as ToProgram[K];
  if (!program.send(kind, body)) return undefined;
  return new Promise((resolve) => {
    const done = (answer: unknown) => {
      waiting.delete(number);
      resolve(answer as Answers[K] | undefined);
    };
    waiting.set(number, done);
    setTimeout(done, PATIENCE_MS);
  });
}

export function answer(message: { number: number }): void {
  waiting.get(message.number)?.(message);
}

/** Whether anyone waited for the answer that does not come. */
export function refuse(number: number): boolean {
  const done = waiting.get(number);
  done?.(undefined);
  return done !== undefined;
}
