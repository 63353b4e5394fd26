import * as state from "../state.js";
import { chainAt, chooseLink, metNothing } from "../view/picking.js";

/** What was picked, and what it stands in: the innermost first. One line always, so that a click leaves the picture its size. */
export function Chain() {
  const chain = state.chain.value;
  return (
    <nav class="chain" aria-label="Picked" title="Alt-Up and Alt-Down walk through it">
      {chain.length === 0 && <span class="kind">{metNothing.value ? "Only the background is there." : "Click the picture to find its text."}</span>}
      <ol>
        {chain.map((link, index) => (
          <li key={index}>
            <button type="button" aria-current={index === chainAt.value ? "true" : undefined} onClick={() => chooseLink(index)}>
              <span class="kind">{link.kind}</span> {link.name}
              {link.line !== undefined && <span class="place"> {link.file}:{link.line}</span>}
            </button>
          </li>
        ))}
      </ol>
    </nav>
  );
}
