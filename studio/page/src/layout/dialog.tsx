import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";

interface DialogProps {
  title: string;
  close: () => void;
  /** Hears that it is closed, with the focus back where it was. */
  closed?: () => void;
  children: ComponentChildren;
  wide?: boolean;
}

/** A dialog in front of everything; Escape closes it and changes nothing. */
export function Dialog({ title, close, closed, children, wide }: DialogProps) {
  const element = useRef<HTMLDialogElement>(null);
  useLayoutEffect(() => {
    const before = document.activeElement as HTMLElement | null;
    const dialog = element.current!;
    dialog.showModal();
    return () => {
      // While it is open, nothing else takes the focus.
      dialog.close();
      before?.focus?.();
      closed?.();
    };
  }, []);
  return (
    <dialog
      ref={element}
      class={wide ? "wide" : ""}
      aria-label={title}
      onCancel={(event) => {
        event.preventDefault();
        close();
      }}
    >
      <header>
        <h2>{title}</h2>
        <button type="button" class="close" aria-label="Close the dialog" onClick={close}>×</button>
      </header>
      {children}
    </dialog>
  );
}
