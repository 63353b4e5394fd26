// A stand-in for the program, to look at the page without it: `node stand_in.mjs PAGE_FOLDER SCENES_FOLDER [PORT]`.

import { createHash, randomBytes } from "node:crypto";
import { readdirSync, readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { deflateRawSync, gunzipSync } from "node:zlib";

const [page, scenes, port = "7199"] = process.argv.slice(2);
const TYPES = { html: "text/html", js: "text/javascript", css: "text/css", svg: "image/svg+xml" };
const TOKEN = "stand-in";

const server = createServer((request, response) => {
  const name = request.url === "/" ? "index.html" : request.url.slice(1).replace(/[^\w.]/g, "");
  let bytes;
  try {
    bytes = name === "index.html" ? readFileSync(join(page, name)) : gunzipSync(readFileSync(join(page, `${name}.gz`)));
  } catch {
    response.writeHead(404).end();
    return;
  }
  const nonce = randomBytes(12).toString("hex");
  if (name === "index.html") bytes = bytes.toString().replaceAll("{{nonce}}", nonce);
  response.writeHead(200, {
    "Content-Type": TYPES[name.split(".").pop()],
    "Content-Security-Policy": `default-src 'none'; script-src 'self'; connect-src 'self'; worker-src 'self'; img-src 'self' data: blob:; style-src 'nonce-${nonce}'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'`,
    "X-Content-Type-Options": "nosniff",
  });
  response.end(bytes);
});

/** One frame of a WebSocket, from here to the page. */
function webSocketFrame(opcode, payload) {
  const { length } = payload;
  const head =
    length < 126 ? Buffer.from([0x80 | opcode, length])
    : length < 65536 ? Buffer.from([0x80 | opcode, 126, length >> 8, length & 255])
    : Buffer.concat([Buffer.from([0x80 | opcode, 127, 0, 0, 0, 0]), Buffer.from(new Uint32Array([length]).buffer).reverse()]);
  return Buffer.concat([head, payload]);
}

/** Calls `heard` with the text of each message that arrives. */
function readFrames(socket, heard) {
  let buffered = Buffer.alloc(0);
  let message = [];
  socket.on("data", (bytes) => {
    buffered = Buffer.concat([buffered, bytes]);
    for (;;) {
      if (buffered.length < 2) return;
      let length = buffered[1] & 127;
      let at = 2;
      if (length === 126) [length, at] = [buffered.readUInt16BE(2), 4];
      else if (length === 127) [length, at] = [Number(buffered.readBigUInt64BE(2)), 10];
      if (buffered.length < at + 4 + length) return;
      const mask = buffered.subarray(at, at + 4);
      const payload = Buffer.from(buffered.subarray(at + 4, at + 4 + length)).map((byte, index) => byte ^ mask[index & 3]);
      const [first] = buffered;
      buffered = buffered.subarray(at + 4 + length);
      if ((first & 15) === 8) return socket.end();
      message.push(payload);
      if (first & 128) {
        heard(Buffer.concat(message).toString());
        message = [];
      }
    }
  });
}

function applyChanges(text, changes) {
  let result = "";
  let at = 0;
  for (const [from, to, inserted] of changes) {
    result += text.slice(at, from) + inserted;
    at = to;
  }
  return result + text.slice(at);
}

function listFiles() {
  return readdirSync(scenes).sort().map((name) => {
    const size = statSync(join(scenes, name)).size;
    const kind = /\.(tessera|crt|json|x3dv?|wrl|gltf|glb)$/.test(name) ? "scene" : /\.(obj|ply|stl|mtl)$/.test(name) ? "model" : "picture";
    return { name, kind, size };
  });
}

const documents = new Map();
let serial = 0;
const RUN = randomBytes(4).toString("hex");

class Session {
  constructor(socket) {
    this.socket = socket;
    this.wish = undefined;
    this.timer = undefined;
    readFrames(socket, (text) => this.hear(text));
    socket.on("error", () => {});
    socket.on("close", () => clearTimeout(this.timer));
  }
  say(kind, body) {
    this.socket.write(webSocketFrame(1, Buffer.from(JSON.stringify({ [kind]: body }))));
  }
  hear(text) {
    const [[kind, body]] = Object.entries(JSON.parse(text));
    console.log(text.slice(0, 300));
    this[`on_${kind}`]?.(body);
  }
  on_hello({ token, have }) {
    if (token !== TOKEN) {
      this.socket.end(webSocketFrame(8, Buffer.from([4401 >> 8, 4401 & 255])));
      return;
    }
    this.say("welcome", { id: RUN, program: "tessera 0.1.0", folder: scenes, file: process.env.STAND_IN_FILE, read_only: false, limits: { side: 65536, view_side: 16384, spp: 1048576, "max-depth": 10000, workers: 1024, nice: 19, frames: 100000 }, choices: { channel: ["light", "depth"], integrator: ["auto", "path"] }, workers_nice: 10, workspace: {}, settings: JSON.parse(process.env.STAND_IN_SETTINGS ?? "{}"), workers: 2, endings: [] });
    for (const file of Object.keys(have ?? {})) this.on_open({ file });
    this.say("workers", { list: [
      { name: "local-1", state: "tracing", threads: 1, rays_per_second: 1.2e6, tiles: 214, memory: 48e6 },
      { name: "local-2", state: "idle", threads: 1, rays_per_second: 1.1e6, tiles: 201, memory: 47e6 }] });
    this.say("log", { lines: [
      { time: "19:40:01", level: "info", text: "two workers have joined" },
      { time: "19:40:02", level: "warning", text: "a texture has no colour profile; sRGB is taken", file: "first_light.tessera", line: 12 }] });
    this.metrics = setInterval(() => this.say("metrics", { rays_per_second: 1e6 + 4e5 * Math.random(), tiles_per_second: 30 + 9 * Math.random(), cpu_program: 12, cpu_workers: 160 + 20 * Math.random(), memory: 210e6 }), 1000);
    this.socket.on("close", () => clearInterval(this.metrics));
  }
  on_list() { this.say("files", { entries: listFiles(), truncated: false }); }
  on_open({ file }) {
    if (!documents.has(file)) documents.set(file, { version: 1, text: readFileSync(join(scenes, file), "utf8") });
    const { version, text } = documents.get(file);
    this.say("document", { file, version, text, hash: createHash("sha256").update(text).digest("hex"), eol: "lf", bom: false, encoding: "UTF-8", editable: true, read_only: false, language: file.split(".").pop(), ...(process.env.STAND_IN_DRAFT ? { draft: { text: `${text}# more\n`, saved_at: Date.now() } } : {}) });
    this.read(file);
  }
  on_edit({ file, base, changes }) {
    const document = documents.get(file);
    if (!document || document.version !== base) {
      this.say("refused", { request: "edit", file, why: `base ${base}; expected ${document?.version}` });
      return;
    }
    document.text = applyChanges(document.text, changes);
    document.version = base + 1;
    this.say("edited", { file, version: document.version });
    this.read(file);
  }
  on_save({ file }) {
    this.say("saved", { file, version: documents.get(file).version, hash: "" });
  }
  on_set({ file, base, entity, field, text }) {
    const found = this.entities(file).find((each) => each.id === entity)?.fields.find((each) => each.name === field);
    if (found) this.say("change", { file, base, changes: [[found.from, found.to, text]], why: `property ${field}` });
  }
  on_pick({ pane, x, y }) {
    const [first] = this.entities(this.wish.file);
    this.say("picked", { pane, x, y, chain: first ? [{ kind: first.kind, name: first.name, file: this.wish.file, entity: first.id, line: first.line, column: first.column, end_line: first.end_line, end_column: first.end_column }] : [] });
  }
  /** Blocks of braces at the outermost level stand for entities, `name: number` lines for their fields. */
  entities(file) {
    const { text } = documents.get(file);
    const entities = [];
    const place = (at) => { const before = text.slice(0, at).split("\n"); return [before.length, before[before.length - 1].length + 1]; };
    for (const match of text.matchAll(/^(\w+) \{\n([\s\S]*?)^\}/gm)) {
      const from = match.index;
      const [line, column] = place(from);
      const [endLine, endColumn] = place(from + match[0].length);
      const fields = [...match[2].matchAll(/(\w+): ("[^"]*"|[-\w.]+)/g)].slice(0, 8).map((each) => {
        const start = from + match[1].length + 3 + each.index + each[1].length + 2;
        return { name: each[1], kind: /^[-\d.]/.test(each[2]) ? "number" : /^(true|false)$/.test(each[2]) ? "boolean" : "text", text: each[2], from: start, to: start + each[2].length };
      });
      entities.push({ id: entities.length + 1, parent: null, kind: match[1], name: /name: "([^"]*)"/.exec(match[2])?.[1] ?? "", line, column, end_line: endLine, end_column: endColumn, from, to: from + match[0].length, fields });
    }
    return entities;
  }
  read(file) {
    const { version, text } = documents.get(file);
    const at = text.indexOf("wrong");
    const lines = text.slice(0, at).split("\n");
    const list = at < 0 ? [] : [{ severity: "error", file, line: lines.length, column: lines[lines.length - 1].length + 1, end_line: lines.length, end_column: lines[lines.length - 1].length + 6, message: "no such field", found: "wrong", expected: "a field of Settings", suggestion: "width" }];
    this.say("problems", { file, version, list });
    if (at >= 0) {
      this.say("job", { pane: 0, serial, file, version, scale: 1, samples: 16, width: 0, height: 0, state: "done", stale: { as_of: Date.now(), why: `line ${lines.length}: no such field` } });
      return;
    }
    this.say("summary", { file, version, digest: createHash("sha1").update(text).digest("hex"), counts: [["objects", 4], ["lights", 2], ["materials", 3]], cameras: [{ name: "main", eye: [3, 2, 5], target: [0, 0.8, 0], up: [0, 1, 0], fov: 40 }], size: [320, 180], samples: 16, integrator: "path", bounds: [[-1, 0, -1], [1, 2, 1]] });
    this.say("outline", { file, version, entities: this.entities(file) });
    this.render();
  }
  on_view(wish) {
    this.wish = wish;
    this.render();
  }
  render() {
    clearTimeout(this.timer);
    const { wish } = this;
    if (!wish || !documents.has(wish.file)) return;
    this.pass([8, 4, 2, 1].map((scale) => ({ scale, samples: 1 })).concat([{ scale: 1, samples: 4 }, { scale: 1, samples: 16 }]), 0);
  }
  pass(passes, index) {
    const { wish } = this;
    const { scale, samples } = passes[index];
    const { version, text } = documents.get(wish.file);
    const [width, height] = wish.size.map((each) => Math.ceil(each / scale));
    ++serial;
    const isLast = index === passes.length - 1;
    this.say("job", { pane: wish.pane, serial, file: wish.file, version, scale, samples, width, height, state: "tracing" });
    const TILE = 64;
    const total = Math.ceil(width / TILE) * Math.ceil(height / TILE);
    let done = 0;
    for (let y = 0; y < height; y += TILE) {
      for (let x = 0; x < width; x += TILE) {
        ++done;
        this.tile({ x, y, width: Math.min(TILE, width - x), height: Math.min(TILE, height - y) }, { width, height, scale, version, samples, flags: (done === total ? 1 : 0) | (isLast ? 2 : 0), text, turn: wish.camera?.eye?.[0] ?? 3 });
      }
    }
    this.say("progress", { pane: wish.pane, serial, tiles_done: done, tiles_total: total, rays_per_second: 1.3e6, elapsed: 0.2 * index, left: 0.2 * (passes.length - index) });
    if (isLast) this.say("job", { pane: wish.pane, serial, file: wish.file, version, scale, samples, width, height, state: "done", times: { parse: 0.004, build: 0.002, trace: 0.5, total: 0.51 } });
    else this.timer = setTimeout(() => this.pass(passes, index + 1), 60);
  }
  tile(rectangle, picture) {
    const head = Buffer.alloc(32);
    head.write("TSPX");
    head[5] = 1;
    head[6] = this.wish.pane;
    head[7] = picture.scale;
    head.writeUInt32LE(serial, 8);
    [rectangle.x, rectangle.y, rectangle.width, rectangle.height, picture.width, picture.height].forEach((value, index) => head.writeUInt16LE(value, 12 + 2 * index));
    head.writeUInt32LE(picture.version, 24);
    head.writeUInt16LE(picture.samples, 28);
    head.writeUInt16LE(picture.flags, 30);
    const rows = Buffer.alloc(rectangle.width * rectangle.height * 4);
    const hue = (picture.text.length % 97) / 97;
    for (let y = 0; y < rectangle.height; ++y) {
      for (let x = 0; x < rectangle.width; ++x) {
        const u = (2 * (rectangle.x + x + 0.5) - picture.width) / picture.height;
        const v = 1 - (2 * (rectangle.y + y + 0.5)) / picture.height;
        const at = 4 * (y * rectangle.width + x);
        const r = Math.hypot(u - 0.1 * picture.turn + 0.3, v);
        const z = Math.sqrt(Math.max(0, 0.36 - r * r));
        const lit = r < 0.6 ? 0.15 + Math.max(0, (0.5 * u + 0.6 * v + 0.6 * z) / 0.6) : 0.5 + 0.25 * v;
        rows[at] = 255 * Math.min(1, lit * (0.7 + 0.3 * hue));
        rows[at + 1] = 255 * Math.min(1, lit * 0.8);
        rows[at + 2] = 255 * Math.min(1, lit * (r < 0.6 ? 0.55 : 1));
        rows[at + 3] = 255;
      }
    }
    this.socket.write(webSocketFrame(2, Buffer.concat([head, deflateRawSync(rows, { level: 1 })])));
  }
}

server.on("upgrade", (request, socket) => {
  const accept = createHash("sha1").update(`${request.headers["sec-websocket-key"]}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`).digest("base64");
  socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\nSec-WebSocket-Protocol: tessera-studio.1\r\n\r\n`);
  new Session(socket);
});
server.listen(Number(port), "127.0.0.1", () => console.log(`http://127.0.0.1:${port}/#token=${TOKEN}`));
