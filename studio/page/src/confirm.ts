// What is asked before something is done that can hardly be undone.

import { signal } from "@preact/signals";
import type { ToPage } from "./core/protocol.js";

export interface Question {
  title: string;
  words: string;
  /** The button that has it done; without one there is only something to know. */
  accept?: string;
  run: () => void;
  /** Hears that it is not to be done. */
  otherwise?: () => void;
}

export const question = signal<Question | undefined>(undefined);

/** Does it once it was agreed to replace those files; `otherwise` hears that it was not. */
export function askToReplace({ first, count }: NonNullable<ToPage["refused"]["existing"]>, run: () => void, otherwise: () => void): void {
  const words = count === 1 ? `${first} exists: replace it?` : `${count} of the files exist, ${first} first: replace them?`;
  question.value = { title: "Replace files", words, accept: "Replace", run, otherwise };
}
