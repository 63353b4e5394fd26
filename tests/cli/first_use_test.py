#!/usr/bin/env python3
"""What a new user tries: help, slips of the pen, animations, pipes."""
import json
import os
import unittest

import scenes
from tessera_process import TesseraTest

SMALL = ["--size", "48x32", "--workers", "0", "--threads", "1"]
MOVING = """
nodes { keys { time: 0 transform { } } keys { time: 1 transform { steps { translate { x: 1 } } } }
        shape { sphere { } } }
"""


class Help(TesseraTest):
    def test_lines_fit(self):
        for command in ["", "render", "serve", "worker", "convert", "info", "compare", "bench",
                        "bench rays", "bench octree", "bench farm"]:
            for line in self.run_program("help", *command.split()).out.splitlines():
                self.assertLessEqual(len(line), 100, line)

    def test_help_is_a_command(self):
        for command in (["render"], ["bench", "octree"], []):
            asked = self.run_program("help", *command)
            self.assertEqual((0, self.run_program(*command, "--help").out), (asked.code, asked.out))
        self.assert_error(self.run_program("help", "rendr"), 2, "'rendr'", "'render'")

    def test_each_bench_has_examples_of_its_own(self):
        for kind in ("", "rays", "octree", "farm"):
            own = self.run_program("help", "bench", *kind.split()).out
            self.assertIn(f"tessera bench {kind}", own.partition("Example")[2])
            self.assertNotIn("tessera render", own)

    def test_one_file_an_option(self):
        self.assertIn("--output FILE  ", self.run_program("help", "render").out)

    def test_a_question_ends_its_sentence(self):
        self.assertNotIn("?;", self.run_program("rendr").err + self.run_program("render", "--sise").err)


class Names(TesseraTest):
    def test_the_file_beside_it(self):
        self.write("temple.x3d", "")
        for command in ("render", "info"):
            self.assert_error(self.run_program(command, "temple.x3"), 1,
                              "temple.x3: no such file; did you mean 'temple.x3d'?")
        self.assertNotIn("did you mean", self.run_program("info", "nothing-like-it.obj").err)


class Frames(TesseraTest):
    def setUp(self):
        super().setUp()
        self.still = self.write("still.tessera", scenes.ONE_SPHERE)
        self.moving = self.write("moving.tessera", scenes.CAMERA + scenes.SUN + MOVING)

    def test_times_are_of_the_frame(self):
        result = self.run_program("render", self.still, *SMALL, "--frames", "1-12", "--stats", "s.json")
        self.assertEqual(0, result.code, result.err)
        stats = [json.loads(path.read_text()) for path in sorted(self.folder.glob("s.*.json"))]
        parse = [frame["seconds"]["parse"] for frame in stats]
        self.assertGreater(parse[0], 0)
        self.assertEqual([0] * 11, parse[1:])
        # Each frame's own span, and so no longer than the whole run; sums of sums would be.
        totals = [frame["seconds"]["total"] for frame in stats]
        self.assertNotEqual(totals, sorted(totals), "cumulative")

    def test_an_instant_beside_frames(self):
        self.assert_error(self.run_program("render", self.moving, "--frames", "0-1", "--time", "1"), 2,
                          "--time", "--frames")

    def test_a_still_scene(self):
        for scene, count in ((self.still, 1), (self.moving, 0)):
            result = self.run_program("render", scene, *SMALL, "--frames", "1-3")
            self.assertEqual(count, result.err.count("depends on the frame"), result.err)
        self.assertEqual("", self.run_program("render", self.still, *SMALL, "--frames", "1-3",
                                              "--quiet").err)


class Darkness(TesseraTest):
    def test_no_light(self):
        ball = "nodes { shape { materials: 'm' sphere { } } }\n"
        dark = ball + "materials { name: 'm' classic { } }\n"
        for text, count in [
                (dark, 1), (dark + "background { solid { } }", 1), (dark + "background { solid { r: 1 } }", 0),
                (dark + scenes.SUN, 0), (dark + "nodes { light { off: true point { } } }", 1),
                (dark + "settings { integrator { kind: 'normals' } }", 0),
                (ball + "materials { name: 'm' classic { emission { value { r: 1 } } } }", 0),
                (dark + "cameras { headlight { directional { direction { z: -1 } } } }", 0)]:
            for command in (["render", *SMALL], ["info"]):
                with self.subTest(text=text, command=command[0]):
                    result = self.run_program(*command, self.write("s.tessera", text))
                    self.assertEqual(0, result.code, result.err)
                    self.assertEqual(count, (result.out + result.err).count("will be black"))


class Pipes(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.ONE_SPHERE)

    def test_statistics_to_standard_output(self):
        result = self.run_program("render", self.scene, *SMALL, "--stats", "-")
        self.assertEqual(0, result.code, result.err)
        self.assertEqual(48, json.loads(result.out)["width"])
        self.assertEqual(["scene.png", "scene.tessera", "tmp"],
                         sorted(os.listdir(self.folder)))

    def test_pictures_and_scenes_are_files(self):
        self.assert_error(self.run_program("render", self.scene, "-o", "-"), 2, "--output", "'-'")
        self.assert_error(self.run_program("render", "-"), 2, "SCENE", "'-'")


class Grammar(TesseraTest):
    def test_one_of_a_kind(self):
        scene = self.write("scene.tessera", "cameras { name: 'a' }\n" + scenes.SUN +
                           "nodes { shape { sphere { } } }\n")
        shown = self.run_program("render", scene, "--size", "8x8", "--workers", "1").out
        self.assertRegex(shown, r"1 tile by 1 worker, 0 retries")
        self.assertIn("1 sample per pixel", self.run_program("info", scene).out)
        self.assertIn("1 camera:", self.run_program("render", scene, "--camera", "b").err)


if __name__ == "__main__":
    unittest.main()
