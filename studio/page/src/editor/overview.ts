// The strip beside the scroll bar: where problems and other occurrences of the selected word stand.

import { forEachDiagnostic, setDiagnosticsEffect } from "@codemirror/lint";
import { SearchCursor } from "@codemirror/search";
import type { Extension } from "@codemirror/state";
import { EditorView, ViewPlugin, type ViewUpdate } from "@codemirror/view";

const MOST_OCCURRENCES = 200;
const LARGEST_TEXT = 300_000;

export function overview(): Extension {
  return ViewPlugin.fromClass(
    class {
      private readonly strip = document.createElement("div");
      private due: ReturnType<typeof setTimeout> | undefined;

      constructor(private readonly view: EditorView) {
        this.strip.className = "overview";
        this.strip.setAttribute("aria-hidden", "true");
        view.dom.appendChild(this.strip);
        this.later();
      }

      update(update: ViewUpdate): void {
        const marked = update.transactions.some((each) => each.effects.some((effect) => effect.is(setDiagnosticsEffect)));
        if (update.docChanged || update.selectionSet || marked) this.later();
      }

      destroy(): void {
        clearTimeout(this.due);
        this.strip.remove();
      }

      private later(): void {
        clearTimeout(this.due);
        this.due = setTimeout(() => this.draw(), 200);
      }

      private draw(): void {
        const { state } = this.view;
        const marks: HTMLElement[] = [];
        const mark = (position: number, kind: string) => {
          const element = document.createElement("i");
          element.className = kind;
          element.style.top = `${((state.doc.lineAt(position).number - 0.5) / state.doc.lines) * 100}%`;
          marks.push(element);
        };
        for (const position of occurrences(this.view)) mark(position, "occurrence");
        forEachDiagnostic(state, (diagnostic, from) => mark(from, diagnostic.severity));
        this.strip.replaceChildren(...marks);
      }
    },
  );
}

function occurrences(view: EditorView): number[] {
  const { main } = view.state.selection;
  if (main.empty || main.to - main.from > 100 || view.state.doc.length > LARGEST_TEXT) return [];
  const word = view.state.sliceDoc(main.from, main.to);
  if (!/^[\w.]+$/.test(word)) return [];
  const found: number[] = [];
  const cursor = new SearchCursor(view.state.doc, word);
  while (found.length < MOST_OCCURRENCES && !cursor.next().done) found.push(cursor.value.from);
  return found;
}
