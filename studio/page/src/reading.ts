// Whether the program still reads what was edited, which is said when it takes long.

import { signal } from "@preact/signals";
import type { ToPage } from "./core/protocol.js";
import * as documents from "./documents.js";

const SAID_AFTER_MS = 300;

/** Whether an edit has waited so long to be read that it is said. */
export const isReading = signal(false);

/** The versions that were sent last and are not known to be read, by the names of their files. */
const unread = new Map<string, number>();
let due: ReturnType<typeof setTimeout> | undefined;

/** To be called for each edit that the program gets. */
export function editWasSent(file: string, version: number): void {
  unread.set(file, version);
  due ??= setTimeout(() => (isReading.value = true), SAID_AFTER_MS);
}

/** To be called for what the program tells of the scene once it was read, with all other texts that it had by then. */
export function sceneWasRead(scene: ToPage["problems"]): void {
  for (const [file, version] of unread) {
    const isRead = file === scene.file ? scene.version >= version : (documents.find(file)?.sync.acknowledgedVersion ?? version) >= version;
    if (isRead) unread.delete(file);
  }
  if (unread.size === 0) forgetEdits();
}

/** To be called when there is nobody who reads. */
export function forgetEdits(): void {
  unread.clear();
  clearTimeout(due);
  due = undefined;
  isReading.value = false;
}
