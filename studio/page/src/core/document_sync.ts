// What the program has of a text, and what is under way to it. Every edit makes the next version, so that a key
// is neither lost nor doubled, whichever side goes away when.

import { type ChangeDesc, ChangeSet, Text } from "@codemirror/state";
import type { Change } from "./protocol.js";

/** So many versions before the acknowledged one are remembered. */
const MOST_PAST = 2000;

export class DocumentSync {
  /** The last version that the program is known to have. */
  private acknowledged: { version: number; text: Text };
  /** The versions right before that one, the newest last, and what was changed in each. */
  private past: { text: Text; changes: ChangeSet }[] = [];
  private sent: ChangeSet[] = [];
  private pending: ChangeSet | undefined;

  constructor(version: number, text: Text) {
    this.acknowledged = { version, text };
  }

  /** The version that the program has, or will have when all that was sent is there. */
  get sentVersion(): number {
    return this.acknowledged.version + this.sent.length;
  }

  /** The version of the text with all changes made. */
  get version(): number {
    return this.sentVersion + (this.pending ? 1 : 0);
  }

  get acknowledgedVersion(): number {
    return this.acknowledged.version;
  }

  get acknowledgedText(): Text {
    return this.acknowledged.text;
  }

  get hasPending(): boolean {
    return this.pending !== undefined;
  }

  get settled(): boolean {
    return !this.pending && this.sent.length === 0;
  }

  /** Notes a change of the text. */
  record(changes: ChangeSet): void {
    if (changes.empty) return;
    this.pending = this.pending ? this.pending.compose(changes) : changes;
  }

  /** The next edit to send, of all that was changed since the last; it stays pending where it does not fit. */
  take(fits: (due: { base: number; changes: Change[] }) => boolean = () => true): { base: number; changes: Change[] } | undefined {
    if (!this.pending) return undefined;
    const edit = { base: this.sentVersion, changes: changesOf(this.pending) };
    if (!fits(edit)) return undefined;
    this.sent.push(this.pending);
    this.pending = undefined;
    return edit;
  }

  /** The program has this version. */
  acknowledge(version: number): void {
    while (this.acknowledged.version < version && this.sent.length > 0) {
      this.advance(this.sent.shift()!);
    }
  }

  /** Follows a text that another page edits. */
  follow(changes: ChangeSet): void {
    if (!this.settled) return;
    this.advance(changes);
  }

  private advance(changes: ChangeSet): void {
    const { version, text } = this.acknowledged;
    this.past.push({ text, changes });
    if (this.past.length > MOST_PAST) this.past.shift();
    this.acknowledged = { version: version + 1, text: changes.apply(text) };
  }

  /** The text of a version, and all that was changed since; nothing where that is not known any more. */
  since(version: number): { text: Text; changes: ChangeDesc } | undefined {
    const steps = [...this.past.map((each) => each.changes), ...this.sent, ...(this.pending ? [this.pending] : [])];
    const texts = [...this.past.map((each) => each.text), ...this.versionsPassed(), ...(this.pending ? [this.text()] : [])];
    const at = this.past.length + version - this.acknowledged.version;
    const text = texts[at];
    return text && { text, changes: steps.slice(at).reduce<ChangeDesc>((all, each) => all.composeDesc(each), ChangeSet.empty(text.length)) };
  }

  /** After a loss the program has the acknowledged text, as `version`: all that came after it is pending again. */
  resume(version: number): void {
    if (version !== this.acknowledged.version) this.past = [];
    this.acknowledged = { version, text: this.acknowledged.text };
    for (const changes of this.sent.splice(0).reverse()) {
      this.pending = this.pending ? changes.compose(this.pending) : changes;
    }
  }

  /**
   * The program begins anew from `text` as `version`. What it lacks is pending afterwards; the answer is what
   * changes in the page's text: nothing where the program's is one that the page has passed through. With
   * `keepMine` the page's text stays, whatever the program has.
   */
  restart(version: number, text: Text, keepMine: boolean): ChangeSet | undefined {
    const passed = this.versionsPassed();
    for (let i = passed.length - 1; i >= 0; --i) {
      if (!passed[i]!.eq(text)) continue;
      this.acknowledge(this.acknowledged.version + i);
      this.resume(version);
      return undefined;
    }
    const mine = this.text();
    const local = this.localChanges();
    const base = this.acknowledged.text;
    this.acknowledged = { version, text };
    this.past = [];
    this.sent = [];
    if (keepMine) {
      const difference = differenceOf(text, mine);
      this.pending = difference.empty ? undefined : difference;
      return undefined;
    }
    const remote = differenceOf(base, text);
    if (!local) {
      this.pending = undefined;
      return remote;
    }
    this.pending = local.map(remote, true);
    return remote.map(local, false);
  }

  /** The text with all changes made. */
  text(): Text {
    const local = this.localChanges();
    return local ? local.apply(this.acknowledged.text) : this.acknowledged.text;
  }

  private localChanges(): ChangeSet | undefined {
    let all: ChangeSet | undefined;
    for (const changes of [...this.sent, this.pending]) {
      if (changes) all = all ? all.compose(changes) : changes;
    }
    return all;
  }

  private versionsPassed(): Text[] {
    const texts = [this.acknowledged.text];
    for (const changes of this.sent) texts.push(changes.apply(texts[texts.length - 1]!));
    return texts;
  }
}

/** A change set as the protocol has it. */
export function changesOf(set: ChangeSet): Change[] {
  const changes: Change[] = [];
  set.iterChanges((fromA, toA, _fromB, _toB, inserted) => changes.push([fromA, toA, inserted.toString()]));
  return changes;
}

/** The change set of the protocol's changes, or nothing where they do not fit a text of this length. */
export function changeSetOf(changes: Change[], length: number): ChangeSet | undefined {
  try {
    return ChangeSet.of(
      changes.map(([from, to, insert]) => ({ from, to, insert })),
      length,
      "\n",
    );
  } catch {
    return undefined;
  }
}

/** The change of one stretch that makes `to` of `from`. */
export function differenceOf(from: Text, to: Text): ChangeSet {
  const a = from.toString();
  const b = to.toString();
  let start = 0;
  const shorter = Math.min(a.length, b.length);
  while (start < shorter && a.charCodeAt(start) === b.charCodeAt(start)) ++start;
  let end = 0;
  while (end < shorter - start && a.charCodeAt(a.length - 1 - end) === b.charCodeAt(b.length - 1 - end)) ++end;
  if (start === a.length && start === b.length) return ChangeSet.empty(a.length);
  return ChangeSet.of(
    { from: start, to: a.length - end, insert: to.slice(start, b.length - end) },
    a.length,
  );
}

/** A text as the editor has it: lines end with `\n` alone. */
export function textOf(text: string): Text {
  return Text.of(text.split("\n"));
}
