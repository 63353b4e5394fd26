import { decideShared, type SharedChange } from "../entities.js";
import { Dialog } from "./dialog.js";

/** Asked before a literal is edited that stands for more than the field that is seen. */
export function SharedDialog({ change }: { change: SharedChange }) {
  return (
    <Dialog title="Several values change" close={() => decideShared(false)}>
      <p>{change.field} is the value of a variable. Setting it to {change.text} changes {change.uses} things.</p>
      <div class="buttons">
        <button type="button" onClick={() => decideShared(false)}>Cancel</button>
        <button type="button" class="primary" autofocus onClick={() => decideShared(true)}>Change all {change.uses}</button>
      </div>
    </Dialog>
  );
}
