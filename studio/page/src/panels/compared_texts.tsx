import { lineDifference } from "../core/line_difference.js";

interface Side {
  label: string;
  text: string;
}

/** Two texts side by side: lines that differ are marked, by a sign and by their ground. */
export function ComparedTexts({ before, after }: { before: Side; after: Side }) {
  const pairs = lineDifference(before.text, after.text);
  const differing = pairs.filter((each) => !each.isSame).length;
  const cell = (line: string | undefined, sign: string, isSame: boolean) => (
    <td class={isSame ? "" : line === undefined ? "lacks" : "differs"}>{line !== undefined && !isSame && <b>{sign}</b>}{line ?? ""}</td>
  );
  return (
    <>
      <p role="status">{differing === 0 ? "The texts are alike." : `${differing} of ${pairs.length} lines differ.`}</p>
      <div class="compared-texts" tabIndex={0} role="group" aria-label={`${before.label} and ${after.label}`}>
        <table>
          <thead><tr><th>{before.label}</th><th>{after.label}</th></tr></thead>
          <tbody>
            {pairs.map((each, index) => <tr key={index}>{cell(each.before, "−", each.isSame)}{cell(each.after, "+", each.isSame)}</tr>)}
          </tbody>
        </table>
      </div>
    </>
  );
}
