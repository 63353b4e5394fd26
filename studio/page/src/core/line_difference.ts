// Two texts beside each other, line by line.

/** Lines that are in both, or that stand for each other; a text that has none there has nothing. */
export interface LinePair {
  before: string | undefined;
  after: string | undefined;
  isSame: boolean;
}

/** Above so many pairs of lines, what differs is told as one piece. */
const MOST_PAIRS = 4e6;

/** The lines of both texts: as many as can be are the same (the longest common subsequence). */
export function lineDifference(before: string, after: string): LinePair[] {
  const a = before.split("\n"), b = after.split("\n");
  let begin = 0;
  while (begin < a.length && begin < b.length && a[begin] === b[begin]) ++begin;
  let end = 0;
  while (end < a.length - begin && end < b.length - begin && a[a.length - 1 - end] === b[b.length - 1 - end]) ++end;
  const same = (line: string): LinePair => ({ before: line, after: line, isSame: true });
  return [
    ...a.slice(0, begin).map(same),
    ...middleDifference(a.slice(begin, a.length - end), b.slice(begin, b.length - end)),
    ...a.slice(a.length - end).map(same),
  ];
}

function middleDifference(a: readonly string[], b: readonly string[]): LinePair[] {
  if (a.length * b.length > MOST_PAIRS) return paired(a, b);
  const width = b.length + 1;
  // How many lines are the same from there to the ends.
  const common = new Uint32Array((a.length + 1) * width);
  for (let i = a.length - 1; i >= 0; --i) {
    for (let j = b.length - 1; j >= 0; --j) {
      common[i * width + j] = a[i] === b[j] ? common[(i + 1) * width + j + 1]! + 1 : Math.max(common[(i + 1) * width + j]!, common[i * width + j + 1]!);
    }
  }
  const pairs: LinePair[] = [];
  let i = 0, j = 0, removed: string[] = [], added: string[] = [];
  while (i < a.length && j < b.length) {
    if (a[i] === b[j]) {
      pairs.push(...paired(removed, added), { before: a[i]!, after: b[j]!, isSame: true });
      removed = [];
      added = [];
      ++i;
      ++j;
    } else if (common[(i + 1) * width + j]! >= common[i * width + j + 1]!) removed.push(a[i++]!);
    else added.push(b[j++]!);
  }
  return [...pairs, ...paired([...removed, ...a.slice(i)], [...added, ...b.slice(j)])];
}

/** Lines that stand for each other, one after the other. */
function paired(a: readonly string[], b: readonly string[]): LinePair[] {
  return Array.from({ length: Math.max(a.length, b.length) }, (_, index) => ({ before: a[index], after: b[index], isSame: false }));
}
