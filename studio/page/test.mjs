// Runs tests of the page: `node test.mjs [NAME...]`, in a folder that `npm ci` has filled; all without a name.

import { spawnSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { build } from "esbuild";

const ENDING = ".test.ts";
const all = readdirSync("test").filter((each) => each.endsWith(ENDING)).map((each) => each.slice(0, -ENDING.length));
const names = process.argv.length > 2 ? process.argv.slice(2) : all;
await build({
  entryPoints: names.map((each) => `test/${each}${ENDING}`),
  bundle: true,
  platform: "node",
  format: "esm",
  target: "node18",
  outdir: "test_output",
  outExtension: { ".js": ".mjs" },
  logLevel: "warning",
});
const { status } = spawnSync(process.execPath, ["--test", ...names.map((each) => `test_output/${each}.test.mjs`)], { stdio: "inherit" });
process.exit(status ?? 1);
