#!/usr/bin/env python3
"""What a new user tries: help, slips of the pen, animations, pipes."""
import fcntl
import json
import os
import pty
import shutil
import signal
import socket
import struct
import subprocess
import termios
import unittest

import animation
import scenes
from stored_pictures import exr
from tessera_process import PATIENCE, PROGRAM, TesseraTest, nightly

SMALL = ["--size", "48x32", "--workers", "0", "--threads", "1"]
MOVING = """
nodes { keys { time: 0 transform { steps { translate { } } } }
        keys { time: 1 transform { steps { translate { x: 1 } } } }
        shape { sphere { } } }
"""


class Help(TesseraTest):
    def test_lines_fit(self):
        for command in ["", "render", "serve", "worker", "submit", "status", "pause", "resume", "retry",
                        "cancel", "fetch", "convert", "info", "compare", "bench",
                        "bench rays", "bench octree", "bench farm"]:
            for line in self.run_program("help", *command.split()).out.splitlines():
                self.assertLessEqual(len(line), 100, line)

    def test_help_is_a_command(self):
        for command in (["render"], ["bench", "octree"], []):
            asked = self.run_program("help", *command)
            self.assertEqual((0, self.run_program(*command, "--help").out), (asked.code, asked.out))
        self.assert_error(self.run_program("help", "rendr"), 2, "'rendr'", "'render'")
        asked = self.run_program("help", "help")
        self.assertEqual((0, self.run_program("--help").out), (asked.code, asked.out))

    def test_each_bench_has_examples_of_its_own(self):
        for kind in ("", "rays", "octree", "farm"):
            own = self.run_program("help", "bench", *kind.split()).out
            self.assertIn(f"tessera bench {kind}", own.partition("Example")[2])
            self.assertNotIn("tessera render", own)

    def test_one_file_an_option(self):
        self.assertIn("--output FILE  ", self.run_program("help", "render").out)

    def test_a_question_ends_its_sentence(self):
        self.assertNotIn("?;", self.run_program("rendr").err + self.run_program("render", "--sise").err)


    def test_defaults_are_in_brackets(self):
        for command in ("serve", "worker", "status", "keygen", "render", "bench farm"):
            for line in self.run_program("help", *command.split()).out.splitlines():
                self.assertNotRegex(line, r"^ +-\S+ \S+=\S")
        self.assertIn("[tcp://127.0.0.1:7117]", self.run_program("help", "status").out)


class Names(TesseraTest):
    def test_the_file_beside_it(self):
        self.write("temple.x3d", "")
        for command in ("render", "info", "studio"):
            self.assert_error(self.run_program(command, "temple.x3"), 1,
                              "temple.x3: no such file; did you mean 'temple.x3d'?")
        self.assertNotIn("did you mean", self.run_program("info", "nothing-like-it.obj").err)


    def test_a_picture_for_a_scene(self):
        self.write("pawn.png", b"\x89PNG\r\n\x1a\n")
        for command in (["render"], ["render", "-o", "other.exr"], ["info"], ["convert"]):
            out = ["pawn.tessera"] if command == ["convert"] else []
            self.assert_error(self.run_program(*command, "pawn.png", *out), 1,
                              "pawn.png: a picture, which is no scene; expected one of .tessera")
        self.assertEqual(["pawn.png", "tmp"], sorted(p.name for p in self.folder.iterdir()))


class Places(TesseraTest):
    def assert_located(self, name, text, place):
        scene = self.write(name, text)
        for command in (["info"], ["render", *SMALL]):
            with self.subTest(text=text, command=command[0]):
                self.assert_error(self.run_program(*command, scene), 1, f"{name}:{place}: ")

    def test_errors_of_building_are_located(self):
        red = 'materials { name: "red" classic { } }\n'
        for place, text in [
                ("1:17", 'nodes { shape { materials: "rde" sphere { radius: -1 } } }\n'),
                ("2:26", red + 'nodes { shape { sphere { radius: -1 } } }\n'),
                ("2:17", red + 'nodes { shape { materials: ["red", "rde"] box { max { x: 1 y: 1 z: 1 } } } }\n'),
                ("3:41", red + 'nodes { name: "hall"\n  children { } children { shape { box { min '
                 '{ x: 3 } } } }\n}\n'),
                ("2:28", 'objects { name: "o"\n  nodes { shape { sphere { radius: -1 } } }\n}\n'
                 'nodes { name: "a > b" instance_of: "o" }\n'),
                ("1:50", 'materials { name: "m" classic { reflectivity { } shininess { value: -4 } } }\n'
                 'nodes { shape { materials: "m" sphere { } } }\n'),
                ("2:11", 'nodes {\n  light { spot { } }\n}\n'),
                ("1:25", 'cameras { perspective { field_of_view: 200 } }\n'),
                ("1:39", 'nodes { name: "a\\tb" shape { sphere { radius: -1 } } }\n'),
                ("1:9", 'nodes { instance_of: "p" }\n')]:
            self.assert_located("s.tessera", text, place)

    def test_errors_of_building_are_located_in_json(self):
        for place, text in [
                ("2:34", '{"nodes": [{}, {"shape": {"sphere":\n  {"center": {"x": 1}, "radius": -1}}}]}'),
                ("1:37", '{"nodes": [{"shape": {"materials": ["rde"], "sphere": {"radius": 1}}}]}'),
                ("2:16", '{"nodes": [{"shape":\n {"rectangle": {"edgeU": {"x": 1}, "edgeV": {"x": 2}}}}]}'),
                ("1:27", '{"nodes": [{"instanceOf": "p"}]}')]:
            self.assert_located("s.json", text, place)

    def test_no_place_is_better_than_a_wrong_one(self):
        twice = 'nodes { name: "a" shape { sphere { radius: 1 } } }\n'
        result = self.run_program("info", self.write("s.tessera", twice + twice.replace("1", "-1")))
        self.assert_error(result, 1, "s.tessera: node 'a'")
        self.write("s.tessera", 'nodes { shape { sphere { radius: -1 } } }')
        self.assertEqual(0, self.run_program("convert", "s.tessera", "s.tesserab").code)
        self.assert_error(self.run_program("info", "s.tesserab"), 1, "s.tesserab: node 1 > shape")


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


class ModelsAsTheyCome(TesseraTest):
    """Files that other programs write: of points, and with their insides out."""
    RENDER = "--size", "360x360", "--workers", "0", "--integrator", "albedo", "--quiet", "-o", "x.pfm"

    def colors(self, scene, *options):
        """How many pixels show more red, green and blue than the two others, by .06."""
        result = self.run_program("render", scene, *self.RENDER, *options)
        self.assertEqual(0, result.code, result.err)
        data = (self.folder / "x.pfm").read_bytes()
        numbers = struct.unpack(f"<{360 * 360 * 3}f", data[-360 * 360 * 12:])
        counts = [0, 0, 0]
        for at in range(0, len(numbers), 3):
            pixel = numbers[at:at + 3]
            if max(pixel) > sorted(pixel)[1] + .06:
                counts[pixel.index(max(pixel))] += 1
        return counts

    def test_points_are_seen_in_their_colours(self):
        head = "".join(f"property {line}\n" for line in (
            "float x", "float y", "float z", "uchar red", "uchar green", "uchar blue"))
        points = "".join(f"{x} {y} {z} {color}\n" for x in range(9) for y in range(9)
                         for z, color in enumerate(("255 0 0", "0 255 0", "0 0 255")))
        scene = self.write("points.ply", "ply\nformat ascii 1.0\nelement vertex 243\n"
                                         f"{head}end_header\n{points}")
        for count in self.colors(scene):
            self.assertGreater(count, 40)

    def test_lines_are_seen(self):
        box = json.dumps({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
                          "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 2, "material": 0}]}],
                          "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}],
                          "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}],
                          "bufferViews": [{"buffer": 0, "byteLength": 48}],
                          "buffers": [{"byteLength": 48, "uri": "square.bin"}]})
        self.write("square.bin", struct.pack("<12f", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0))
        red, green, blue = self.colors(self.write("square.gltf", box), "--view", "front")
        self.assertGreater(red, 150)
        self.assertEqual((0, 0), (green, blue))

    def test_back_faces_are_seen_on_demand(self):
        scene = self.write("back.tessera", """
            cameras { frame_all: true } materials { name: 'm' sides: FRONT_ONLY
              classic { diffuse { value { g: 1 } } } }
            nodes { transform { steps { rotate { axis { y: 1 } angle: 180 } } }
                    shape { disc { } materials: 'm' } }""")
        self.assertEqual([0, 0, 0], self.colors(scene))
        for option in ("--two-sided", "--x3d-two-sided"):
            self.assertGreater(self.colors(scene, option)[1], 1000)
        self.assertEqual(0, self.run_program("convert", scene, "seen.tessera", "--two-sided").code)
        self.assertGreater(self.colors("seen.tessera")[1], 1000)


class StandardViews(TesseraTest):
    SIDES = {"front": (0, 0, 2), "back": (0, 0, -2), "right": (2, 0, 0), "left": (-2, 0, 0), "top": (0, 2, 0),
             "bottom": (0, -2, 0)}
    RENDER = "--size", "9x9", "--workers", "0", "--integrator", "albedo", "--quiet"

    def setUp(self):
        """A sphere of a grey of its own on each side, and a viewpoint that looks away."""
        super().setUp()
        shapes = "".join(
            f"<Transform translation='{x} {y} {z}'><Shape><Appearance><Material diffuseColor='{i / 10} 0 0'/>"
            "</Appearance><Sphere/></Shape></Transform>"
            for i, (x, y, z) in enumerate(self.SIDES.values(), 1))
        self.scene = self.write("sides.x3d", "<X3D><Scene><Viewpoint position='0 0 90' orientation='0 1 0 3'/>"
                                             f"{shapes}</Scene></X3D>")

    def side(self, picture):
        """Which is in its middle."""
        data = (self.folder / picture).read_bytes()
        red = struct.unpack_from("<f", data, len(data) - 9 * 9 * 12 + (4 * 9 + 4) * 12)[0]
        return list(self.SIDES)[round(red * 10) - 1]

    def seen(self, *options):
        result = self.run_program("render", self.scene, *self.RENDER, *options, "-o", "x.pfm")
        self.assertEqual(0, result.code, result.err)
        return self.side("x.pfm")

    def test_each_side(self):
        for view in self.SIDES:
            self.assertEqual(view, self.seen("--view", view))
        upright = {"front": "bottom", "back": "top", "top": "front", "bottom": "back", "left": "left",
                   "right": "right"}
        for view, seen in upright.items():
            self.assertEqual(seen, self.seen("--view", view, "--up", "z"))

    def test_a_turntable_goes_around(self):
        result = self.run_program("render", self.scene, *self.RENDER, "--view", "front", "--turntable", "4",
                                  "-o", "x.png", "-o", "all.gif", "-o", "y.pfm")
        self.assertEqual(0, result.code, result.err)
        frames = [self.folder / f"x.{frame:04}.png" for frame in range(4)]
        self.assertEqual(sorted(self.folder.glob("x.*.png")), frames)
        self.assertEqual(4, len(animation.read_gif(self.folder / "all.gif")[0]))
        self.assertEqual(["front", "right", "back", "left"],
                         [self.side(f"y.{frame:04}.pfm") for frame in range(4)])

    def test_a_panorama_is_the_light_of_a_model(self):
        self.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        sky = self.write("bright.tessera", "background { solid { r: 3 g: 2 b: 1 } } nodes { shape { sphere { } } }")
        self.assertEqual(0, self.run_program("render", sky, "--size", "4x2", "-o", "sky.exr").code)
        around = self.run_program("convert", "t.obj", "t.tessera", "--environment", "sky.exr")
        self.assertEqual((0, ""), (around.code, around.err))
        text = (self.folder / "t.tessera").read_text()
        self.assertIn("panorama", text)
        self.assertNotIn("light {", text)
        self.assertNotIn("rings", text)
        latin_1 = os.fsdecode(b"sky\xff.exr")
        shutil.copy(self.folder / "sky.exr", self.folder / latin_1)
        stats = self.render("t.obj", "--size", "9x9", "--workers", "0", "--environment", latin_1)
        self.assertEqual("path", stats["integrator_chosen"])
        self.assert_error(self.run_program("render", "t.obj", "--environment", "none.exr"), 2, "none.exr")
        self.assert_error(self.run_program("render", "t.obj", "--environment", "."), 2, "is a folder; expected a file")

    def test_benchmarks_are_a_program_beside_this_one(self):
        alone = shutil.copy(PROGRAM, self.folder / "tessera")
        done = subprocess.run([alone, "bench", "rays"], capture_output=True, text=True)
        self.assertEqual(3, done.returncode)
        self.assertIn(f"{self.folder}/tessera-bench: No such file or directory", done.stderr)

    def test_only_one_says_what_is_seen_when(self):
        for options, names in ((("--view", "top", "--camera", "1"), ("--view", "--camera")),
                               (("--turntable", "2", "--camera", "1"), ("--turntable", "--camera")),
                               (("--turntable", "2", "--frames", "3"), ("--turntable", "--frames")),
                               (("--turntable", "2", "--time", "3"), ("--time", "--turntable"))):
            self.assert_error(self.run_program("render", self.scene, *options), 2, *names)
        self.assert_error(self.run_program("render", self.scene, "--view", "tpo"), 2, "'tpo'", "'top'")


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


class Views(TesseraTest):
    def test_numbers_that_the_file_cannot_hold(self):
        scene = self.write("s.tessera", scenes.ONE_SPHERE)
        for view, name, count in [("depth", "x.png", 1), ("cost", "x.png", 1), ("samples", "x.png", 1),
                                  ("error", "x.png", 1), ("depth", "x.exr", 0), ("ids", "x.png", 0),
                                  ("path", "x.png", 0)]:
            with self.subTest(view=view, name=name):
                result = self.run_program("render", scene, *SMALL, "--integrator", view, "-o", name)
                self.assertEqual(0, result.code, result.err)
                self.assertEqual(count, result.err.count(f"'{view}' shows numbers"), result.err)


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

    def piped(self, given, *arguments, code=0):
        """Standard output, as bytes, and standard error of a command that reads those bytes."""
        result = subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, input=given,
                                env=self.environment(), capture_output=True, timeout=PATIENCE)
        self.assertEqual(code, result.returncode, result.stderr)
        return result.stdout, result.stderr.decode()

    def test_a_scene_from_standard_input_and_a_picture_to_standard_output(self):
        self.assertEqual(0, self.run_program("render", self.scene, *SMALL, "-o", "a.png", "-o",
                                             "a.exr").code)
        text = self.scene.read_bytes()
        for output, same in (("-", "a.png"), ("-.exr", "a.exr")):
            picture, told = self.piped(text, "render", "-", "--format", "tessera", "-o", output, *SMALL)
            self.assertEqual((self.folder / same).read_bytes(), picture)
            self.assertEqual("", told)
        # The content may tell the format; the picture's name is then that of the input.
        written, _ = self.piped(b'{"nodes": [{"shape": {"sphere": {}}}]}', "render", "-", *SMALL)
        self.assertTrue(written.startswith(b"stdin.png  48x32"), written)
        animation_file, _ = self.piped(text, "render", "-", "--format", "tessera", *SMALL, "--frames",
                                       "0-1", "-o", "-.apng")
        self.assertEqual(2, animation_file.count(b"fcTL"))

    def test_what_stands_beside_standard_input_is_in_the_current_folder(self):
        self.write("red.mtl", "newmtl red\nKd 1 0 0\n")
        obj = b"mtllib red.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        self.piped(obj, "convert", "-", "a.json", "--format", "obj")
        self.assertIn('"red"', (self.folder / "a.json").read_text())
        information, _ = self.piped(obj, "info", "-", "--format", "obj")
        self.assertRegex(information, rb"triangles +1\n")

    def test_standard_input_that_is_no_scene(self):
        for given, arguments, expected in (
                (b"nodes {", ["--format", "tessera"], "stdin:1:"), (b"", [], "stdin: the file is empty"),
                (b"nodes { }", [], "stdin: the name has no ending"),
                (b"x", ["--format", "objj"], "did you mean 'obj'")):
            for command in (["render", "-"], ["convert", "-", "a.json"]):
                _, told = self.piped(given, *command, *arguments,
                                     code=2 if "objj" in arguments else 1)
                self.assertIn(expected, told)

    def test_what_cannot_go_to_standard_output(self):
        for options, expected in ((["-o", "-", "-o", "-.exr"], "given twice"),
                                  (["-o", "-", "--stats", "-"], "given twice"),
                                  (["-o", "-", "--frames", "0-1"], "'-.apng'"),
                                  (["-o", "-", "--resume"], "--resume"),
                                  (["-o", "-", "--progressive"], "--progressive"),
                                  (["-o", "-.pgn"], "did you mean 'png'")):
            self.assert_error(self.run_program("render", self.scene, *options), 2, expected)
        main, terminal = pty.openpty()
        self.assert_error(self.run_program("render", self.scene, "-o", "-", stdout=terminal), 2,
                          "is a terminal")
        for descriptor in (main, terminal):
            os.close(descriptor)
        full = self.run_program("render", self.scene, *SMALL, "-o", "-", stdout=open("/dev/full", "w"))
        self.assert_error(full, 3, "standard output", "No space left")


class Farm(TesseraTest):
    def test_everyone_tells_what_happens(self):
        scene = self.write("scene.tessera", scenes.ONE_SPHERE)
        with open(self.folder / "serve", "w") as log:
            serve = self.start("serve", "--bind", "tcp://127.0.0.1:*", stderr=log)
        endpoint = serve.stdout.readline().split()[-1]
        render = self.start("render", scene, "--connect", endpoint)
        self.assertIn("waiting for workers", render.stderr.readline())
        logs = {}
        for name, options in (("loud", []), ("quiet", ["--quiet"])):
            logs[name] = self.start("worker", "--connect", endpoint, "--threads", 1, *options)
        self.assertEqual(0, render.wait(PATIENCE))
        serve.terminate()
        self.assertEqual(0, serve.wait(PATIENCE))
        told = {name: worker.communicate(timeout=PATIENCE)[1] for name, worker in logs.items()}
        self.assertEqual("", told["quiet"])
        self.assertRegex(told["loud"], rf"(?s)connecting to {endpoint}\n.*connected, with 1 thread\n"
                         ".*the coordinator has ended: ")
        served = (self.folder / "serve").read_text()
        self.assertRegex(served, r"(?s)with 1 thread\n.*job \w+ is done, traced in [\d.]+ s\n")
        self.assertRegex(served, r"job 1 has come: 1 frame of 960x540 pixels, 1 sample each, \d+ bytes")

    def test_nobody_there(self):
        scene = self.write("scene.tessera", scenes.ONE_SPHERE)
        result = self.run_program("render", scene, "--connect", "tcp://127.0.0.1:1")
        self.assertEqual(3, result.code)
        self.assertIn("nothing listens at tcp://127.0.0.1:1", result.err.splitlines()[-1])

    @nightly
    def test_somebody_there_who_says_nothing(self):
        scene = self.write("scene.tessera", scenes.ONE_SPHERE)
        with socket.create_server(("127.0.0.1", 0)) as mute:
            endpoint = f"tcp://127.0.0.1:{mute.getsockname()[1]}"
            result = self.run_program("render", scene, "--connect", endpoint)
        self.assertEqual(3, result.code)
        lines = result.err.splitlines()
        self.assertIn(endpoint, lines[-1])
        self.assertLess(1, len(lines))
        for line in lines[:-1]:
            self.assertIn(f"waiting for the coordinator at {endpoint}", line)


class Terminal(TesseraTest):
    def test_a_bar_fits_and_shows_no_job_of_no_tiles(self):
        scene = self.write("scene.tessera", scenes.glass_scene())
        child, terminal = pty.fork()
        if child == 0:
            os.chdir(self.folder)
            fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 40, 0, 0))
            os.execve(PROGRAM, ["tessera", "render", str(scene), "--size", "640x480", "--spp", "4096",
                                "--workers", "2"], self.environment())
        shown = b""
        try:
            while part := os.read(terminal, 4096):
                shown += part
                if shown.count(b"\r\x1b[K") == 8:
                    os.kill(child, signal.SIGINT)
        except OSError:
            pass  # the other end is closed
        os.close(terminal)
        self.assertEqual(4, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), shown)
        bars = shown.decode().split("\r\x1b[K")[1:-1]
        self.assertGreater(len(bars), 6)
        for bar in bars:
            self.assertLess(len(bar), 40, bar)
            self.assertRegex(bar, r"^(\[=*> *\] )? *\d+ %  \d+/\d+ tiles(  waiting for workers|"
                                  r"  [12] workers?(  ETA [\d.:]+( s)?)?)?$")
            self.assertNotIn("0/0", bar)


class Compare(TesseraTest):
    def test_where(self):
        for name, at in (("a.ppm", None), ("b.ppm", [(2, 1, 30), (4, 3, 90)])):
            pixels = bytearray(6 * 5 * 3)
            for x, y, value in at or []:
                pixels[3 * (6 * y + x)] = value
            self.write(name, b"P6\n6 5\n255\n" + bytes(pixels))
        shown = self.run_program("compare", "a.ppm", "b.ppm")
        self.assertEqual(1, shown.code)
        self.assertRegex(shown.out, r"differing pixels +2 of 30\n")
        self.assertRegex(shown.out, r"all of them in +2,1,5,4\n")
        self.assertRegex(shown.out, r"worst pixel +4,3: \(0, 0, 0\) and \(0\.3529\d+, 0, 0\)\n")
        self.assertRegex(shown.out, r"at most +R by 0\.3529\d+\n")
        self.assertNotIn("worst", self.run_program("compare", "a.ppm", "a.ppm").out)

    def tga(self, name, *pixels):
        """One row of blue, green, red and, if they have it, alpha."""
        depth = len(pixels[0])
        header = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, len(pixels), 1, 8 * depth,
                             8 * (depth - 3) | 0x20)
        self.write(name, header + b"".join(map(bytes, pixels)))

    def test_alpha(self):
        self.tga("a.tga", (9, 8, 7, 255), (9, 8, 7, 0))
        self.tga("alpha.tga", (9, 8, 7, 255), (9, 8, 7, 51))
        self.tga("both.tga", (9, 8, 7, 204), (9, 8, 58, 0))
        self.tga("rgb.tga", (9, 8, 7), (9, 8, 7))
        self.assertEqual(0, self.run_program("compare", "a.tga", "a.tga").code)
        shown = self.run_program("compare", "a.tga", "alpha.tga")
        self.assertEqual(1, shown.code)
        self.assertRegex(shown.out, r"max difference +0\.2\d*\n")
        self.assertRegex(shown.out, r"at most +A by 0\.2\d*\n")
        # What nobody sees, behind an alpha of 0, is in the file all the same.
        self.assertRegex(self.run_program("compare", "a.tga", "both.tga").out,
                         r"at most +(R|A) by 0\.2\d*, (R|A) by 0\.(2|19)\d*\n")
        self.assert_error(self.run_program("compare", "a.tga", "rgb.tga"), 1, "channels differ",
                          "a.tga has R, G, B, A; rgb.tga has R, G, B")

    def test_aovs_of_one_picture_alone_are_left_out(self):
        colors = {"R": .5, "G": .25, "B": 1}
        self.write("plain.exr", exr(colors))
        self.write("aovs.exr", exr(colors | {"depth.Z": 4, "id.I": 2}))
        self.write("grey.exr", exr({"Y": .5, "depth.Z": 4}))
        self.write("darker.exr", exr(colors | {"R": .25, "depth.Z": 4, "normal.X": 1}))
        for pair in (["plain.exr", "aovs.exr"], ["aovs.exr", "plain.exr"]):
            result = self.run_program("compare", *pair)
            self.assertEqual(0, result.code, result.err)
            self.assertEqual("tessera: warning: aovs.exr: depth.Z, id.I left out; plain.exr has no such channel\n", result.err)
        both = self.run_program("compare", "aovs.exr", "darker.exr")
        self.assertEqual(1, both.code)
        self.assertRegex(both.out, r"at most +R by 0\.25\n")
        for left_out in ("aovs.exr: id.I left out", "darker.exr: normal.X left out"):
            self.assertIn(left_out, both.err)
        self.assert_error(self.run_program("compare", "plain.exr", "grey.exr"), 1, "channels differ")

    def test_missing(self):
        self.write("a.ppm", b"P6\n1 1\n255\n\0\0\0")
        self.assert_error(self.run_program("compare", "a.ppm", "aa.ppm"), 2,
                          "aa.ppm: no such file; did you mean 'a.ppm'?")


class Info(TesseraTest):
    def test_what_it_lists(self):
        scene = self.write("scene.tessera", scenes.SUN + scenes.material("red", "") +
                           "nodes { shape { sphere { radius: 2 } } }\n")
        found = json.loads(self.run_program("info", scene, "--json").out)
        for key in found["counts"]:
            self.assertRegex(key, "^[a-z_]+$")
        self.assertEqual(1, found["counts"]["lights_directional"])
        self.assertEqual(["red"], found["materials"])
        for side, corner in (("min", -2), ("max", 2)):
            for number in found["bounds"][side]:
                self.assertAlmostEqual(corner, number)
        shown = self.run_program("info", scene).out
        self.assertRegex(shown, r"camera +none: from \(0, 0, 10\) along -z")
        self.assertEqual(0, shown.count("bytes of blobs"))


class ChosenIntegrator(TesseraTest):
    def test_is_told(self):
        ball = 'nodes { shape { materials: "m" sphere { } } } materials { name: "m" classic { %s } }\n'
        glowing = ball % "diffuse { value { r: 1 } } emission { value { r: 1 } }"
        for text, asked, chosen in [
                (glowing, "auto", "path"), (glowing + scenes.SUN, "auto", "whitted"),
                (glowing + scenes.SUN + 'settings { integrator { kind: "path" } }', "path", "path"),
                (glowing + 'settings { integrator { kind: "depth" } }', "depth", "depth")]:
            with self.subTest(text=text):
                scene = self.write("scene.tessera", text)
                found = json.loads(self.run_program("info", scene, "--json").out)
                self.assertEqual((asked, chosen), (found["integrator"], found["integrator_chosen"]))
                told = chosen + (", chosen by auto" if asked == "auto" else "")
                self.assertRegex(self.run_program("info", scene).out, f"integrator +{told}\n")
                stats = self.render(scene, *SMALL)
                self.assertEqual((asked, chosen), (stats["integrator"], stats["integrator_chosen"]))


class HostileNames(TesseraTest):
    NAME = "\x1b[2J\x07\u009b31m"

    def assert_harmless(self, result):
        for sign in self.NAME[0], self.NAME[4], self.NAME[5]:
            self.assertNotIn(sign, result.out + result.err)
        self.assertIn("[2J", result.out + result.err)

    def test_no_terminal_is_told_what_to_do(self):
        written = json.dumps(self.NAME)[1:-1].replace("\\u00", "\\x").replace(
            "\\x9b", "\\302\\233")
        camera = scenes.CAMERA.replace('"front"', f'"{written}"')
        scene = self.write("scene.tessera", camera + scenes.material(written, "") +
                           "nodes { shape { sphere { } } }\n")
        self.assertEqual(self.NAME, json.loads(self.run_program("info", scene, "--json").out)["cameras"][0])
        for options in (["info", scene], ["info", scene, "--json"],
                        ["render", scene, "--camera", "no such"]):
            with self.subTest(options=options):
                self.assert_harmless(self.run_program(*options))
        scene = self.write("scene.tessera", f'nodes {{ shape {{ materials: "{written}" sphere {{ }} }} }}')
        for command in ("info", "render"):
            self.assert_harmless(self.run_program(command, scene))


class ScriptErrors(TesseraTest):
    def test_the_line_and_a_caret_stand_below(self):
        line = "  Sphere { center -> vec3(0, 0, 0) material -> white radius -> nought }"
        at = line.index("nought")
        scene = self.write("s.crt", f"white = Material {{ color -> rgb(1, 1, 1) }}\nScene {{\n{line}\n}}\n")
        for command in ("info", "render"):
            lines = self.run_program(command, scene).err.splitlines()
            self.assertEqual(3, len(lines), lines)
            self.assertTrue(lines[0].startswith("tessera: "), lines)
            self.assertIn(f"s.crt:3:{at + 1}: ", lines[0])
            self.assertEqual(f"    3 | {line}", lines[1])
            self.assertEqual(f"      | {' ' * at}^^^^^^", lines[2])


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
