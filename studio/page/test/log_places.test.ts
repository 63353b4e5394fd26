import assert from "node:assert/strict";
import { test } from "node:test";
import { placeIn } from "../src/core/log_places.js";

const files = new Set(["a.tessera", "b/c.crt"]);

test("a line of the log leads to the file and line that it names", () => {
  const place = (text: string) => placeIn(text, "/opened", files);
  assert.deepEqual(place("full picture 1 of 'a.tessera': /opened/a.tessera:3:7: found x"), { file: "a.tessera", line: 3, column: 7 });
  assert.deepEqual(place("b/c.crt:12: expected y"), { file: "b/c.crt", line: 12, column: 1 });
  assert.equal(place("a worker has come: host:1234"), undefined);
  assert.equal(place("/elsewhere/a.tessera:3:7: found x"), undefined);
  assert.equal(place("at 12:30:15 all was well"), undefined);
});
