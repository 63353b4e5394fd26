#!/usr/bin/env python3
"""A click on the picture leads to the text that made what it shows: exactly, and whatever the language."""
import os
import pathlib
import random
import struct
import unittest

from studio_case import StudioTest

SIZE = (160, 100)
SAMPLES = pathlib.Path(__file__).resolve().parents[2] / "scenes" / "samples"
SCENE = """cameras { world_from_camera { steps { translate { z: 10 } } } orthographic { min_x: -3.2 min_y: -2 max_x: 3.2 max_y: 2 } }
nodes { light { directional { direction { z: -1 } } } }
materials { name: "red" classic { diffuse { value { r: .75 } } } }
nodes {
  name: "ball"
  transform { steps { translate { x: -1.5 } } }
  shape { materials: "red" sphere {} }
}
includes { file: "part.crt" transform { steps { translate { x: 1.5 } } } }
"""
PART = """Settings { camera -> Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> .8 } }
white = Material { color -> rgb(1, 1, 1) }
block = Macro(y) {
  Box { cornerA -> vec3(-1, y, -1) cornerB -> vec3(1, y + .8, 1) material -> white }
}
Scene {
  i = 0
  while (i < 2) { block(i - 1)  i = i + 1 }
}
"""


class Picking(StudioTest):
    def begin(self, file, folder=None):
        self.running = self.studio("--workers", 1, *(["--read-only"] if folder else []), path=folder)
        self.said = self.page(self.running)
        self.open(self.said, file)
        self.show(self.said, file, SIZE, camera=None, mode="typing")
        self.said.receive("job", where=lambda job: job["state"] == "done")

    def pick(self, x, y):
        self.said.say("pick", pane=0, x=x, y=y)
        return self.said.receive("picked", where=lambda picked: (picked["x"], picked["y"]) == (x, y))

    def parts(self):
        """The part picture, and its table with the links in place."""
        self.said.forget()
        self.said.say("parts", pane=0)
        table = self.said.receive("parts")
        frame = self.said.receive("pixels", where=lambda pixels: pixels.kind == 2)
        self.assertEqual((table["serial"], SIZE), (frame.serial, frame.picture))
        numbers = struct.unpack(f"<{SIZE[0] * SIZE[1]}I", frame.rgba)
        return numbers, [[table["links"][i] for i in chain["links"]] for chain in table["chains"]]

    def selected(self, picked, text):
        """What the page would select in the text."""
        link = picked["chain"][picked["at"]]
        lines = text.splitlines(keepends=True)
        begin = sum(map(len, lines[:link["line"] - 1])) + link["column"] - 1
        end = sum(map(len, lines[:link["end_line"] - 1])) + link["end_column"] - 1
        return text[begin:end]

    def test_a_click_selects_the_text_of_what_it_meets(self):
        self.scene("scene.tessera", SCENE)
        self.scene("part.crt", PART)
        self.begin("scene.tessera")
        ball = self.pick(42, 50)
        self.assertTrue(self.selected(ball, SCENE).startswith('nodes {\n  name: "ball"'))
        self.assertTrue(self.selected(ball, SCENE).endswith("sphere {} }\n}"))
        self.assertEqual([("material", "red"), ("node", "ball")],
                         [(link["kind"], link["name"]) for link in ball["chain"]])
        self.assertAlmostEqual(-1.5, ball["point"][0], delta=.05)
        self.assertAlmostEqual(9, ball["depth"], delta=.01)
        box = self.pick(118, 60)
        self.assertTrue(self.selected(box, PART).startswith("Box {"), self.selected(box, PART))
        chain = box["chain"][box["at"]:]
        self.assertEqual([("part.crt", "Box"), ("part.crt", "block"), ("part.crt", "turn 1"),
                          ("scene.tessera", "part.crt")],
                         [(link["file"], link["name"]) for link in chain])
        self.assertEqual([4, 8, 8, 9], [link["line"] for link in chain])
        self.assertEqual("turn 2", self.pick(118, 40)["chain"][box["at"] + 2]["name"])
        nothing = self.pick(80, 3)
        self.assertEqual([], nothing["chain"])
        self.assertNotIn("point", nothing)

    def test_text_that_moves_is_followed_and_starts_nothing(self):
        self.scene("scene.tessera", SCENE)
        self.scene("part.crt", PART)
        self.begin("scene.tessera")
        before = self.pick(42, 50)
        note = "# Über 𝄞 a ball.\n"
        self.said.forget()
        self.said.say("edit", file="scene.tessera", base=1, changes=[[0, 0, note]])
        self.said.receive("summary", where=lambda summary: summary["version"] == 2)
        after = self.pick(42, 50)
        at = before["at"]
        self.assertEqual(before["chain"][at]["line"] + 1, after["chain"][at]["line"])
        self.assertEqual(before["chain"][at]["entity"], after["chain"][at]["entity"])
        self.assertEqual([], [each for kind, each in self.said.waiting if kind == "job" and "serial" in each])

    def test_picks_agree_with_the_part_picture_in_every_sample(self):
        found = 0
        for file in sorted(os.listdir(SAMPLES)):
            if file.rsplit(".", 1)[1] not in ("tessera", "crt", "x3d", "x3dv"):
                continue
            with self.subTest(file):
                self.begin(file, SAMPLES)
                numbers, chains = self.parts()
                draw = random.Random(file)
                for _ in range(int(os.environ.get("TESSERA_PICKS", "12"))):
                    x, y = draw.randrange(SIZE[0]), draw.randrange(SIZE[1])
                    picked = self.pick(x, y)
                    number = numbers[y * SIZE[0] + x]
                    if number == 0:
                        self.assertEqual([], picked["chain"])
                        continue
                    found += 1
                    about = ("face", "material")
                    self.assertEqual(
                        [link for link in chains[number - 1] if link["kind"] not in about],
                        [link for link in picked["chain"] if link["kind"] not in about])
                    link = picked["chain"][picked["at"]]
                    self.assertNotIn(link["kind"], about)
                    if link["file"] == file:
                        self.assertIn("entity", link)
                self.end_studio(self.running)
        self.assertGreater(found, 50)


if __name__ == "__main__":
    unittest.main()
