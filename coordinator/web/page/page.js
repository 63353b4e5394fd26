// The page of a coordinator: asks how the farm is, again and again, and shows that.
import { API, Refused, download, get, getPicture, order, signIn } from "./api.js";
import { bytes, counted, duration, localTime, rate, workerColor } from "./format.js";
import { difference } from "./difference.js";
import { drawGraph } from "./graphs.js";
import { Picture, tilesOfTrace } from "./picture.js";

const byId = (id) => document.getElementById(id);
const EVERY = 1000, SHORTEST_PAUSE = 50, HIDDEN_EVERY = 10000, LONGEST_PAUSE = 5000, LOG_LINES = 300;
const picture = new Picture(byId("picture"));
picture.showInFlight = true;

let farm = null;
let chosen = { job: Number(location.hash.match(/^#job=(\d+)$/)?.[1] ?? 0), frame: null };
let seen = { tag: null, frame: null, cost: false };  // of the picture that is shown
let lastLine = 0, failures = 0, timer = 0, turn = 0;

function make(tag, text, className) {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = text;
  if (className) element.className = className;
  return element;
}

// ------------------------------------------------------------------------------- asking

async function ask() {
  clearTimeout(timer);
  const mine = ++turn;
  try {
    const [now, history, log] = await Promise.all([get("farm"), get("history"), get(`log?after=${lastLine}`)]);
    if (mine !== turn) return;
    // Another coordinator on the same store counts its lines from the start.
    const anew = farm !== null && (farm.opening !== now.opening || farm.farm !== now.farm);
    if (anew) startAnew();
    farm = now;
    failures = 0;
    setConnection("live", "live");
    showFarm(history);
    if (!anew) showLog(log.lines);
    await showFrame(mine);
  } catch (error) {
    if (mine !== turn) return;
    if (error instanceof Refused) return askForToken();
    ++failures;
    setConnection("lost", "disconnected: trying again …");
  }
  if (mine === turn) later();
}

function later() {
  const pause = failures ? Math.min(LONGEST_PAUSE, 500 * 2 ** Math.min(failures, 5)) : EVERY;
  timer = setTimeout(ask, document.hidden ? HIDDEN_EVERY : pause);
}

// What is new at once: a job that has come, the first tile of a frame.
async function listen() {
  let known = "";
  while (!document.hidden && !failures) {
    try {
      const { news } = await get(`news${known}`);
      if (known !== `?after=${news}` && known) ask();
      known = `?after=${news}`;
      await new Promise((done) => setTimeout(done, SHORTEST_PAUSE));
    } catch {
      break;
    }
  }
  setTimeout(listen, EVERY);
}

function startAnew() {
  lastLine = 0;
  seen = { tag: null, frame: null, cost: false };
  byId("log").replaceChildren();
}

function setConnection(state, text) {
  if (document.body.dataset.connection === state) return;
  document.body.dataset.connection = state;
  byId("connection").textContent = text;
  for (const button of document.querySelectorAll(".controls button")) button.disabled = state !== "live";
}

function askForToken() {
  setConnection("lost", "a token is needed");
  const dialog = byId("sign-in");
  if (!dialog.open) dialog.showModal();
}

byId("sign-in-form").addEventListener("submit", (event) => {
  event.preventDefault();
  signIn(byId("token").value);
  byId("token").value = "";
  byId("sign-in").close();
  ask();
});
document.addEventListener("visibilitychange", () => { if (!document.hidden) ask(); });
addEventListener("online", ask);

// ------------------------------------------------------------------------------ the farm

function showFarm(history) {
  const there = farm.workers.filter((worker) => worker.state !== "lost");
  const threads = there.reduce((sum, worker) => sum + worker.threads, 0);
  const running = farm.jobs.filter((job) => job.state === "running").length;
  byId("summary").textContent = `${counted(there.length, "worker")}, ${counted(threads, "thread")} · ` +
    `${counted(running, "running job")} · up ${duration(farm.uptime_seconds)}`;
  byId("trouble").hidden = !farm.store_trouble;
  byId("trouble").textContent = `No tile is given out: ${farm.store_trouble}`;
  showJobs();
  showWorkers();
  showGraphs(history);
  const c = farm.counters;
  byId("counters").textContent = [counted(c.tiles_done, "tile"), `${c.tiles_restored} kept from an earlier run`,
    `${c.retries} retried`, `${c.speculative} second copies`,
    `${c.tiles_given_up} given up`, `${c.mismatches} mismatches`, `${counted(c.workers_lost, "worker")} lost`,
    `${c.workers_set_aside} set aside`, `${bytes(c.bytes_scene)} out`, `${bytes(c.bytes_results)} in`].join(" · ");
}

const share = (job) => job.tiles_total ? job.tiles_done / job.tiles_total : job.state === "done" ? 1 : 0;
const titleOf = (job) => job.name || `job ${job.id}`;

function showJobs() {
  const list = byId("jobs");
  byId("no-jobs").hidden = farm.jobs.length > 0;
  if (!farm.jobs.some((job) => job.id === chosen.job)) {
    const first = farm.jobs.find((job) => job.state === "running") ?? farm.jobs[farm.jobs.length - 1];
    choose(first?.id ?? 0, false);
  }
  const rows = new Map([...list.children].map((row) => [Number(row.dataset.job), row]));
  const order = [...farm.jobs].reverse().map((job) => {
    const row = rows.get(job.id) ?? makeJobRow(job.id);
    const [button] = row.children, [name, about, progress] = button.children;
    row.className = job.state;
    button.setAttribute("aria-current", String(job.id === chosen.job));
    name.textContent = titleOf(job);
    about.firstChild.textContent = job.state;
    about.lastChild.textContent = job.state === "running" ? `${Math.floor(share(job) * 100)} %` : "";
    progress.value = share(job);
    return row;
  });
  // Moving a row that has the focus would lose it.
  if (order.length !== list.children.length || order.some((row, i) => row !== list.children[i])) list.replaceChildren(...order);
}

function makeJobRow(id) {
  const row = make("li"), button = make("button"), about = make("span", undefined, "about");
  row.dataset.job = id;
  button.type = "button";
  about.append(make("span"), make("span"));
  const progress = make("progress");
  progress.max = 1;
  progress.setAttribute("aria-hidden", "true");
  button.append(make("span", undefined, "name"), about, progress);
  button.addEventListener("click", () => choose(id, true));
  row.append(button);
  return row;
}

function choose(job, byHand) {
  if (chosen.job === job) return;
  chosen = { job, frame: null };
  seen = { tag: null, frame: null, cost: false };
  if (byHand) {
    history.replaceState(null, "", `#job=${job}`);
    byId("order-note").textContent = "";
    ask();
  }
}

function showWorkers() {
  const workers = [...farm.workers].sort((a, b) => (a.state === "lost") - (b.state === "lost") || a.name.localeCompare(b.name, "en", { numeric: true }));
  byId("no-workers").hidden = workers.length > 0;
  picture.names = new Map(workers.map((worker) => [worker.id, worker.name]));
  const most = 200;
  byId("workers").replaceChildren(...workers.slice(0, most).map((worker) => {
    const row = make("tr", undefined, worker.state), name = make("td"), swatch = make("i", undefined, "swatch");
    swatch.style.setProperty("--swatch", workerColor(worker.id));
    name.title = `${worker.name}: ${worker.state}, ${counted(worker.threads, "thread")}`;
    name.append(swatch, worker.name);
    const mean = worker.tiles_done ? duration(worker.tile_seconds / worker.tiles_done) : "";
    row.append(name, make("td", worker.tiles_done.toLocaleString("en")),
               make("td", worker.state === "active" ? worker.tiles_held : worker.state), make("td", mean),
               make("td", worker.resident_bytes ? bytes(worker.resident_bytes) : ""));
    return row;
  }));
  if (workers.length > most) {
    const row = make("tr"), cell = make("td", `and ${workers.length - most} more`);
    cell.colSpan = 5;
    row.append(cell);
    byId("workers").append(row);
  }
}

function showGraphs(data) {
  const last = (values) => values[values.length - 1] ?? 0;
  drawGraph(byId("throughput"), data.at, [data.tiles_per_second]);
  byId("throughput-now").textContent = `${rate(last(data.tiles_per_second))} tiles/s · ${bytes(last(data.result_bytes_per_second))}/s`;
  drawGraph(byId("memory"), data.at, [data.worker_bytes, data.coordinator_bytes]);
  byId("memory-workers").textContent = `workers ${bytes(last(data.worker_bytes))}`;
  byId("memory-coordinator").textContent = `coordinator ${bytes(last(data.coordinator_bytes))}`;
}

function showLog(lines) {
  if (lines.length === 0) return;
  const list = byId("log");
  for (const line of lines) {
    if (line.number <= lastLine) continue;
    lastLine = line.number;
    const row = make("li", undefined, line.level), time = new Date(line.milliseconds);
    const stamp = make("time", localTime(time));
    stamp.dateTime = time.toISOString();
    row.append(stamp, make("span", line.text));
    list.prepend(row);
  }
  while (list.children.length > LOG_LINES) list.lastChild.remove();
}

// --------------------------------------------------------------------------- one job

const chosenJob = () => farm?.jobs.find((job) => job.id === chosen.job);

function frameToShow(job) {
  if (chosen.frame != null) return chosen.frame;
  if (job.frames_running.length) return job.frames_running[0];
  return Math.max(0, job.frames_done - 1);
}

async function showFrame(mine) {
  const job = chosenJob();
  byId("job").hidden = !job;
  if (!job) return;
  const frame = frameToShow(job);
  showJob(job, frame);
  if (seen.job !== job.id || seen.frame !== frame) {
    picture.clear(job.width, job.height);
    seen = { job: job.id, frame, tag: null, cost: false };
    byId("save-picture").hidden = byId("save-scene").hidden = byId("open-scene").hidden = true;
    byId("difference").hidden = true;
    byId("other").value = "";
  }
  showOthers(job);
  const [tiles, image] = await Promise.all([
    get(`jobs/${job.id}/tiles?frame=${frame}`),
    getPicture(`jobs/${job.id}/preview.png?frame=${frame}`, seen.tag)]);
  if (mine !== turn || seen.frame !== frame || seen.job !== job.id) return;
  if (seen.number !== tiles.number) {
    seen.number = tiles.number;
    showJob(job, frame);
  }
  if (image) {
    picture.showBitmap(image.bitmap);
    seen.tag = image.tag;
  }
  picture.showTiles(tiles);
  byId("picture-note").textContent = seen.tag ? "" : waitingFor(job, tiles);
  byId("save-picture").hidden = !seen.tag;
  byId("save-scene").hidden = false;
  await showCost(job, frame);
}

function waitingFor(job, tiles) {
  if (job.waits_for) return `waiting for ${job.waits_for}`;
  if (job.state === "queued") return "waiting for its turn";
  if (job.state !== "running") return "there is no picture";
  return tiles.tiles.length && !farm.workers.some((w) => w.state !== "lost") ? "waiting for workers" : "";
}

function showJob(job, frame) {
  const section = byId("job"), ended = ["done", "failed", "cancelled"].includes(job.state);
  section.className = job.state;
  document.title = ended || job.state === "queued" ? `Tessera: ${titleOf(job)}` : `${Math.floor(share(job) * 100)} % ${titleOf(job)}`;
  byId("job-name").textContent = titleOf(job);
  byId("job-state").textContent = job.state;
  byId("job-size").textContent = `job ${job.id} · ${job.width}×${job.height}` +
    (job.frames_total > 1 ? ` · ${job.frames_done} of ${counted(job.frames_total, "frame")}` : "");
  byId("progress").value = share(job);
  const kept = job.tiles_restored ? `, ${job.tiles_restored.toLocaleString("en")} kept from an earlier run` : "";
  const left = ended || job.remaining_seconds == null ? "" : `about ${duration(job.remaining_seconds)} left`;
  const spans = [`${job.tiles_done.toLocaleString("en")} of ${counted(job.tiles_total, "tile")}${kept}`,
    [job.elapsed_seconds ? duration(job.elapsed_seconds) : "", left].filter(Boolean).join(" · ")];
  byId("progress-text").replaceChildren(...spans.map((text) => make("span", text)));
  const trouble = ended || (job.failure && !job.waits_for) ? job.failure : job.waits_for ? `waits for ${job.waits_for}` : "";
  byId("failure").hidden = !trouble;
  byId("failure").textContent = trouble;
  byId("pause").textContent = job.state === "paused" ? "Resume" : "Pause";
  for (const id of ["pause", "cancel", "raise", "lower"]) byId(id).disabled = ended;
  byId("priority").textContent = `priority ${job.priority}`;
  byId("frames").hidden = job.frames_total < 2;
  const number = seen.job === job.id && seen.frame === frame ? seen.number : undefined;
  byId("frame").textContent = `frame ${number ?? "…"}`;
  byId("frame-before").disabled = frame === 0;
  byId("frame-after").disabled = frame + 1 >= job.frames_total;
  byId("trace").href = `${API}jobs/${job.id}/trace.json?frame=${frame}`;
  const name = `job-${job.id}${job.frames_total > 1 ? `-frame-${number ?? frame + 1}` : ""}`;
  byId("save-picture").href = `${API}jobs/${job.id}/picture.png?frame=${frame}`;
  byId("save-picture").download = `${name}.png`;
  byId("save-scene").href = `${API}jobs/${job.id}/scene.tessera?frame=${frame}`;
  byId("save-scene").download = `${name}.tessera`;
}

/// The jobs of as many pixels, whose pictures can be compared.
function showOthers(job) {
  const list = byId("other");
  const others = farm.jobs.filter((each) => each.id !== job.id && each.width === job.width && each.height === job.height);
  const wanted = ["", ...others.map((each) => String(each.id))];
  if (wanted.join() === [...list.options].map((each) => each.value).join()) return;
  const before = list.value;
  list.replaceChildren(...wanted.map((id) => {
    const option = make("option", id ? `job ${id} ${titleOf(others.find((each) => String(each.id) === id))}` : "no job");
    option.value = id;
    return option;
  }));
  list.value = wanted.includes(before) ? before : "";
}

async function compare() {
  const job = chosenJob(), other = Number(byId("other").value), note = byId("difference");
  note.hidden = !job || !other;
  if (note.hidden) return;
  note.textContent = "comparing …";
  const frame = frameToShow(job), theirs = farm.jobs.find((each) => each.id === other);
  const otherFrame = Math.min(frame, (theirs?.frames_total ?? 1) - 1);
  try {
    const [one, two] = await Promise.all([getPicture(`jobs/${job.id}/picture.png?frame=${frame}`),
                                          getPicture(`jobs/${other}/picture.png?frame=${otherFrame}`)]);
    if (chosen.job !== job.id || Number(byId("other").value) !== other) return;
    const found = difference(one.bitmap, two.bitmap);
    const digits = (value) => Number(value.toPrecision(6));
    note.textContent = !found ? `sizes differ: ${one.bitmap.width}×${one.bitmap.height} and ${two.bitmap.width}×${two.bitmap.height}`
      : [`job ${job.id} and job ${other}: max difference ${digits(found.greatest)}`, `mean difference ${digits(found.mean)}`,
         `rmse ${digits(found.rmse)}`, `differing pixels ${found.unequal} of ${found.pixels}`,
         found.unequal ? `worst pixel ${found.worst.join(",")}` : ""].filter(Boolean).join(" · ");
  } catch (error) {
    if (error instanceof Refused) return askForToken();
    note.textContent = error.message;
  }
}
byId("other").addEventListener("change", compare);

async function showCost(job, frame) {
  if (picture.showCost && picture.tiles.length === 0 && !seen.cost && job.state !== "queued") {
    seen.cost = true;
    const trace = await get(`jobs/${job.id}/trace.json?frame=${frame}`).catch(() => null);
    if (trace) picture.showTiles(tilesOfTrace(trace));
    picture.live = false;
    picture.draw();
  }
  const costs = picture.showCost ? picture.costs() : null;
  byId("cost-scale").hidden = !costs;
  if (!costs) return;
  byId("cost-least").textContent = duration(costs.least);
  byId("cost-most").textContent = duration(costs.most);
}

// ---------------------------------------------------------------------------- orders

async function command(what, value) {
  const job = chosenJob();
  if (!job) return;
  try {
    const done = await order(job.id, what, value);
    byId("order-note").textContent = what === "priority" ? `${titleOf(job)} has priority ${done.priority}` : `${titleOf(job)} is ${done.state}`;
  } catch (error) {
    if (error instanceof Refused) return askForToken();
    byId("order-note").textContent = error.message;
  }
  ask();
}

byId("pause").addEventListener("click", () => command(chosenJob()?.state === "paused" ? "resume" : "pause"));
byId("cancel").addEventListener("click", () => {
  const job = chosenJob();
  if (job && confirm(`Cancel ${titleOf(job)}? What is traced of it stays.`)) command("cancel");
});
byId("raise").addEventListener("click", () => command("priority", { priority: chosenJob().priority + 1 }));
byId("lower").addEventListener("click", () => command("priority", { priority: chosenJob().priority - 1 }));
const step = (by) => { chosen.frame = frameToShow(chosenJob()) + by; ask(); };
byId("frame-before").addEventListener("click", () => step(-1));
byId("frame-after").addEventListener("click", () => step(1));
byId("show-tiles").addEventListener("change", (event) => { picture.showInFlight = event.target.checked; picture.draw(); });
byId("show-cost").addEventListener("change", (event) => { picture.showCost = event.target.checked; picture.draw(); ask(); });
// By a request of ours, which has the token.
function save(event, name) {
  event.preventDefault();
  const path = event.currentTarget.getAttribute("href").slice(API.length);
  download(path, name).catch((error) => { byId("order-note").textContent = error.message; });
}
byId("save-scene").addEventListener("click", (event) => {
  const name = event.currentTarget.download, note = byId("open-scene");
  save(event, name);
  note.querySelector("code").textContent = `tessera studio ${name}`;
  note.hidden = false;
});
byId("trace").addEventListener("click", (event) => save(event, `job-${chosen.job}-trace.json`));
byId("save-picture").addEventListener("click", (event) => save(event, event.currentTarget.download));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => picture.draw());

ask();
listen();
