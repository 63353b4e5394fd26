import { useLayoutEffect, useRef } from "preact/hooks";

/** Shows an element that outlives the panel, as the editor and the canvas do. */
export function Adopt({ element }: { element: HTMLElement }) {
  const host = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    host.current!.appendChild(element);
  }, [element]);
  return <div class="adopted" ref={host} />;
}
