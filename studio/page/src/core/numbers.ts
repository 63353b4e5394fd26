// Numbers as they are typed into fields: what is one, what is not and why, and arithmetic.

export interface NumberRules {
  whole?: boolean;
  /** Both ends are allowed, unless `open`. */
  range?: [number, number];
  /** Whether the ends of the range are left out, both or each. */
  open?: boolean | [boolean, boolean];
  unit?: string;
  /** What else is expected of a number, in words; nothing where it is as it should be. Holds for numbers that are typed. */
  also?: (value: number) => string | undefined;
}

export type Checked = { ok: true; value: number } | { ok: false; found: string; expected: string };

const LITERAL = /^[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?$/;

function opennessOf({ open = false }: NumberRules): [boolean, boolean] {
  return typeof open === "boolean" ? [open, open] : open;
}

/** What a number of these rules is, in words. */
export function expectedOf(rules: NumberRules): string {
  const what = rules.whole ? "a whole number" : "a number";
  if (!rules.range) return rules.whole ? what : `${what} as 1.5`;
  const [least, most] = rules.range;
  const [above, below] = opennessOf(rules);
  if (least === -Infinity) return `${what} ${below ? "below" : "of at most"} ${most}`;
  if (most === Infinity) return `${what} ${above ? "above" : "of at least"} ${least}`;
  if (above !== below) return `${what} ${above ? "above" : "of at least"} ${least} and ${below ? "below" : "of at most"} ${most}`;
  return above ? `${what} between ${least} and ${most}, both left out` : `${what} from ${least} to ${most}`;
}

/** The range of these rules, as the row of a field says it; empty where it has no end. */
export function rangeWords(rules: NumberRules): string {
  const [least, most] = rules.range ?? [-Infinity, Infinity];
  const [above, below] = opennessOf(rules);
  if (least !== -Infinity && most !== Infinity && !above && !below) return `${least} to ${most}`;
  return [least === -Infinity ? "" : `${above ? "above" : "at least"} ${least}`, most === Infinity ? "" : `${below ? "below" : "at most"} ${most}`].filter(Boolean).join(", ");
}

/** Whether the text is a number of these rules; not even spaces are passed over silently. */
export function checkNumber(text: string, rules: NumberRules = {}): Checked {
  const trimmed = text.trim();
  const expected = expectedOf(rules);
  const wrong = (found: string): Checked => ({ ok: false, found, expected });
  if (trimmed === "") return wrong("nothing");
  if (!LITERAL.test(trimmed)) return wrong(describe(trimmed));
  const value = Number(trimmed);
  if (!Number.isFinite(value)) return wrong(`${trimmed}, which is too large`);
  if (rules.whole && !/^[+-]?\d+$/.test(trimmed)) return wrong(trimmed);
  if (rules.range) {
    const [least, most] = rules.range;
    const [above, below] = opennessOf(rules);
    if (above ? value <= least : value < least) return wrong(trimmed);
    if (below ? value >= most : value > most) return wrong(trimmed);
  }
  const other = rules.also?.(value);
  if (other !== undefined) return { ok: false, found: trimmed, expected: other };
  return { ok: true, value };
}

function describe(text: string): string {
  if (/^[+-]?(?:nan|inf|infinity)$/i.test(text)) return `${text}, which is no finite number`;
  if (/^[+-]?\d+,\d+$/.test(text)) return `“${text}”; the decimal sign is a point`;
  if (/[;,]/.test(text)) return `“${text}”, which is more than one number`;
  return `“${text}”`;
}

/** The value of an expression of numbers, `+ - * / ( )` and `pi`; nothing where it is none. */
export function evaluate(text: string): number | undefined {
  const tokens = text.match(/\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|pi|[-+*/()]|\S/g) ?? [];
  let next = 0;
  const value = sum();
  return next === tokens.length && tokens.length > 0 && Number.isFinite(value) ? value : undefined;

  function sum(): number {
    let result = product();
    while (tokens[next] === "+" || tokens[next] === "-") {
      result = tokens[next++] === "+" ? result + product() : result - product();
    }
    return result;
  }
  function product(): number {
    let result = factor();
    while (tokens[next] === "*" || tokens[next] === "/") {
      result = tokens[next++] === "*" ? result * factor() : result / factor();
    }
    return result;
  }
  function factor(): number {
    const token = tokens[next++];
    if (token === "-") return -factor();
    if (token === "+") return factor();
    if (token === "pi") return Math.PI;
    if (token === "(") {
      const inner = sum();
      return tokens[next++] === ")" ? inner : NaN;
    }
    return token !== undefined && LITERAL.test(token) ? Number(token) : NaN;
  }
}

/** The shortest text of a number that is as exact as fields need; `like` tells whether it stays a float. */
export function written(value: number, like = ""): string {
  const rounded = Number(value.toPrecision(9));
  const text = String(Object.is(rounded, -0) ? 0 : rounded);
  return /[.]/.test(like) && /^-?\d+$/.test(text) ? `${text}.0` : text;
}

/** What dragging by so many pixels makes of a value: 1 % a pixel, at least .001; Ctrl in steps of .1, Shift a tenth. */
export function dragged(start: number, pixels: number, keys: { ctrl: boolean; shift: boolean }): number {
  const step = Math.max(0.001, Math.abs(start) * 0.01) * (keys.shift ? 0.1 : 1);
  const value = start + pixels * step;
  return keys.ctrl ? Math.round(value * 10) / 10 : value;
}

/** What a key does to a value: Up and Down .01, PageUp and PageDown 1; whole numbers go by 1 and 10. */
export function stepped(value: number, key: string, whole = false): number | undefined {
  const steps: Record<string, number> = { ArrowUp: 0.01, ArrowDown: -0.01, PageUp: 1, PageDown: -1 };
  if (!Object.hasOwn(steps, key)) return undefined;
  const step = steps[key]!;
  if (whole) return value + Math.sign(step) * (Math.abs(step) === 1 ? 10 : 1);
  return Number((value + step).toFixed(10));
}
