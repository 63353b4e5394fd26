#!/usr/bin/env python3
"""What the commands write and print when all is well."""
import json
import math
import os
import pty
import re
import signal
import time
import unittest

import animation
import browser
import scenes
from png import read_png
from tessera_process import PATIENCE, PROGRAM, SLOWER, TesseraTest, nightly, wait_until

SMALL = ["--size", "48x32", "--workers", "2"]
LONG = str(int(12 / SLOWER) + 1)  # samples: long enough to show progress


class Render(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())

    def test_the_default_output(self):
        (self.folder / "sub").mkdir()
        self.scene.rename(self.folder / "sub/view.one.tessera")
        result = self.run_program("render", "sub/view.one.tessera", *SMALL)
        self.assertEqual((0, ""), (result.code, "".join(re.findall("error.*", result.err))))
        self.assertTrue((self.folder / "view.one.png").read_bytes().startswith(b"\x89PNG"))
        self.assertIn("view.one.png", result.out)

    def test_several_outputs(self):
        result = self.run_program("render", self.scene, *SMALL, "-o", "a.png", "-o", "b.exr", "-o",
                                  "c.bmp")
        self.assertEqual(0, result.code, result.err)
        for name, magic in [("a.png", b"\x89PNG"), ("b.exr", b"\x76\x2f\x31\x01"), ("c.bmp", b"BM")]:
            self.assertTrue((self.folder / name).read_bytes().startswith(magic), name)

    def test_files_of_equal_pictures_are_equal(self):
        scene = self.write("scene.tessera", scenes.ONE_SPHERE)
        today = time.strftime("%Y:%m:%d").encode()
        for name in ("a.png", "a.exr", "a.jpg", "a.tif", "a.pfm"):
            files = []
            for workers in (0, 2):
                self.render(scene, "-o", name, "--size", "64x48", "--workers", workers)
                files.append((self.folder / name).read_bytes())
            self.assertEqual(*files, name)
            self.assertNotIn(today, files[0], name)

    def test_files_say_what_the_numbers_of_x3d_stand_for(self):
        scene = self.write("box.x3dv", "#X3D V3.3 utf8\nShape { geometry Box { } }")
        for how, colors in (("display", b"display"), ("linear", b"scene-linear")):
            result = self.run_program("render", scene, *SMALL, "--x3d-color", how, "-o", "a.exr")
            self.assertEqual(0, result.code, result.err)
            self.assertIn(b"tessera:Colors=" + colors, (self.folder / "a.exr").read_bytes())

    def test_quiet_is_silent(self):
        odd = self.write("odd.obj", "v 0 0 0\nv 0 0 0\nv 2 0 0\nf 1 2 3\n")
        loud = self.run_program("render", odd, *SMALL, "--exposure", "9")
        for warning in ("without an area", "no ray meets a surface", "brighter than white"):
            self.assertIn(warning, loud.err)
        for scene in (self.scene, odd):
            result = self.run_program("render", scene, *SMALL, "--exposure", "9", "--quiet")
            self.assertEqual((0, "", ""), (result.code, result.out, result.err))

    def test_piped_progress_is_plain_lines(self):
        process = self.start("render", self.scene, "--size", "640x480", "--spp", "4096", "--tile",
                             "16", "--workers", "1", "--threads", "1")
        lines = [process.stderr.readline() for _ in range(2)]
        process.send_signal(signal.SIGINT)
        out = process.communicate(timeout=PATIENCE)[0]
        self.assertEqual("", out)
        for line in lines:
            self.assertRegex(line, r"\A *\d+ %  \d+/1200 tiles[ -~]*\n\Z")

    def test_a_terminal_gets_a_bar_that_goes_away(self):
        child, terminal = pty.fork()
        if child == 0:
            os.chdir(self.folder)
            os.execve(PROGRAM, ["tessera", "render", str(self.scene), "--size", "640x480", "--spp",
                                LONG, "--workers", "2"], self.environment())
        shown = b""
        try:
            while part := os.read(terminal, 4096):
                shown += part
        except OSError:
            pass  # how a pseudo-terminal says that its other end is closed
        os.close(terminal)
        self.assertEqual(0, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), shown)
        self.assertRegex(shown.decode(), r"\r\x1b\[K\[=*>? *\] +\d+ %  \d+/\d+ tiles  2 workers")
        self.assertIn("\r\x1b[Kscene.png", shown.decode(), "the bar is wiped for the last line")

    def test_statistics(self):
        stats = self.render(self.scene, *SMALL, "--spp", "4", "--seed", "7", "--tile", "16")
        self.assertEqual((48, 32, 4, 7), tuple(
            stats[k] for k in ("width", "height", "samples_per_pixel", "seed")))
        self.assertRegex(stats["version"], r"^\d+\.\d+\.\d+")
        self.assertRegex(stats["scene"], "^[0-9a-f]{64}$")
        self.assertRegex(stats["pixels_sha256"], "^[0-9a-f]{64}$")
        self.assertEqual({"parse", "build", "trace", "assemble", "write", "total"},
                         set(stats["seconds"]))
        self.assertGreater(stats["seconds"]["total"], stats["seconds"]["trace"])
        rays = stats["rays"]
        self.assertEqual(48 * 32 * 4, stats["samples"])
        self.assertEqual(stats["samples"],
                         rays["primary"] + stats["skips"]["rays_background_skipped"])
        for kind in ("shadow", "reflection", "refraction"):
            self.assertGreater(rays[kind], 0, kind)
        self.assertEqual(rays["total"], sum(rays[k] for k in rays if k != "total"))
        for name in ("hits", "primitive_tests", "bytes_shipped", "peak_memory_bytes"):
            self.assertGreater(stats[name], 0, name)
        self.assertGreaterEqual(stats["node_visits"], 0)
        self.assertEqual({"total": 6, "done": 6, "restored": 0, "failed": 0, "filled": 0, "retries": 0,
                          "mismatches": 0, "verified": 0, "unverified": 0, "retraced": 0},
                         {k: v for k, v in stats["tiles"].items()
                          if k not in ("speculative", "duplicates", "split", "moved")})
        self.assertEqual(stats["bytes_shipped"], sum(stats["bytes"].values()))
        self.assertIsInstance(stats["skips"], dict)
        self.assertEqual(0, stats["workers"]["lost"])

    def test_what_looks_past_everything_is_filled(self):
        """Where the background is one colour: whole tiles are not even given out."""
        scene = self.write("solid.tessera", scenes.ONE_SPHERE.replace(
            "background { gradient", "background { solid { r: 0.1 g: 0.2 b: 0.3 } } #"))
        digests, counts = set(), set()
        for options in (["--workers", 0, "--tile", 16], ["--workers", 2, "--tile", 16, "--verify", "50%"],
                        ["--workers", 2, "--tile", 24]):
            stats = self.render(scene, "--size", "320x240", "--spp", 3, *options)
            digests.add(stats["pixels_sha256"])
            counts.add((stats["samples"], stats["skips"]["rays_background_skipped"]))
            self.assertGreater(stats["tiles"]["filled"], 0)
            self.assertEqual(0, stats["tiles"]["mismatches"])
            self.assertEqual(stats["tiles"]["total"], stats["tiles"]["done"])
        self.assertEqual((1, 1), (len(digests), len(counts)))

    def test_a_picture_brighter_than_white_is_told(self):
        self.write("bright.tessera", "background { solid { r: 4 g: 4 b: 4 } } nodes { shape { sphere { } } }")
        warned = self.run_program("render", "bright.tessera", *SMALL)
        self.assertRegex(warned.err, r"\d+ % of the picture is brighter than white; --exposure -2 would")
        for options in (["--exposure", "-2"], ["-o", "bright.exr"], ["--tone-map", "filmic"]):
            told = self.run_program("render", "bright.tessera", *SMALL, *options)
            self.assertNotIn("brighter", told.err, options)
        frames = self.run_program("render", "bright.tessera", *SMALL, "--frames", "3-5", "-o", "bright.png")
        self.assertEqual(1, frames.err.count("brighter"), frames.err)
        self.assertIn("frame 3: 97 % of the picture is brighter", frames.err)

    def test_exposure_by_the_picture(self):
        dark = (scenes.CAMERAS + "background { solid { r: 9 g: 9 b: 9 } }"
                'materials { name: "m" unlit { color { value { r: .01 g: .01 b: .01 } } } }'
                'nodes { shape { materials: "m" sphere { center { y: .5 } } }'
                "  keys { time: 0 transform { steps { scale { x: 1 y: 1 z: 1 } } } }"
                "  keys { time: 1 transform { steps { scale { x: 3 y: 3 z: 3 } } } } }")
        self.write("dark.tessera", dark)
        linear = []
        for options in ([], ["--exposure", "auto"]):
            linear.append(self.render("dark.tessera", *SMALL, "-o", "a.exr", *options)["pixels_sha256"])
            linear.append((self.folder / "a.exr").read_bytes())
        self.assertEqual(linear[:2], linear[2:], "light stays as it is")
        result = self.run_program("render", "dark.tessera", *SMALL, "--exposure", "auto", "-o", "a.png")
        self.assertEqual(0, result.code, result.err)
        stops, = re.findall(r"exposure chosen: --exposure (\S+)\n", result.err)
        self.assertAlmostEqual(math.log2(.18 / .01), float(stops), delta=.011)
        self.run_program("render", "dark.tessera", *SMALL, "--exposure", stops, "-o", "b.png")
        self.assertEqual((self.folder / "a.png").read_bytes(), (self.folder / "b.png").read_bytes())
        # Of surfaces alone: .18 in sRGB, in the middle of the ball, before a bright background.
        width, height, pixels = read_png(self.folder / "a.png")
        self.assertEqual(118, pixels[3 * (width * (height // 2) + width // 2)])
        # As the first frame has it.
        frames = self.run_program("render", "dark.tessera", *SMALL, "--exposure", "auto", "--frames", "0-2",
                                  "-o", "f.png")
        self.assertEqual(1, frames.err.count("exposure chosen"), frames.err)
        self.run_program("render", "dark.tessera", *SMALL, "--exposure", stops, "--frames", "0-2", "-o", "g.png")
        for frame in range(3):
            self.assertEqual(*((self.folder / f"{name}.000{frame}.png").read_bytes() for name in "fg"))
        quiet = self.run_program("render", "dark.tessera", *SMALL, "--exposure", "auto", "--quiet")
        self.assertNotIn("chosen", quiet.err)
        for command in ("render", "submit"):
            result = self.run_program(command, "dark.tessera", "--exposure", "autp")
            self.assert_error(result, 2, "--exposure", "'autp'", "a finite number")

    def test_frames(self):
        result = self.run_program("render", self.scene, *SMALL, "--frames", "3-5", "-o", "anim.png")
        self.assertEqual(0, result.code, result.err)
        self.assertEqual([f"anim.000{i}.png" for i in (3, 4, 5)],
                         sorted(p.name for p in self.folder.glob("*.png")))

    def test_animations_hold_the_pixels_of_their_frames(self):
        scene = self.write("moving.tessera", scenes.MOVING)
        result = self.run_program("render", scene, *SMALL, "--frames", "0-3", "-o", "f.png", "-o", "all.apng",
                                  "-o", "all.gif", "-o", "f.gif", "--fps", "12.5")
        self.assertEqual(0, result.code, result.err)
        self.assertIn("all.apng  4 frames, 12.5 a second", result.out)
        stills = [read_png(self.folder / f"f.000{i}.png") for i in range(4)]
        self.assertEqual(4, len(set(stills)), "the frames are alike: the test shows nothing")
        frames, delays = animation.read_apng(self.folder / "all.apng")
        self.assertTrue(stills == frames, "the frames differ")
        self.assertEqual([(2, 25)] * 4, delays)
        self.assertEqual("", result.err)
        frames, delays = animation.read_gif(self.folder / "all.gif")
        self.assertEqual([8] * 4, delays)
        for (width, height, wanted), frame in zip(stills, frames, strict=True):
            self.assertEqual((width, height), frame[:2])
            distance = sum(abs(a - b) for a, b in zip(wanted, frame[2], strict=True)) / len(wanted)
            self.assertLess(distance, 12, "a frame of 255 colours is another picture")

    def test_a_rate_that_a_gif_cannot_have_is_told(self):
        scene = self.write("moving.tessera", scenes.MOVING)
        result = self.run_program("render", scene, *SMALL, "--frames", "0-1", "-o", "all.apng", "-o", "all.gif",
                                  "--fps", "60")
        self.assertEqual(0, result.code, result.err)
        self.assertIn("'all.gif' shows 50 frames a second in place of 60", result.err)
        self.assertNotIn("'all.apng'", result.err)
        self.assertIn("all.gif  2 frames, 50 a second", result.out)
        self.assertIn("all.apng  2 frames, 60 a second", result.out)
        self.assertEqual([2, 2], animation.read_gif(self.folder / "all.gif")[1])

    @unittest.skipUnless(browser.PROGRAM, "NO CHROMIUM: what another program makes of animations is not tested")
    def test_another_program_shows_the_frames_of_animations(self):
        scene = self.write("moving.tessera", scenes.MOVING)
        result = self.run_program("render", scene, *SMALL, "--frames", "0-2", "-o", "all.apng", "-o", "all.gif",
                                  "-o", "f.png")
        self.assertEqual(0, result.code, result.err)
        self.assertIn("3 frames, 10 a second", result.out)
        page = browser.Page()
        stills = [read_png(self.folder / f"f.000{i}.png") for i in range(3)]
        try:
            decoded = [(name, *animation.decoded_by_browser(page, self.folder / name, kind))
                       for name, kind in (("all.apng", "image/png"), ("all.gif", "image/gif"))]
        finally:
            page.close()
        for name, frames, microseconds in decoded:
            self.assertEqual([100000] * 3, microseconds, name)
            if name == "all.apng":
                self.assertTrue(stills == frames, "the frames differ")
            else:
                self.assertTrue(animation.read_gif(self.folder / name)[0] == frames, "our own reader is wrong")

    def test_what_is_done_of_an_animation_is_written(self):
        process = self.start("render", self.write("moving.tessera", scenes.MOVING), "--size", "64x64", "--frames",
                             "0-5000", "-o", "f.png", "-o", "all.apng", "--workers", "1")
        wait_until(lambda: (self.folder / "f.0002.png").exists(), "two frames")
        process.terminate()
        process.communicate(timeout=PATIENCE)
        self.assertEqual(4, process.returncode)
        stills = [read_png(path) for path in sorted(self.folder.glob("f.*.png"))]
        self.assertTrue(stills == animation.read_apng(self.folder / "all.apng")[0], "the frames differ")

    def test_the_frame_that_cannot_be_read_is_named(self):
        script = self.write("turn.crt", """\
cam = Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 1) fov -> 60 }
Settings { camera -> cam }
Scene { Sphere { center -> vec3(0, 0, 0) material -> Material { color -> rgb(1, 1, 1) } radius -> [1, 2][t] } }
""")
        for command in [("render", script, "--size", "8x8", "-o", "f.png"), ("submit", script)]:
            result = self.run_program(*command, "--frames", "0-3")
            self.assertEqual(1, result.code)
            self.assertRegex(result.err, r"turn\.crt:3:\d+: the index 2; expected 0 to 1 \(in frame 2\)\n")

    def test_a_rate_needs_frames(self):
        self.assert_error(self.run_program("render", self.scene, "--fps", "10"), 2, "--fps", "--frames")
        for wrong in ("0", "-1", "nan", "x"):
            self.assert_error(self.run_program("render", self.scene, "--frames", "0-1", "--fps", wrong), 2, "--fps")

    def test_an_output_is_replaced(self):
        self.write("old.png", "old")
        self.assertEqual(0, self.run_program("render", self.scene, *SMALL, "-o", "old.png").code)
        self.assertTrue((self.folder / "old.png").read_bytes().startswith(b"\x89PNG"))


class OtherCommands(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.mesh_scene(6, 8))

    def test_help_teaches(self):
        whole = self.run_program("--help")
        self.assertEqual(0, whole.code)
        for command in ("render", "serve", "worker", "convert", "info", "compare"):
            self.assertIn(command, whole.out)
            own = self.run_program(command, "--help")
            self.assertEqual(0, own.code)
            self.assertRegex(own.out, r"Examples?[:,]")
        for option in ("-o", "--size", "--spp", "--workers", "--threads", "--tile", "--accel",
                       "--integrator", "--seed", "--crop", "--frames", "--time", "--camera",
                       "--resume", "--stats", "--quiet", "--connect", "--target-error", "--min-spp",
                       "--filter", "--pattern"):
            self.assertIn(option, self.run_program("render", "--help").out)

    def test_version(self):
        self.assertRegex(self.run_program("--version").out, r"^tessera \d+\.\d+\.\d+")

    def test_conversion_loses_nothing(self):
        before = json.loads(self.run_program("info", self.scene, "--json").out)
        last = self.scene
        for name in ("a.json", "b.tesserab", "c.tessera", "d.json"):
            self.assertEqual(0, self.run_program("convert", last, name).code)
            last = self.folder / name
            self.assertEqual(before, json.loads(self.run_program("info", last, "--json").out), name)
        self.assertEqual((self.folder / "a.json").read_bytes(), (self.folder / "d.json").read_bytes())

    def test_info_lists_what_is_unused(self):
        scene = self.write("more.tessera", scenes.material("idle", "") + scenes.ONE_SPHERE)
        found = json.loads(self.run_program("info", scene, "--json").out)
        self.assertTrue(any("idle" in line for line in found["unused"]), found)
        self.assertIn("idle", self.run_program("info", scene).out)

    def test_info_reads_textures(self):
        self.run_program("render", self.scene, "--size", "8x4", "-o", "brick.png")
        scene = self.write("wall.tessera", 'textures { name: "brick" image { file: "brick.png" } }\n'
                           'materials { name: "wall" classic { diffuse { texture: "brick" } } }\n'
                           'nodes { shape { materials: "wall" sphere { } } }\n')
        result = self.run_program("info", scene, "--json")
        self.assertEqual(0, result.code, result.err)
        self.assertEqual(0, self.run_program("convert", scene, "wall.tesserab").code)
        self.assertEqual(json.loads(self.run_program("info", "wall.tesserab", "--json").out),
                         json.loads(result.out))

    def test_compare(self):
        for seed, name in [(0, "a.exr"), (0, "b.exr"), (1, "c.exr")]:
            self.assertEqual(0, self.run_program("render", self.scene, *SMALL, "--spp", 2, "--seed",
                                                 seed, "-o", name).code)
        self.run_program("render", self.scene, "--size", "8x8", "-o", "small.exr")
        same = self.run_program("compare", "a.exr", "b.exr")
        self.assertEqual(0, same.code, same.out)
        self.assertRegex(same.out, r"max difference +0\n")
        other = self.run_program("compare", "a.exr", "c.exr")
        self.assertEqual(1, other.code)
        greatest = float(re.search(r"max difference +(\S+)", other.out)[1])
        self.assertEqual(0, self.run_program("compare", "a.exr", "c.exr", "--max-diff",
                                             greatest * 1.001).code)
        self.assertEqual(1, self.run_program("compare", "a.exr", "c.exr", "--max-diff",
                                             greatest * 0.999).code)
        self.assert_error(self.run_program("compare", "a.exr", "small.exr"), 1, "48x32", "8x8")
        self.assert_error(self.run_program("compare", "a.exr", "none.exr"), 2, "none.exr")
        self.write("text.png", "no picture")
        self.assert_error(self.run_program("compare", "a.exr", "text.png"), 2, "text.png")


class Bench(TesseraTest):
    def rows(self, *arguments):
        result = self.run_program("bench", *arguments, "--rounds", "1", "--json", "rows.json")
        self.assertEqual(0, result.code, result.err)
        return json.loads((self.folder / "rows.json").read_text())["rows"]

    @nightly
    def test_rays(self):
        mesh = self.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n"
                          "f 1 3 4\nf 2 3 4\n")
        rows = self.rows("rays", mesh, "soup:500")
        self.assertLessEqual({"primary", "shadow", "diffuse", "ao", "shuffled"},
                             {row["kind"] for row in rows})
        for row in rows:
            self.assertLessEqual({"scene", "accelerator", "kind", "mrays_per_second",
                                  "ratio_to_embree", "mismatches", "build_seconds",
                                  "bytes_per_triangle"}, set(row))
            self.assertEqual(0, row["mismatches"])
        self.assertLessEqual({"soup:500", "geometric mean"}, {row["scene"] for row in rows})
        result = self.run_program("bench", "rays", self.write("s.tessera", "nodes { shape { box {} } }"))
        self.assert_error(result, 1, "triangles")

    def test_octree(self):
        rows = self.rows("octree", "teapot", "--size", "32x18", "--compare")
        self.assertEqual(["bvh", "octree", "nonuniform-octree"], [row["accelerator"] for row in rows])
        for row in rows:
            self.assertEqual(0, row["differing_pixels"])
            self.assertLessEqual({"scene", "depth", "voxels", "object_tests_per_ray",
                                  "node_visits_per_ray", "seconds"}, set(row))

    def test_unknown_scenes(self):
        self.assert_error(self.run_program("bench", "octree", "nowhere.obj"), 1, "nowhere.obj")
        self.assert_error(self.run_program("bench", "rays", "icosfere:3"), 2, "icosfere")


if __name__ == "__main__":
    unittest.main()
