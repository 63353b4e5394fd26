import assert from "node:assert/strict";
import { readFileSync, readdirSync, statSync } from "node:fs";
import { test } from "node:test";

function sources(folder: string): string[] {
  return readdirSync(folder).flatMap((name) => {
    const path = `${folder}/${name}`;
    return statSync(path).isDirectory() ? sources(path) : [path];
  });
}

function imports(path: string): string[] {
  return [...readFileSync(path, "utf8").matchAll(/(?:from|import)\s*\(?\s*"([^"]+)"/g)].map((match) => match[1]!);
}

test("imports are relative, or packages that package.json names", () => {
  const { dependencies } = JSON.parse(readFileSync("package.json", "utf8")) as { dependencies: Record<string, string> };
  for (const path of sources("src")) {
    for (const name of imports(path)) {
      if (name.startsWith("./") || name.startsWith("../") || name === "virtual:licences") continue;
      const packageName = name.split("/").slice(0, name.startsWith("@") ? 2 : 1).join("/");
      assert.ok(packageName in dependencies, `${path}: ${name}`);
    }
  }
});

test("what is pure needs neither panels nor the page", () => {
  for (const path of sources("src/core")) {
    for (const name of imports(path)) {
      assert.ok(name.startsWith("./") || name.startsWith("@codemirror/state"), `${path}: ${name}`);
    }
  }
});

test("versions are exact, and the lock names no host", () => {
  const { dependencies, devDependencies } = JSON.parse(readFileSync("package.json", "utf8")) as Record<string, Record<string, string>>;
  for (const [name, version] of Object.entries({ ...dependencies, ...devDependencies })) {
    assert.ok(/^\d+\.\d+\.\d+$/.test(version), `${name}: ${version}`);
  }
  const lock = readFileSync("package-lock.json", "utf8");
  assert.ok(!lock.includes('"resolved"'), "an address in package-lock.json");
  assert.equal(lock.match(/"node_modules\/[^"]+": \{/g)?.length, lock.match(/"integrity": "sha512-/g)?.length);
});

test("nothing is made of text that is not text", () => {
  for (const path of sources("src")) {
    const text = readFileSync(path, "utf8");
    for (const word of ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "new Function", "dangerouslySetInnerHTML"]) {
      assert.ok(!text.includes(word), `${path}: ${word}`);
    }
  }
});
