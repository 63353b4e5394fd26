#!/usr/bin/env python3
"""Wrong files, names, sizes and places: one clear line, the right exit code, nothing half-written."""
import base64
import json
import math
import re
import resource
import shutil
import socket
import struct
import unittest

import scenes
import stored_pictures
from tessera_process import PATIENCE, PROGRAM, SLOWER, TesseraTest, heed_permissions


class BadCommandLine(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.ONE_SPHERE)

    def refused(self, *arguments, says, **options):
        result = self.run_program(*arguments, **options)
        self.assert_error(result, 2, *says)
        self.assertEqual("", result.out)
        self.assertEqual(["scene.tessera", "tmp"], sorted(p.name for p in self.folder.iterdir()))

    def test_no_command_and_unknown_ones(self):
        self.refused(says=["no command"])
        self.refused("rendr", self.scene, says=["'rendr'", "'render'"])
        self.refused("render", self.scene, "--sise", "8x8", says=["'--sise'", "'--size'"])
        self.refused("render", says=["SCENE"])
        self.refused("render", self.scene, "more", says=["'more'"])
        self.refused("worker", says=["--connect"])
        for arguments in (["-o"], [self.scene, "-o"], ["-o", "x.tessera"], [self.scene, "x.tessera", "-o"]):
            self.refused("convert", *arguments, says=["'-o' is no option. Try 'tessera convert --help'"])

    def test_names(self):
        self.refused("render", self.scene, "--accel", "bhv", says=["'bhv'", "'bvh'"])
        self.refused("render", self.scene, "--integrator", "whited", says=["'whitted'"])
        self.refused("render", self.scene, "--camera", "fornt", says=["'fornt'", "'front'"])
        self.refused("render", self.scene, "-o", "x.pgn", says=["pgn", "png"])
        self.refused("bench", "foo", says=["'foo'", "rays", "farm"])
        self.refused("bench", "ray", says=["'ray'", "did you mean 'rays'?"])
        self.refused("help", "bench", "ray", says=["did you mean 'rays'?"])
        self.refused("bench", "farm", "--worker", "2", says=["'--workers'", "bench farm --help"])

    def test_names_that_are_near_or_of_other_programs(self):
        for typed, meant in [("--samples", "--spp"), ("--width", "--size"), ("--res", "--size"),
                             ("--nthreads", "--threads"), ("--outfile", "--output"), ("--out", "--output"), ("--maxdepth", "--max-depth")]:
            self.refused("render", self.scene, typed, "4", says=[f"'{typed}'", f"did you mean '{meant}'?"])
        for option, typed, meant in [("--pattern", "sobol", "owen-sobol"), ("--pattern", "blue", "blue-noise"),
                                     ("--integrator", "pathtracer", "path")]:
            self.refused("render", self.scene, option, typed, says=[f"did you mean '{meant}'?"])
        self.refused("convert", "frst:100", "x.tessera", says=["did you mean 'forest'?"])
        for typed in ("-x", "--x", "--rays", "-"):
            result = self.run_program("render", self.scene, typed, "4")
            self.assertEqual(2, result.code)
            self.assertNotIn("did you mean", result.err)

    def test_values_that_lack_or_are_too_many(self):
        self.refused("render", self.scene, "--spp", "16", "--spp", "4", says=["--spp: given more than once"])
        self.refused("render", self.scene, "--spp", says=["--spp: needs a value N"])
        self.refused("render", self.scene, "-o", says=["--output: needs a value FILE"])
        self.refused("render", self.scene, "-o", "x", says=["'x' has no ending", ".png, .apng"])
        self.refused("render", self.scene, "--filter", "gaussian:abc", says=["NAME:RADIUS", "'abc'"])

    def options_of(self, *command):
        """The options of a command, and of those below it, that take a value: (command, option, what it takes)."""
        text = self.run_program("help", *command).out
        for option, type in re.findall(r"^  (?:-\w,)?(--[a-z0-9-]+) (\S+)", text, re.M):
            yield command, option, type
        below = text.partition("Subcommands:\n")[2].split("\n\n")[0]
        for name in re.findall(r"^  ([a-z][a-z-]*)", below, re.M):
            yield from self.options_of(*command, name)

    def test_no_option_takes_an_empty_value(self):
        options = list(self.options_of())
        self.assertGreater(len(options), 100)
        self.assertIn((("serve",), "--store", "DIR"), options)
        for command, option, type in {option: each for each in options for option in each[1:2]}.values():
            self.assert_error(self.run_program(*command, option + "="), 2, f"{option}: ''; expected ")
        for option in ("--store", "--key", "--allow", "--http-token"):
            self.assert_error(self.run_program("serve", option, ""), 2, f"{option}: ''; expected ")
        for command in (["render"], ["info"], ["status"], ["cancel"], ["fetch"], ["studio"], ["compare", "x.png"],
                        ["convert", "x.obj"], ["keygen"]):
            self.refused(*command, "", says=[": ''; expected "])
        # What follows is not its value.
        self.refused("serve", "--store=", "--http", "127.0.0.1:0", says=["--store: ''; expected DIR"])

    def test_hosts_without_an_address(self):
        endpoint = "tcp://nowhere.invalid:7117"
        for command in (["render", self.scene, "--connect"], ["status", "--connect"]):
            self.refused(*command, endpoint, says=[endpoint, "unknown"])

    def test_cameras_without_names_have_numbers(self):
        self.write("scene.tessera", "cameras { } cameras { description: 'side' }")
        # The scene is dark too, which is not what counts.
        self.refused("render", self.scene, "--camera", "foo", says=["'foo'", "2 cameras: 1, side"])
        self.write("scene.tessera", "nodes { shape { sphere { } } }")
        self.refused("render", self.scene, "--camera", "foo", says=["'foo'", "no camera"])

    def test_what_goes_with_nothing(self):
        self.refused("render", self.scene, "--min-spp", "4", says=["--min-spp", "--target-error"])
        self.refused("render", self.scene, "--target-error", ".1", "--min-spp", "2000",
                     says=["--min-spp", "1024", "--spp"])
        self.refused("render", self.scene, "--gamma", "2", "--transfer", "srgb",
                     says=["--gamma", "--transfer", "srgb"])
        self.refused("render", self.scene, "--denoise", "--spp", "4", "--integrator", "samples",
                     says=["--denoise", "--integrator", "samples"])

    def test_what_goes_not_together_is_no_fault_of_the_scene(self):
        for options in (["--pattern", "centered-grid", "--spp", "10"],
                        ["--pattern", "centered-grid", "--target-error", "0.01"],
                        ["--integrator", "cost", "--accel", "embree"]):
            self.refused("render", self.scene, *options, says=options)

    def test_sizes(self):
        for size in ["0x10", "10x0", "1000000000x1", "65537x1", "65536x65536", "-5x5", "8", "8x",
                     "x8", "8x8x8", "8.5x8", "axb", "", "99999999999999999999x1", " 8x8", "8x8 "]:
            with self.subTest(size=size):
                self.refused("render", self.scene, "--size", size, says=["--size"])

    def test_numbers(self):
        for option, value in [("--spp", "0"), ("--spp", "1048577"), ("--spp", "many"),
                              ("--target-error", "-1"), ("--target-error", "nan"),
                              ("--min-spp", "0"), ("--filter", "cube"), ("--filter", "box:0"),
                              ("--filter", "tent:17"), ("--pattern", "sobol"),
                              ("--workers", "-1"), ("--workers", "1000000000"), ("--threads", "0"),
                              ("--tile", "0"), ("--tile", "1e3"), ("--seed", "-1"),
                              ("--seed", "4294967296"), ("--time", "nan"), ("--time", "inf"),
                              ("--time", "soon"), ("--crop", "0,0,0,10"), ("--crop", "5,5,1,9"),
                              ("--crop", "1,2,3"), ("--crop", "-1,0,3,3"), ("--frames", "5-2"),
                              ("--frames", "2147483646-2147483647"),
                              ("--frames", "a-b"), ("--frames", "-3")]:
            with self.subTest(option=option, value=value):
                self.refused("render", self.scene, f"{option}={value}", says=[option, value])

    def test_a_farm_has_its_own_workers(self):
        for option in ("--workers", "--threads"):
            self.refused("render", self.scene, "--connect", "tcp://127.0.0.1:1", option, "2",
                         says=[option, "--connect"])

    def test_a_crop_beyond_the_frame(self):
        self.refused("render", self.scene, "--size", "8x8", "--crop", "4,4,9,8", says=["--crop"])

    def test_a_page_without_an_address(self):
        self.refused("serve", "--http", "8080", says=["--http", "ADDRESS:PORT"])

    def test_places_that_cannot_be_written(self):
        for place in ["nowhere/picture.png", "tmp", "tmp/"]:
            with self.subTest(place=place):
                self.refused("render", self.scene, "-o", place, says=[place])
        self.refused("render", self.scene, "--stats", "nowhere/s.json", says=["nowhere"])
        result = self.run_program("render", self.scene, "-o", "nowhere/a.png", "-o", "x.png", "-o",
                                  "elsewhere/b.png", "--trace", "nowhere/t.json")
        self.assertEqual(2, result.code)
        lines = result.err.splitlines()
        self.assertEqual(3, len(lines), "all that fail are told")
        for place, line in zip(["nowhere/a.png", "elsewhere/b.png", "nowhere/t.json"], lines):
            self.assertIn(f"'{place}' cannot be written", line)
        self.refused("convert", self.scene, "nowhere/s.json", says=["nowhere"])
        self.refused("convert", self.scene, "s.jsn", says=["s.jsn", ".json"])

    def test_a_folder_that_cannot_be_written(self):
        self.addCleanup(self.folder.chmod, 0o700)
        self.folder.chmod(0o500)
        for arguments in [("render", self.scene, "-o", "x.png"), ("convert", self.scene, "x.json"),
                          ("render", self.scene, "-o", "tmp/x.png", "--stats", "x.json")]:
            with self.subTest(arguments=arguments):
                self.refused(*arguments, says=["'x.", "Permission denied"],
                             preexec_fn=heed_permissions)

    def test_endpoints(self):
        for endpoint in ["", "nonsense", "tcp://", "http://127.0.0.1:80", "tcp://127.0.0.1:99999"]:
            with self.subTest(endpoint=endpoint):
                self.refused("serve", f"--bind={endpoint}", says=[endpoint or "ENDPOINT"])
                self.refused("worker", f"--connect={endpoint}", says=[endpoint or "ENDPOINT"])

    def test_an_option_in_place_of_a_value(self):
        self.refused("serve", "--store", "--http", "127.0.0.1:0", says=["--store: '--http'", "expected DIR"])
        self.refused("render", self.scene, "-o", "--size", "16x16", says=["--output: '--size'", "expected FILE"])

    def test_the_port_of_an_origin(self):
        self.refused("serve", "--http", "127.0.0.1:0", "--http-origin", "https://127.0.0.1:99999/",
                     says=["--http-origin: 'https://127.0.0.1:99999/'"])

    def test_only_loopback_without_keys(self):
        self.refused("serve", "--bind", "tcp://0.0.0.0:*", says=["0.0.0.0"])

    def test_a_port_in_use(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            for options in (["--bind", f"tcp://127.0.0.1:{port}"],
                            ["--bind", "tcp://127.0.0.1:*", "--http", f"127.0.0.1:{port}"]):
                with self.subTest(options=options):
                    self.assert_error(self.run_program("serve", *options), 75, str(port), "use")


class BadScenes(TesseraTest):
    def refused(self, name, content, *parts, **options):
        """`render` and `info` refuse this file, and nothing else is made."""
        path = self.write(name, content) if content is not None else self.folder / name
        before = sorted(p.name for p in self.folder.iterdir())
        for command in [("render", path, "--size", "16x16", "--workers", "2"), ("info", path)]:
            with self.subTest(command=command[0]):
                result = self.run_program(*command, **options)
                self.assert_error(result, 1, name, *parts)
                self.assertEqual(before, sorted(p.name for p in self.folder.iterdir()))

    def test_missing(self):
        self.refused("nowhere.tessera", None)

    def test_empty(self):
        for name in ["a.tessera", "a.tesserab", "a.json", "a.obj", "a.x3d"]:
            self.refused(name, "")

    def test_a_folder(self):
        (self.folder / "folder.obj").mkdir()
        self.refused("folder.obj", None)

    def test_an_unknown_ending(self):
        self.refused("scene.tesera", "cameras {}\n", ".tessera")

    def test_syntax_is_located(self):
        self.refused("scene.tessera", 'cameras { name: "a" }\ncamras { name: "b" }\n',
                     "scene.tessera:2", "camras", "cameras")

    def test_truncated(self):
        text = scenes.mesh_scene(4, 6)
        self.refused("scene.tessera", text[:len(text) // 2], "scene.tessera:")
        whole = self.write("whole.tessera", text)
        for ending in ["tesserab", "json"]:
            self.assertEqual(0, self.run_program("convert", whole, f"whole.{ending}").code)
            data = (self.folder / f"whole.{ending}").read_bytes()
            self.refused(f"cut.{ending}", data[:len(data) * 2 // 3])

    def test_binary_rubbish(self):
        rubbish = bytes((i * 197 + i // 7) % 256 for i in range(5000))
        for ending in ["tessera", "tesserab", "json", "obj", "x3d"]:
            self.refused(f"rubbish.{ending}", rubbish)

    def test_a_key_that_a_later_frame_needs_is_located(self):
        self.refused("scene.tessera", "nodes {\n  shape { sphere { } }\n"
                     "  keys { time: 0 transform { steps { translate { } } } }\n"
                     "  keys { time: 9 transform { steps { scale { x: 1 y: 1 z: 1 } } } }\n}\n",
                     "scene.tessera:3:3: ", "the same kinds of steps")

    def test_an_undefined_texture_is_located(self):
        sphere = 'nodes { shape { sphere { } materials: "m" } }\n'
        for field in ["physical {\n  base_color { texture: 'x' } }", "physical {\n  roughness { texture: 'x' } }",
                      "\n  normal_map: 'x'"]:
            self.refused("scene.tessera", sphere + f"materials {{ name: 'm' {field} }}\n", "scene.tessera:3:",
                         "'x'; expected the name of a texture")
        self.refused("scene.tessera", "background { cube {\n  top: 'x' } }\n", "scene.tessera:2:3: ", "cube.top is 'x'")

    def test_a_picture_is_called_by_its_name(self):
        data = stored_pictures.exr({"R": 1, "G": 1, "B": 1})
        for name, cut in (("short.exr", data[:-5]), ("head.exr", b"\x76\x2f\x31\x01no picture at all")):
            path = self.write(name, cut)
            result = self.run_program("compare", path, path)
            self.assert_error(result, 2, name)
            self.assertNotIn("/proc", result.err)

    def test_strictly_read_what_would_be_mended(self):
        scene = self.write("odd.obj", "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 nan\nf 1//1 2//1 3//1\n")
        lax = self.run_program("info", scene)
        self.assertEqual(0, lax.code, lax.err)
        self.assertIn("odd.obj:5:8: 'nan'", lax.out)
        for command in (["info", scene], ["convert", scene, "out.tessera"], ["submit", scene],
                        ["render", scene, "--size", "9x9", "--workers", "0"]):
            result = self.run_program(*command, "--strict")
            self.assertEqual(1, result.code, result.err)
            for fault in ("odd.obj:1:8: material library 'none.mtl' is not there",
                          "odd.obj:5:8: 'nan'; expected a component of the normal"):
                self.assertIn(fault, result.err)
            self.assertNotIn("warning", result.err)
        self.assertEqual(0, self.run_program("info", self.write("good.tessera", "nodes { shape { sphere { } } }"),
                                             "--strict").code)
        self.write("endless.exr", stored_pictures.exr({"R": math.inf, "G": 1, "B": 1}))
        pictured = self.write("pictured.tessera", 'textures { name: "t" image { file: "endless.exr" } }')
        told = "endless.exr: pixel 0,0 has the number inf and is read as 65504"
        self.assertIn(told, self.run_program("info", pictured).out)
        self.assert_error(self.run_program("info", pictured, "--strict"), 1, told)

    def test_not_finite(self):
        self.refused("scene.tessera", "nodes { shape { sphere { radius: nan } } }\n")
        self.refused("big.tessera", "nodes { shape { sphere { radius: 1e999 } } }\n")
        self.refused("mesh.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", "mesh.obj:2")

    def test_indices_and_counts(self):
        self.refused("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000\n", "scene.obj:4")
        self.refused("mesh.tessera", "nodes { shape { mesh { inline_positions: [0,0,0, 1,0,0, 0,1,0]"
                     " inline_triangles: [0,1,4000000000] } } }\n")
        self.refused("digest.tessera", 'nodes { shape { mesh { positions { digest: "00" '
                     "size: 18446744073709551615 } } } }\n")
        self.refused("lost.tessera", 'nodes { shape { mesh { positions { digest: "' + "ab" * 32 +
                     '" size: 1152921504606846976 } } } }\n')

    def test_settings_out_of_range(self):
        for settings in ["width: 0", "height: 1000000000", "width: 65536 height: 65536",
                         "sampling { samples_per_pixel: 0 }", "sampling { samples_per_pixel: 4294967295 }"]:
            with self.subTest(settings=settings):
                path = self.write("scene.tessera", f"settings {{ {settings} }}\n" + scenes.ONE_SPHERE)
                self.assert_error(self.run_program("render", path), 1, path.name, "settings")

    def test_what_only_the_picture_needs(self):
        for settings in ["output { gamma: 0 }", "output { response: [1, 2] }",
                         "frames { per_second: 0 }"]:
            self.refused("scene.tessera", f"settings {{ {settings} }}\n" + scenes.ONE_SPHERE,
                         "settings")
            (self.folder / "scene.tessera").unlink()

    def test_names_of_settings(self):
        for settings, name in [('integrator { kind: "pathh" }', "'pathh'"),
                               ('accelerator: "bvhh"', "'bvhh'")]:
            self.refused("scene.tessera", f"settings {{ {settings} }}\n" + scenes.ONE_SPHERE, name)
            (self.folder / "scene.tessera").unlink()

    def test_cycles(self):
        self.refused("scene.tessera",
                     'objects { name: "a" nodes { instance_of: "b" } }\n'
                     'objects { name: "b" nodes { instance_of: "a" } }\n'
                     'nodes { instance_of: "a" }\n', "'a'")
        self.refused("self.tessera", 'includes { file: "self.tessera" }\n')

    def test_undefined_names(self):
        self.refused("scene.tessera", 'materials { name: "red" classic { } }\n'
                     'nodes { shape { materials: "rde" sphere { } } }\n', "'rde'", "'red'")

    def test_a_reference_out_of_the_folder(self):
        self.refused("scene.tessera", 'includes { file: "/etc/passwd" format: "obj" }\n')
        self.refused("dots.tessera", 'includes { file: "../../etc/passwd" format: "obj" }\n')

    def test_assets(self):
        """Files that a scene names are looked for in --assets, and nowhere else."""
        triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        (self.folder / "inside").mkdir()
        self.write("inside/t.obj", triangle)
        self.write("beside.obj", triangle)
        scene = self.write("scene.tessera", scenes.ONE_SPHERE + 'includes { file: "t.obj" }\n')
        self.assert_error(self.run_program("info", scene), 1, "t.obj", "no such file")
        for command in [("info", scene), ("convert", scene, "out.tessera"),
                        ("render", scene, "--size", "16x16", "--workers", "0", "-o", "x.png")]:
            result = self.run_program(*command, "--assets", "inside")
            self.assertEqual(0, result.code, result.err)
        for name, says in [("beside.obj", "no such file"), ("../beside.obj", "not inside")]:
            self.write("scene.tessera", f'includes {{ file: "{name}" }}\n')
            result = self.run_program("info", scene, "--assets", "inside")
            self.assert_error(result, 1, "beside.obj", says)
        result = self.run_program("info", scene, "--assets", "nowhere")
        self.assert_error(result, 2, "--assets", "'nowhere'")

    def test_no_codec_for_an_image_is_no_fault_of_the_scene(self):
        self.write("a.bmp", b"BM, but no picture")
        self.write("a.mtl", "newmtl m\nmap_Kd a.bmp\n")
        self.write("scene.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\n"
                   "f 1/1 2/1 3/1\n")
        self.write("scene.x3dv", '#X3D V3.3 utf8\nShape { appearance Appearance { texture '
                   'ImageTexture { url "a.bmp" } } geometry Box { } }\n')
        self.write("scene.tessera", 'textures { name: "t" image { file: "a.bmp" } } background { '
                   'panorama { texture: "t" } }\n')
        options = ["--size", "8x8", "--workers", "0", "-o", "a.pfm"]
        for scene, code in ("scene.obj", 0), ("scene.x3dv", 0), ("scene.tessera", 1):
            result = self.run_program("render", scene, *options)
            self.assertEqual(code, result.code, result.err)
            self.assertRegex(result.err, "a.bmp.*expected an image file")
        alone = shutil.copy(PROGRAM, self.folder)
        for scene in "scene.obj", "scene.x3dv", "scene.tessera":
            result = self.run_program("render", scene, *options, executable=alone)
            self.assert_error(result, 3, "a.bmp", "cannot find the image codec")

    def test_unreadable(self):
        self.write("secret.obj", "v 0 0 0\n").chmod(0)
        self.refused("secret.obj", None, "Permission denied", preexec_fn=heed_permissions)


PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face %d
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
"""
CRT = """eye = Camera { position -> vec3(0, 1, -5)  pointing -> vec3(0, 0, 0)  fov -> 50 }
Settings { camera -> eye }
Scene { }
"""


class NothingToSee(TesseraTest):
    """A scene without surfaces is its background, with a warning, in every format."""

    def test_whole_files_without_surfaces(self):
        for name, content in [
                ("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n"), ("comment.obj", "# of nothing\n"),
                ("name.obj", "mtllib none.mtl\no rock\n"),
                ("lines.ply", PLY % 1 + "2 0 1\n"),
                ("header.ply", "ply\nformat ascii 1.0\nend_header\n"),
                ("text.stl", "solid a\nendsolid a\n"), ("binary.stl", bytes(84)),
                ("bare.gltf", json.dumps({"asset": {"version": "2.0"}})),
                ("bare.x3d", "<X3D><Scene/></X3D>"), ("bare.x3dv", "#X3D V3.3 utf8\nPROFILE Full\n"),
                ("bare.wrl", "#VRML V2.0 utf8\n"), ("bare.tessera", "cameras { }\n"),
                ("bare.json", "{}"), ("bare.crt", CRT)]:
            with self.subTest(name):
                self.write(name, content)
                result = self.run_program("render", name, "--size", "4x4", "--workers", "0", "-o", "a.pfm")
                self.assertEqual(0, result.code, result.err)
                self.assertIn("only the background is seen; expected nodes with shapes\n", result.err)

    def test_damage_that_leaves_no_surface_is_an_error(self):
        corners = [0, 0, 0, 1, 0, 0, 0, 1, 0]
        data = base64.b64encode(struct.pack("<9f3H", *corners, 0, 1, 9)).decode()
        gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "buffers": [{"byteLength": 42, "uri": "data:application/octet-stream;base64," + data}],
                "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                               "min": [0, 0, 0], "max": [1, 1, 0]},
                              {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}]}
        for name, content, place in [
                ("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n", "a.obj:3:7: "), ("text.obj", "hello\n", "text.obj:1:1: "),
                ("a.ply", PLY % 1 + "3 0 1 9\n", "a.ply:13:7: "),
                ("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\nvertex 1 0 0\nvertex 0 1 0\n"
                 "endloop\nendfacet\nendsolid a\n", "a.stl:4:12: "),
                ("a.gltf", json.dumps(gltf), "index 9 of 3 vertices")]:
            with self.subTest(name):
                self.write(name, content)
                result = self.run_program("render", name, "--size", "4x4", "--workers", "0", "-o", "a.pfm")
                self.assert_error(result, 1, place)


class LittleMemory(TesseraTest):
    @unittest.skipIf(SLOWER > 1, "sanitizers need the addresses themselves")
    def test_is_one_clear_error(self):
        path = self.write("scene.tessera", scenes.mesh_scene(60, 80))
        codes = set()
        for megabytes in range(35, 200, 10):  # at 30 the system cannot load and prepare its libraries
            for workers in (0, 1):
                with self.subTest(megabytes=megabytes, workers=workers):
                    limit = (megabytes << 20, resource.RLIM_INFINITY)
                    result = self.run_program(
                        "render", path, "-o", "x.pfm", "--size", "32x32", "--quiet", "--workers", workers,
                        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit))
                    codes.add(result.code)
                    self.assertIn(result.code, (0, 3), result.err)
                    self.assertEqual(0, result.err.count("terminate"), result.err)
        self.assertEqual({0, 3}, codes)


class BadWorkers(TesseraTest):
    def test_nobody_there(self):
        for endpoint, what in [("tcp://127.0.0.1:1", "nothing listens at"),
                               ("tcp://nowhere.invalid:7117", "the name of the host of")]:
            with self.subTest(endpoint=endpoint):
                worker = self.run_program("worker", "--connect", endpoint, "--orphan-timeout", "3")
                self.assertEqual(3, worker.code)
                self.assertIn(f"{what} {endpoint}", worker.err)
                self.assertIn(f"tessera: {endpoint}: the coordinator is silent", worker.err)

    def test_another_protocol_version_is_told_so(self):
        serve = self.start("serve", "--bind", "tcp://127.0.0.1:*")
        endpoint = serve.stdout.readline().split()[-1]
        worker = self.run_program("worker", "--connect", endpoint, "--threads", 1,
                                  "--protocol-major", 99)
        self.assertEqual(2, worker.code)
        self.assertIn("99", worker.err)
        self.assertIsNone(serve.poll(), "the coordinator goes on")
        serve.terminate()
        self.assertEqual(0, serve.wait(PATIENCE))


if __name__ == "__main__":
    unittest.main()
