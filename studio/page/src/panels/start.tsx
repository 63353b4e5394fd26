import { copyText } from "../clipboard.js";
import { baseName } from "../core/paths.js";
import * as documents from "../documents.js";
import * as program from "../program.js";
import * as state from "../state.js";
import { Samples } from "./samples.js";

const MOST_SHOWN = 24;

/** Scenes that begin with a template; a studio that writes nothing makes none. */
function Templates() {
  const { value: welcome } = state.welcome;
  const templates = welcome?.templates ?? [];
  return (
    <div class="buttons" role="group" aria-label="New scene">
      {templates.map((each) => (
        <button key={each.id} type="button" disabled={welcome?.read_only} onClick={() => program.send("create", { template: each.id })}>
          {each.title}
        </button>
      ))}
    </div>
  );
}

/** Folders that were opened before. What a studio serves is for who started it to say, so that each is told with the command that opens it. */
function RecentFolders() {
  const folders = state.welcome.value?.recent ?? [];
  if (folders.length === 0) return null;
  return (
    <div role="group" aria-label="Recent folders">
      <h2>Recent folders</h2>
      <ul class="recent">
        {folders.map(({ folder, command }) => (
          <li key={folder} class="group">
            <code>{command}</code>
            <button type="button" aria-label={`Copy the command that opens ${folder}`} onClick={() => void copyText(command)}>Copy the command</button>
          </li>
        ))}
      </ul>
    </div>
  );
}

/** What is seen before any file is open. */
export function StartPage() {
  const scenes = state.files.value.filter((each) => each.kind === "scene").slice(0, MOST_SHOWN);
  return (
    <div class="start">
      <h2>Begin a scene</h2>
      <Templates />
      <h2>Open a scene</h2>
      <p>
        {state.welcome.value ? `In ${state.welcome.value.folder}: open a scene and type; the picture follows.` : "Waiting for the program…"}
      </p>
      {scenes.length > 0 && (
        <ul class="cards">
          {scenes.map((each) => (
            <li key={each.name}>
              <button type="button" onClick={() => documents.open(each.name)}>
                <span class="name">{baseName(each.name)}</span>
                <span class="aside">{each.name}</span>
              </button>
            </li>
          ))}
        </ul>
      )}
      <RecentFolders />
      <Samples />
      <p class="aside">F1 lists every command with its keys.</p>
    </div>
  );
}
