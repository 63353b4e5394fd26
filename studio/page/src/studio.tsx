import { effect } from "@preact/signals";
import { render } from "preact";
import { watchKeys } from "./commands.js";
import { publishContract } from "./contract.js";
import * as documents from "./documents.js";
import { watchDrops } from "./drops.js";
import { followCaret, followFields } from "./entities.js";
import { followPlaced } from "./models.js";
import { makeEditor } from "./editor/editor.js";
import { Notices, StatusBar, Toolbar } from "./layout/bars.js";
import { Dialogs } from "./layout/dialogs.js";
import { narrow, watchSettings } from "./layout/layout_state.js";
import { Zones } from "./layout/zones.js";
import { setEditor } from "./panels/script.js";
import { currentWords } from "./panels/view.js";
import { parts, watchParts } from "./view/parts.js";
import { watchComparison } from "./view/compare.js";
import { watchFilter } from "./view/filter.js";
import { watchProbe } from "./view/probe.js";
import * as program from "./program.js";
import { handlers, painted } from "./receive.js";
import * as state from "./state.js";
import { watchRenders } from "./renders.js";
import { watchFrames } from "./view/frames.js";
import { watchAnimation } from "./view/player.js";
import { watchSmallPictures } from "./view/small_pictures.js";
import { watchVisibility, watchWishes } from "./view/wish.js";
import { watchWorkerTiles } from "./view/worker_tiles.js";
import { watchWrittenCamera } from "./view/write_camera.js";
import { watchWorkspace } from "./workspace.js";

const NARROW = "(max-width: 899px)";

function Studio() {
  return (
    <>
      <Toolbar />
      <main><Zones /></main>
      <StatusBar />
      <Notices />
      <Dialogs />
    </>
  );
}

function follow(query: string, set: (matches: boolean) => void): void {
  const media = matchMedia(query);
  set(media.matches);
  media.addEventListener("change", (event) => set(event.matches));
}

function watchLooks(): void {
  follow("(prefers-color-scheme: dark)", (matches) => (state.systemIsDark.value = matches));
  follow("(prefers-contrast: more)", (matches) => (state.systemWantsContrast.value = matches));
  follow(NARROW, (matches) => (narrow.value = matches));
  effect(() => {
    document.documentElement.dataset.theme = state.theme.value;
    document.documentElement.dataset.contrast = state.contrast.value;
    document.documentElement.style.setProperty("--code-size", `${state.fontSize.value}px`);
    const family = state.fontFamily.value.replace(/["\\\n]/g, "");
    document.documentElement.style.setProperty("--chosen-mono", family && `"${family}"`);
  });
  effect(() => {
    void documents.revision.value;
    const shown = documents.find(state.activeFile.value);
    const percent = /\d+ %/.exec(currentWords().words)?.[0];
    document.title = [percent, shown ? `${shown.dirty ? "• " : ""}${shown.file}` : undefined, "Tessera Studio"].filter(Boolean).join(" – ");
  });
}

program.takeToken();
// The address of a program that was started again differs in its token alone, which loads no page.
window.addEventListener("hashchange", program.takeToken);
publishContract();
setEditor(makeEditor());
program.connect({ handlers, greeting: documents.greeting, painted, parts });
watchLooks();
watchWishes();
watchFrames();
watchAnimation();
watchSmallPictures();
watchParts();
watchProbe();
watchFilter();
watchComparison();
watchWorkerTiles();
watchWrittenCamera();
watchRenders();
watchVisibility();
followCaret();
followFields();
followPlaced();
watchKeys();
watchSettings();
watchWorkspace();
effect(() => {
  if (state.connection.value === "lost" || state.connection.value === "refused") documents.connectionLost();
});
window.addEventListener("beforeunload", (event) => {
  documents.flush();
  if (documents.documents.peek().some((each) => each.dirty)) event.preventDefault();
});
watchDrops();
render(<Studio />, document.getElementById("studio")!);
