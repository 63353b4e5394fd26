import { useState } from "preact/hooks";
import { matching, nameOfKey, whyNotKey } from "../core/keys.js";
import { changeKeys, commands, takesKeys, type Command } from "../commands.js";
import * as state from "../state.js";
import { Dialog } from "./dialog.js";

function Row({ command }: { command: Command }) {
  const { name } = command;
  const keys = command.inView ?? command.keys;
  const [waits, setWaits] = useState(false);
  const [why, setWhy] = useState<string | undefined>(undefined);
  const isChanged = Object.hasOwn(state.changedKeys.value, name);
  const wait = (now: boolean) => {
    takesKeys.value = now;
    setWaits(now);
  };
  const press = (event: KeyboardEvent) => {
    if (!waits) return;
    const key = nameOfKey(event);
    if (key === undefined || key === "Tab" || key === "Shift-Tab") return;
    event.preventDefault();
    event.stopPropagation();
    const refused = key === "Escape" ? undefined : whyNotKey(key, name, commands.peek());
    setWhy(refused);
    if (refused !== undefined) return;
    if (key !== "Escape") changeKeys(name, [key]);
    wait(false);
  };
  return (
    <div class="key-row" role="group" aria-label={name}>
      <span class="name">{name}</span>
      {keys.map((each) => <kbd key={each}>{command.inView ? `${each} in the view` : each}</kbd>)}
      <button
        type="button"
        aria-pressed={waits}
        aria-describedby={why === undefined ? undefined : "key-why"}
        onClick={() => {
          setWhy(undefined);
          wait(true);
        }}
        onKeyDown={press}
        onBlur={() => wait(false)}
      >
        {waits ? "Press the key" : "Change"}
      </button>
      <button type="button" disabled={keys.length === 0} onClick={() => changeKeys(name, [])}>None</button>
      <button type="button" disabled={!isChanged} onClick={() => changeKeys(name, undefined)}>Reset</button>
      {why !== undefined && <p class="why" id="key-why" role="alert">{why}</p>}
    </div>
  );
}

/** Gives commands other keys. */
export function KeysDialog({ close }: { close: () => void }) {
  const [typed, setTyped] = useState("");
  const found = matching(commands.value, typed);
  return (
    <Dialog title="Keys" close={close} wide>
      <p class="aside">“Change” waits for a key; Escape leaves it as it was.</p>
      <input
        type="search"
        aria-label="Part of a command’s name"
        placeholder="Type a part of a name"
        autofocus
        value={typed}
        onInput={(event) => setTyped(event.currentTarget.value)}
      />
      <div class="list key-rows">
        {found.map((each) => <Row key={each.name} command={each} />)}
        {found.length === 0 && <p class="empty">No command has these words.</p>}
      </div>
      <div class="buttons">
        <button type="button" disabled={Object.keys(state.changedKeys.value).length === 0} onClick={() => (state.changedKeys.value = {})}>Reset all</button>
        <button type="button" class="primary" onClick={close}>Done</button>
      </div>
    </Dialog>
  );
}
