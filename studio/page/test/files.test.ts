import { said } from "./socket_worker.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { use } from "../src/panels/files.js";
import * as state from "../src/state.js";

test("a picture says what it is and how it is used", () => {
  for (const name of ["sky.png", "maps/wall.GIF"]) {
    state.notices.value = [];
    use({ name, kind: "picture", size: 1234 });
    assert.deepEqual(state.notices.value.map((each) => each.text), [`${name} is a picture of 1.2 kB. Scenes use it by its name, as the file of a texture or of a panorama.`]);
  }
  assert.deepEqual(said, []);
});
