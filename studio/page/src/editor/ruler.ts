// A line at a column, drawn beneath the text.

import type { Extension } from "@codemirror/state";
import { EditorView, ViewPlugin, type ViewUpdate } from "@codemirror/view";

export function ruler(column: number): Extension {
  return ViewPlugin.fromClass(
    class {
      private readonly line = document.createElement("div");

      constructor(view: EditorView) {
        this.line.className = "ruler";
        this.line.setAttribute("aria-hidden", "true");
        view.scrollDOM.appendChild(this.line);
        this.place(view);
      }

      update(update: ViewUpdate): void {
        if (update.geometryChanged) this.place(update.view);
      }

      destroy(): void {
        this.line.remove();
      }

      private place(view: EditorView): void {
        view.requestMeasure({
          key: this,
          read: () => ({
            left: view.contentDOM.offsetLeft + 6 + column * view.defaultCharacterWidth,
            height: view.contentDOM.offsetHeight,
          }),
          write: ({ left, height }) => {
            this.line.style.left = `${left}px`;
            this.line.style.height = `${height}px`;
          },
        });
      }
    },
  );
}
