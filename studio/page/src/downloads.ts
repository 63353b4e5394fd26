// Files that the program sends in chunks: the browser saves them, or the page shows them.

import * as looked from "./looked.js";
import * as state from "./state.js";

interface Download {
  name: string;
  isShown: boolean;
  chunks: BlobPart[];
}
const downloads = new Map<number, Download>();

/** The file of that number is about to come. */
export function expect(number: number, name: string, isShown: boolean): void {
  downloads.set(number, { name, isShown, chunks: [] });
}

export function chunkCame(number: number, bytes: Uint8Array<ArrayBuffer>, isLast: boolean): void {
  const download = downloads.get(number);
  if (!download) return;
  download.chunks.push(bytes);
  if (!isLast) return;
  downloads.delete(number);
  if (download.isShown) return void looked.came(new Blob(download.chunks, { type: "image/png" }));
  save(new Blob(download.chunks), download.name);
  state.notify(`Downloaded: ${download.name}`);
}

/** What was begun comes no more: the connection is another one. */
export function forgetAll(): void {
  downloads.clear();
  looked.failed();
}

function save(content: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name.replace(/^.*\//, "");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
