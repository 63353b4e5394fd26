import { signal } from "@preact/signals";
import { ComparedTexts } from "../panels/compared_texts.js";
import * as documents from "../documents.js";
import { Dialog } from "./dialog.js";

/** The file whose text is compared with the one on the disk. */
export const compared = signal<string | undefined>(undefined);

export function CompareDialog({ document }: { document: documents.OpenDocument }) {
  const { file, diskText = "" } = document;
  const close = () => (compared.value = undefined);
  const choose = (what: (file: string) => void) => {
    close();
    what(file);
  };
  return (
    <Dialog title={`Compare ${file}`} close={close} wide>
      <ComparedTexts before={{ label: "On the disk", text: diskText }} after={{ label: "Mine", text: documents.stateOf(document).doc.toString() }} />
      <div class="buttons">
        <button type="button" autofocus onClick={close}>Close</button>
        <button type="button" onClick={() => choose(documents.keepMine)}>Keep mine</button>
        <button type="button" onClick={() => choose(documents.loadTheirs)}>Load theirs</button>
      </div>
    </Dialog>
  );
}
