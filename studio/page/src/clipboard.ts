// Text for other programs.

import * as state from "./state.js";

/** Puts the picture into the clipboard, and says `told` or why it cannot. */
export async function copyCanvas(canvas: HTMLCanvasElement, told: string): Promise<void> {
  try {
    const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, "image/png"));
    if (!blob) throw new Error("no picture");
    await navigator.clipboard.write([new ClipboardItem({ "image/png": blob })]);
    state.notify(told);
  } catch {
    state.notify("The browser does not let this page use the clipboard.", "error");
  }
}

/** Puts the text into the clipboard, and says so or why it cannot. */
export async function copyText(text: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    state.notify(`In the clipboard: ${text}`);
  } catch {
    state.notify("The browser does not let this page use the clipboard.", "error");
  }
}
