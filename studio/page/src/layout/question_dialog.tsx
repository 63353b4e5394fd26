import { question, type Question } from "../confirm.js";
import { Dialog } from "./dialog.js";

/** In front of whatever asks: nothing is done unless it is agreed to. */
export function QuestionDialog({ asked }: { asked: Question }) {
  const close = () => (question.value = undefined);
  const accept = () => {
    close();
    asked.run();
  };
  const decline = () => {
    close();
    asked.otherwise?.();
  };
  return (
    <Dialog title={asked.title} close={decline}>
      <p>{asked.words}</p>
      <div class="buttons">
        <button type="button" autofocus onClick={decline}>{asked.accept ? "Cancel" : "Close"}</button>
        {asked.accept && <button type="button" class="primary" onClick={accept}>{asked.accept}</button>}
      </div>
    </Dialog>
  );
}
