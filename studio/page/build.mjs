// Makes the page: `node build.mjs OUTPUT_FOLDER`, in a folder that `npm ci` has filled.

import { execFileSync } from "node:child_process";
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { build } from "esbuild";

const MOST_PACKAGES = 25;
const MOST_GZIPPED_BYTES = 250_000;
const LICENCES = new Set(["MIT", "ISC", "BSD-2-Clause", "BSD-3-Clause", "Apache-2.0"]);

/** The packages that the page ships: all of the lock that are not for development. */
function shippedPackages() {
  const { packages } = JSON.parse(readFileSync("package-lock.json", "utf8"));
  return Object.entries(packages)
    .filter(([path, entry]) => path !== "" && !entry.dev && !entry.optional)
    .map(([path]) => path)
    .sort();
}

/** What the program is under, with all that it links; and the texts of the licences of the page's packages, each once. */
function licences() {
  const shipped = shippedPackages();
  if (shipped.length > MOST_PACKAGES) throw new Error(`${shipped.length} packages; expected at most ${MOST_PACKAGES}`);
  const texts = new Map();
  for (const path of shipped) {
    const { name, version, license } = JSON.parse(readFileSync(join(path, "package.json"), "utf8"));
    if (!LICENCES.has(license)) throw new Error(`${name}: licence ${license}; expected one of ${[...LICENCES].join(", ")}`);
    const file = readdirSync(path).find((each) => /^licen[cs]e(\.\w+)?$/i.test(each));
    if (!file) throw new Error(`${name}: has no text of its licence`);
    const text = readFileSync(join(path, file), "utf8").trim();
    texts.set(text, [...(texts.get(text) ?? []), `${name} ${version}`]);
  }
  const ofPackages = [...texts].map(([text, names]) => `${names.join(", ")}\n\n${text}\n`);
  return [readFileSync("copyright", "utf8"), ...ofPackages].join("\n\n");
}

const virtualLicences = {
  name: "licences",
  setup(plugin) {
    plugin.onResolve({ filter: /^virtual:licences$/ }, (request) => ({ path: request.path, namespace: "licences" }));
    plugin.onLoad({ filter: /.*/, namespace: "licences" }, () => ({ contents: licences(), loader: "text" }));
  },
};

const shared = {
  bundle: true,
  minify: true,
  target: ["es2022"],
  legalComments: "none",
  charset: "utf8",
  write: false,
  logLevel: "warning",
};

async function bundle(entry, options) {
  const { outputFiles } = await build({ ...shared, entryPoints: [entry], ...options });
  return Buffer.from(outputFiles[0].contents);
}

const output = process.argv[2];
if (!output) throw new Error("usage: node build.mjs OUTPUT_FOLDER");
const files = {
  "studio.js": await bundle("src/studio.tsx", {
    format: "esm",
    jsx: "automatic",
    jsxImportSource: "preact",
    plugins: [virtualLicences],
  }),
  "worker.js": await bundle("src/worker/worker.ts", { format: "iife" }),
  "studio.css": await bundle("studio.css", {}),
  "icon.svg": readFileSync("icon.svg"),
};
rmSync(output, { recursive: true, force: true });
mkdirSync(output, { recursive: true });
// Plain, as the program puts a nonce into it.
writeFileSync(join(output, "index.html"), readFileSync("index.html"));
let total = readFileSync("index.html").length;
for (const [name, bytes] of Object.entries(files)) {
  // Not by node's own, which packs otherwise from one version to the next.
  const zipped = execFileSync("gzip", ["-9nc"], { input: bytes, maxBuffer: 1 << 26 });
  writeFileSync(join(output, `${name}.gz`), zipped);
  total += zipped.length;
}
if (total > MOST_GZIPPED_BYTES) throw new Error(`${total} bytes gzipped; expected at most ${MOST_GZIPPED_BYTES}`);
console.log(`page: ${total} bytes gzipped`);
