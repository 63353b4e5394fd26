import type { Signal } from "@preact/signals";
import { useRef, useState } from "preact/hooks";
import licences from "virtual:licences";
import { matching } from "../core/keys.js";
import { dateAndTime } from "../core/view_words.js";
import { closing, commands, type Command } from "../commands.js";
import { question } from "../confirm.js";
import { copyCanvas } from "../clipboard.js";
import * as looked from "../looked.js";
import * as documents from "../documents.js";
import { ComparedTexts } from "../panels/compared_texts.js";
import { NumberField } from "../panels/number_field.js";
import * as program from "../program.js";
import * as state from "../state.js";
import { choosePreset, preset } from "./layout_state.js";
import { PRESETS } from "../core/layout.js";
import { sharedChange } from "../entities.js";
import { wished } from "../models.js";
import { Dialog } from "./dialog.js";
import { KeysDialog } from "./keys_dialog.js";
import { CompareDialog, compared } from "./compare_dialog.js";
import { PictureDialog } from "./picture_dialog.js";
import { ModelDialog } from "./model_dialog.js";
import { ExportDialog } from "./export_dialog.js";
import { QuestionDialog } from "./question_dialog.js";
import { RenderDialog } from "./render_dialog.js";
import { SharedDialog } from "./shared_dialog.js";

const close = () => (state.dialog.value = undefined);

function Palette() {
  const [typed, setTyped] = useState("");
  const [at, setAt] = useState(0);
  const found = matching(commands.value, typed);
  const chosen = useRef<Command | undefined>(undefined);
  const run = (index: number) => {
    chosen.current = found[index];
    close();
  };
  const key = (event: KeyboardEvent) => {
    const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (event.key === "Enter") run(at);
    else if (step === 0) return;
    const next = Math.min(found.length - 1, Math.max(0, at + step));
    setAt(next);
    document.getElementById(`command-${next}`)?.scrollIntoView({ block: "nearest" });
    event.preventDefault();
  };
  return (
    <Dialog title="Commands" close={close} closed={() => chosen.current?.run()}>
      <input
        type="text"
        role="combobox"
        aria-label="Part of a command’s name"
        aria-expanded="true"
        aria-controls="command-list"
        aria-activedescendant={`command-${at}`}
        placeholder="Type a part of a name"
        autofocus
        value={typed}
        onInput={(event) => {
          setTyped(event.currentTarget.value);
          setAt(0);
        }}
        onKeyDown={key}
      />
      <div class="list commands" role="listbox" id="command-list" aria-label="Commands">
        {found.map((each, index) => (
          <div key={each.name} id={`command-${index}`} role="option" class="row" aria-selected={index === at} onClick={() => run(index)}>
            <span class="name">{each.name}</span>
            {each.inView?.map((name) => <kbd key={name}>{name} in the view</kbd>)}
            {each.keys.map((name) => <kbd key={name}>{name}</kbd>)}
          </div>
        ))}
        {found.length === 0 && <p class="empty">No command has these words.</p>}
      </div>
    </Dialog>
  );
}

/** A labelled list of values and their words. */
function ChoiceField<Value extends string>({ label, chosen, choices }: { label: string; chosen: Signal<Value>; choices: [Value, string][] }) {
  return (
    <label class="field">
      <span>{label}</span>
      <select value={chosen.value} onChange={(event) => (chosen.value = event.currentTarget.value as Value)}>
        {choices.map(([value, words]) => <option key={value} value={value}>{words}</option>)}
      </select>
    </label>
  );
}

function SettingsDialog() {
  return (
    <Dialog title="Settings" close={close}>
      <div class="fields">
        <ChoiceField label="Theme" chosen={state.themeChoice} choices={[["system", "as the system"], ["dark", "dark"], ["light", "light"]]} />
        <ChoiceField label="Contrast" chosen={state.contrastChoice} choices={[["system", "as the system"], ["normal", "normal"], ["high", "high"]]} />
        <NumberField label="Font size" unit="px" text={String(state.fontSize.value)} rules={{ whole: true, range: [8, 40] }} commit={(text) => (state.fontSize.value = Number(text))} />
        <label class="field">
          <span>Font of texts</span>
          <input type="text" placeholder="a monospaced one" value={state.fontFamily.value} onChange={(event) => (state.fontFamily.value = event.currentTarget.value.trim())} />
        </label>
        <ChoiceField label="Render" chosen={state.renderMode} choices={[["typing", "as I type"], ["save", "on save"], ["hand", "by hand (Alt-P)"]]} />
        <label class="field">
          <span>Layout</span>
          <select value={preset.value} onChange={(event) => choosePreset(event.currentTarget.value as keyof typeof PRESETS)}>
            {Object.keys(PRESETS).map((each) => <option key={each} value={each}>{each}</option>)}
          </select>
        </label>
      </div>
      <div class="fields">
        <NumberField label="Workers" optional placeholder="one a core" text={String(state.keptWorkers.value ?? "")} rules={{ whole: true, range: [1, state.mostOf("workers")] }} commit={(text) => (state.keptWorkers.value = text === "" ? undefined : Number(text))} />
        <NumberField label="Their nice level" optional placeholder={String(state.welcome.value?.workers_nice ?? "")} text={String(state.keptNice.value ?? "")} rules={{ whole: true, range: [0, state.mostOf("nice")] }} commit={(text) => (state.keptNice.value = text === "" ? undefined : Number(text))} />
      </div>
      <p class="aside">Workers are those of the next start without --workers.</p>
      <div class="buttons"><button type="button" onClick={() => (state.dialog.value = "keys")}>Keys…</button></div>
      <p class="aside">What is set here is kept by the program, not by the browser.</p>
    </Dialog>
  );
}

function About() {
  return (
    <Dialog title="About" close={close} wide>
      <p>Tessera Studio{state.welcome.value ? `, ${state.welcome.value.program}` : ""}</p>
      <p class="aside">These are the licences of Tessera, of what the program links, and of the packages in this page.</p>
      <pre class="licences" tabIndex={0} aria-label="Licences">{licences}</pre>
    </Dialog>
  );
}

function Token() {
  const [text, setText] = useState("");
  return (
    <Dialog title="Token" close={close}>
      <p>The program does not know this page. Paste the token from the address that it printed, after “#token=”.</p>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          program.setToken(text.replace(/^.*#?token=/, ""));
          close();
        }}
      >
        <input type="password" aria-label="Token" autofocus autocomplete="off" value={text} onInput={(event) => setText(event.currentTarget.value)} />
        <div class="buttons"><button type="submit" class="primary">Connect</button></div>
      </form>
    </Dialog>
  );
}

function SaveAs() {
  const file = state.activeFile.value ?? "";
  const [name, setName] = useState(file);
  const exists = state.files.value.some((each) => each.name === name.trim()) && name.trim() !== file;
  const wrong = name.trim() === "" ? "found nothing; expected a name" : exists ? "a file of that name exists; it is never written over" : undefined;
  return (
    <Dialog title="Save as" close={close}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (wrong) return;
          documents.save(file, name.trim());
          close();
        }}
      >
        <label class={`field ${wrong ? "wrong" : ""}`}>
          <span>Name below the folder</span>
          <input type="text" autofocus value={name} aria-invalid={wrong !== undefined} aria-describedby="save-as-why" onInput={(event) => setName(event.currentTarget.value)} />
        </label>
        <p class="why" id="save-as-why">{wrong}</p>
        <div class="buttons">
          <button type="button" onClick={close}>Cancel</button>
          <button type="submit" class="primary" disabled={wrong !== undefined}>Save</button>
        </div>
      </form>
    </Dialog>
  );
}

async function copyPicture(): Promise<void> {
  const image = await program.pixels();
  const canvas = document.createElement("canvas");
  canvas.width = image.width;
  canvas.height = image.height;
  canvas.getContext("2d")!.putImageData(image, 0, 0);
  await copyCanvas(canvas, "The picture of the view is in the clipboard.");
}

function Unsaved({ file }: { file: string }) {
  const stay = () => (closing.value = undefined);
  return (
    <Dialog title="Unsaved changes" close={stay}>
      <p>{file} has changes that are not saved.</p>
      <div class="buttons">
        <button type="button" autofocus onClick={stay}>Stay</button>
        <button
          type="button"
          onClick={() => {
            stay();
            documents.close(file, true);
          }}
        >
          Discard changes
        </button>
        <button
          type="button"
          class="primary"
          onClick={() => {
            stay();
            documents.save(file, undefined, true);
          }}
        >
          Save and close
        </button>
      </div>
    </Dialog>
  );
}

function Recovery({ document }: { document: documents.OpenDocument }) {
  const [isCompared, setCompared] = useState(false);
  const { file, draft } = document;
  const decide = (take: boolean) => documents.recover(file, take);
  return (
    <Dialog title="Recover unsaved text" close={() => documents.postponeDraft(file)} wide={isCompared}>
      <p>
        {file} has text that was never saved, from {dateAndTime(draft!.saved_at)}. The file on the disk is {documents.stateOf(document).doc.length} characters long, the unsaved text {draft!.text.length}.
      </p>
      {isCompared && (
        <ComparedTexts before={{ label: "On the disk", text: documents.stateOf(document).doc.toString() }} after={{ label: "Unsaved", text: draft!.text }} />
      )}
      <div class="buttons">
        <button type="button" aria-pressed={isCompared} onClick={() => setCompared(!isCompared)}>Compare</button>
        <button type="button" onClick={() => decide(false)}>Discard the unsaved text</button>
        <button type="button" class="primary" autofocus onClick={() => decide(true)}>Restore the unsaved text</button>
      </div>
    </Dialog>
  );
}

/** The dialog that is open, and in front of it what it asks. */
export function Dialogs() {
  return (
    <>
      <OpenDialog />
      {question.value && <QuestionDialog asked={question.value} />}
    </>
  );
}

function OpenDialog() {
  void documents.revision.value;
  const withDraft = documents.find(state.activeFile.value);
  const withDisk = documents.find(compared.value);
  if (looked.job.value !== undefined) return <PictureDialog />;
  if (sharedChange.value) return <SharedDialog change={sharedChange.value} />;
  if (wished.value) return <ModelDialog wish={wished.value} />;
  if (withDisk?.disk === "changed") return <CompareDialog document={withDisk} />;
  if (closing.value !== undefined) return <Unsaved file={closing.value} />;
  switch (state.dialog.value) {
    case "commands":
      return <Palette />;
    case "settings":
      return <SettingsDialog />;
    case "keys":
      return <KeysDialog close={close} />;
    case "about":
      return <About />;
    case "token":
      return <Token />;
    case "save_as":
      return <SaveAs />;
    case "export":
      return <ExportDialog close={close} copy={copyPicture} />;
    case "render":
      return <RenderDialog close={close} />;
    default:
      return withDraft?.draft ? <Recovery key={withDraft.file} document={withDraft} /> : null;
  }
}
