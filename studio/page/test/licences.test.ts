import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

interface Lock {
  packages: Record<string, { dev?: boolean; optional?: boolean }>;
}

test("the copyright file of the package names what the page ships, and nothing that it does not", () => {
  const stanzas = readFileSync("copyright", "utf8").split("\n\n");
  const named = stanzas
    .filter((each) => each.startsWith("Files: ") && each.endsWith("License: Expat"))
    .flatMap((each) => each.slice("Files: ".length, each.indexOf("\nCopyright:")).split(/\s+/))
    .filter((each) => !each.endsWith("-dev"));
  const { packages } = JSON.parse(readFileSync("package-lock.json", "utf8")) as Lock;
  const shipped = Object.entries(packages).filter(([path, entry]) => path !== "" && !entry.dev && !entry.optional);
  assert.deepEqual(named.sort(), shipped.map(([path]) => path.slice("node_modules/".length)).sort());
});
