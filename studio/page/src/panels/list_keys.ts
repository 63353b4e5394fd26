/** Moves the focus among the options of a list, or the items of a tree, by keys. */
export function listKey(event: KeyboardEvent): boolean {
  const list = event.currentTarget as HTMLElement;
  const items = [...list.querySelectorAll<HTMLElement>('[role="option"], [role="treeitem"]')];
  const index = items.indexOf(document.activeElement as HTMLElement);
  const page = Math.max(1, Math.floor(list.clientHeight / (items[0]?.offsetHeight || 24)) - 1);
  const targets: Record<string, number> = {
    ArrowDown: index + 1,
    ArrowUp: index - 1,
    Home: 0,
    End: items.length - 1,
    PageDown: index + page,
    PageUp: index - page,
  };
  if (!Object.hasOwn(targets, event.key)) return false;
  items[Math.min(items.length - 1, Math.max(0, targets[event.key]!))]?.focus();
  event.preventDefault();
  return true;
}
