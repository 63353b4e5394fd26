/** Gives the focus to the first field within that has a wrong value, and returns what is wrong with it;
    undefined where none has. */
export function goToWrongField(within: ParentNode): string | undefined {
  const field = within.querySelector<HTMLElement>('[aria-invalid="true"]');
  if (!field) return undefined;
  field.focus();
  const why = document.getElementById(field.getAttribute("aria-describedby") ?? "")?.textContent;
  return `${field.closest("label")?.firstElementChild?.textContent}: ${why}`;
}
