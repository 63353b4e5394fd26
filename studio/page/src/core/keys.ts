// Keys by name, "Ctrl-Shift-S", as commands have them.

export interface KeyPress {
  key: string;
  code?: string;
  ctrlKey: boolean;
  altKey: boolean;
  shiftKey: boolean;
  metaKey: boolean;
}

const NAMES: Record<string, string> = { " ": "Space", Esc: "Escape", ArrowUp: "Up", ArrowDown: "Down", ArrowLeft: "Left", ArrowRight: "Right" };

/** The name of what is pressed; keys that change others have none of their own. */
export function nameOfKey(event: KeyPress): string | undefined {
  if (["Control", "Alt", "Shift", "Meta", "AltGraph"].includes(event.key)) return undefined;
  const parts = [];
  if (event.ctrlKey || event.metaKey) parts.push("Ctrl");
  if (event.altKey) parts.push("Alt");
  let key = NAMES[event.key] ?? event.key;
  // Alt makes other signs of letters on some keyboards.
  if (event.altKey && event.code && /^Key[A-Z]$/.test(event.code)) key = event.code.slice(3);
  if (key.length === 1) {
    const isLetter = key.toLowerCase() !== key.toUpperCase();
    if (event.shiftKey && (isLetter || event.ctrlKey || event.altKey)) parts.push("Shift");
    key = key.toUpperCase();
  } else if (event.shiftKey) parts.push("Shift");
  return [...parts, key].join("-");
}

/** Keys that browsers have for themselves, whatever a page does. */
const OF_BROWSERS = [
  "Ctrl-N", "Ctrl-T", "Ctrl-W", "Ctrl-Q", "Ctrl-Shift-N", "Ctrl-Shift-P", "Ctrl-Shift-T", "Ctrl-Shift-W", "Ctrl-Shift-Q",
  "Ctrl-Tab", "Ctrl-Shift-Tab", "Ctrl-PageUp", "Ctrl-PageDown", "Ctrl-F4", "Alt-F4",
];
/** Keys that every text has for itself. */
const OF_TEXTS = ["Ctrl-A", "Ctrl-C", "Ctrl-V", "Ctrl-X", "Ctrl-Shift-V"];

interface KeyedCommand {
  name: string;
  keys: readonly string[];
  /** Keys that it has while the picture has the focus. */
  inView?: readonly string[];
}

/** Why a key cannot be the command's, in words; nothing where it can. Commands of the view take keys without Ctrl and Alt, too. */
export function whyNotKey(key: string, command: string, commands: readonly KeyedCommand[]): string | undefined {
  const isOfView = commands.some((each) => each.name === command && each.inView !== undefined);
  const expected = isOfView ? "expected another one" : "expected another one with Ctrl or Alt, or one of F1 to F12";
  if (OF_BROWSERS.includes(key)) return `found ${key}, which the browser keeps; ${expected}`;
  if (!isOfView && OF_TEXTS.includes(key)) return `found ${key}, which text fields have; ${expected}`;
  if (!isOfView && !/^(Ctrl-|Alt-|(Shift-)?F\d)/.test(key)) return `found ${key}, which types or moves; ${expected}`;
  const owner = commands.find((each) => each.name !== command && [...each.keys, ...(each.inView ?? [])].includes(key));
  return owner && `found ${key}, which the command “${owner.name}” has; ${expected}`;
}

/** The command with other keys: one of the view has them in the view. */
export function withKeys<T extends KeyedCommand>(command: T, keys: readonly string[]): T {
  return command.inView === undefined ? { ...command, keys } : { ...command, inView: keys };
}

/** The keys that were kept, of what may be anything. */
export function keptKeys(kept: unknown): Record<string, string[]> {
  if (typeof kept !== "object" || kept === null) return {};
  const isKeys = (keys: unknown) => Array.isArray(keys) && keys.every((each) => typeof each === "string");
  return Object.fromEntries(Object.entries(kept).filter(([, keys]) => isKeys(keys)));
}

/** Which command each key runs; of two commands with one key the first has it. */
export function keyMap(commands: readonly { name: string; keys: readonly string[] }[]): Map<string, string> {
  const map = new Map<string, string>();
  for (const { name, keys } of commands) {
    for (const key of keys) if (!map.has(key)) map.set(key, name);
  }
  return map;
}

/** The commands whose names have all the words that were typed, those that begin with them first. */
export function matching<T extends { name: string }>(commands: readonly T[], typed: string): T[] {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const found = commands.filter((each) => words.every((word) => each.name.toLowerCase().includes(word)));
  const starts = (each: T) => (words[0] && each.name.toLowerCase().startsWith(words[0]) ? 0 : 1);
  return found.sort((a, b) => starts(a) - starts(b));
}
