#!/usr/bin/env python3
"""How scenes come into being in the studio: by templates and samples."""
import json
import pathlib
import struct
import time
import unittest

from studio_browser import StudioPageTest
from studio_case import SAMPLES, SCENE
from tessera_process import PROGRAM, wait_until

AXE = pathlib.Path(PROGRAM).parents[1] / "studio/page/work/node_modules/axe-core/axe.min.js"


class Start(StudioPageTest):
    def start(self, *options):
        """The page of a studio without a file."""
        self.running = self.studio("--workers", 1, *options)
        return self.visit(None)

    def opened_file(self, page, name):
        self.until(page, lambda state: state["file"] == name, f"{name} is open")
        self.until_final(page)

    def painted(self, page, name):
        """How many colours the small picture of a sample has; 0 while it has none."""
        return page.evaluate(f"""(() => {{
            for (const each of document.querySelectorAll(".samples button")) {{
              if (each.querySelector(".aside").textContent !== {json.dumps(name)}) continue;
              const canvas = each.querySelector("canvas");
              const {{ data }} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
              const words = new Uint32Array(data.buffer);
              return words[0] === 0 ? 0 : new Set(words).size;
            }}
            return 0;
          }})()""")

    def test_each_template_makes_a_scene_that_is_shown(self):
        page = self.start()
        page.click_on('[aria-label="New scene"] button', "LUX")
        self.opened_file(page, "lux.tessera")
        self.assertEqual(["lux.tessera", "sphere.obj"], sorted(each.name for each in self.opened.iterdir()))
        self.assertEqual(80, (self.opened / "sphere.obj").read_text().count("\nf "))
        page.press("Alt-N")
        self.opened_file(page, "scene.tessera")
        page.press("Alt-N")
        self.opened_file(page, "scene-2.tessera")

    def test_the_script_of_crt_is_reached_by_keys(self):
        page = self.start()
        page.evaluate("document.querySelector('.start button').focus()")
        page.press("Tab", 2)
        self.assertEqual("CRT script", page.focused())
        page.press("Enter")
        self.opened_file(page, "scene.crt")

    def test_a_sphere_that_is_another_file_is_left_alone(self):
        (self.opened / "sphere.obj").write_text("o mine\n")
        page = self.start()
        page.click_on('[aria-label="New scene"] button', "LUX")
        wait_until(lambda: page.has(".notice.error", "'sphere.obj' is there already"), "it is refused")
        self.assertEqual("o mine\n", (self.opened / "sphere.obj").read_text())
        self.assertEqual(["sphere.obj"], [each.name for each in self.opened.iterdir()])

    def test_samples_are_seen_and_open_as_untitled_copies(self):
        page = self.start()
        wait_until(lambda: self.painted(page, "balloons.x3d") > 50, "the first sample has a picture")
        self.assertEqual(0, self.painted(page, "toolbox.tessera"), "the last was not seen yet")
        page.middle(".samples button", "toolbox")
        wait_until(lambda: self.painted(page, "toolbox.tessera") > 50, "the last sample has a picture")
        page.click_on(".samples button", "gate")
        self.opened_file(page, "untitled.crt")
        self.assertEqual((SAMPLES / "gate.crt").read_text(), page.script)
        for name in ("pawn.obj", "pawn.mtl"):
            self.assertEqual((SAMPLES / name).read_bytes(), (self.opened / name).read_bytes())
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.type("-- mine\n")
        page.press("Ctrl-S")
        wait_until(lambda: self.saved("untitled.crt").startswith("-- mine"), "it is saved")
        self.assertNotIn("-- mine", (SAMPLES / "gate.crt").read_text())

    def test_folders_that_were_opened_before_are_listed_with_their_commands(self):
        others = [self.folder / "first", self.folder / "the second's"]
        for each in others:
            each.mkdir()
            self.assertEqual(0, self.end_studio(self.studio("--workers", 1, path=each)))
        page = self.start()
        listed = wait_until(lambda: page.evaluate("[...document.querySelectorAll('.recent code')].map((each) => each.textContent)"), "they are listed")
        path = str(others[1]).replace("'", "'\\''")
        self.assertEqual([f"tessera studio '{path}'", f"tessera studio {others[0]}"], listed)
        page.click_on(".recent button")
        wait_until(lambda: page.has(".notice", f"In the clipboard: {listed[0]}"), "it is copied")
        # A studio that is for reading notes nothing.
        self.assertEqual(0, self.end_studio(self.running))
        kept = json.loads((self.folder / "config/tessera/studio_recent.json").read_text())
        self.assertEqual([self.opened, *reversed(others)], list(map(pathlib.Path, kept["folders"])))
        reading = self.folder / "reading"
        reading.mkdir()
        self.end_studio(self.studio("--workers", 1, "--read-only", path=reading))
        self.assertEqual(kept, json.loads((self.folder / "config/tessera/studio_recent.json").read_text()))

    def kept_workspace(self):
        found = [json.loads(each.read_text()) for each in (self.folder / "config/tessera/studio").glob("*.json")]
        return found[0] if found else {}

    def tabs(self, page):
        return page.evaluate("[...document.querySelectorAll('.file-tabs [role=tab]')].map((each) => each.title)")

    def test_what_was_open_comes_back_with_its_cursors_and_cameras(self):
        for name in ("one.tessera", "two.tessera", "three.tessera"):
            self.scene(name, SCENE + "# a line\n" * 200)
        page = self.begin(scene=False, file="one.tessera")
        page.click_on(".view-frame")
        self.until(page, lambda state: state["selection"]["entity"], "what was clicked is selected")
        page.press("Left")
        self.until(page, lambda state: state["camera"]["mode"] == "free", "the camera is moved")
        page.wait_for_frames()
        camera = page.state["camera"]
        page.click_on(".cm-scroller")
        page.press("Ctrl-End")
        for name in ("three.tessera", "two.tessera"):
            page.click_on('.panel-files [role="option"]', name)
            self.until(page, lambda state: state["file"] == name, "it is open")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Down", 2)
        page.press("Shift-Right", 4)
        page.click_on('.file-tabs [role="tab"]', "one.tessera")
        self.until(page, lambda state: state["file"] == "one.tessera", "it is in the editor")
        self.until_final(page)
        wait_until(lambda: (kept := self.kept_workspace()).get("active") == "one.tessera"
                   and kept["selections"].get("two.tessera", [0, 0])[1] > 4, "it is kept")
        page.close()
        self.pages.remove(page)
        self.assertEqual(0, self.end_studio(self.running))
        (self.opened / "three.tessera").unlink()

        page = self.start()
        self.until(page, lambda state: state["file"] == "one.tessera", "it is in the editor")
        wait_until(lambda: self.tabs(page) == ["one.tessera", "two.tessera"], "both that there are are open")
        self.assertTrue(page.has(".notice.error", "three.tessera"), "the one that is gone is told")
        self.until_final(page)
        self.assertEqual(camera, page.state["camera"])
        self.assertEqual(SCENE.count("\n") + 201, page.state["selection"]["line"])
        wait_until(lambda: page.has(".cm-activeLine"), "the cursor is before the eyes")
        page.click_on('.file-tabs [role="tab"]', "two.tessera")
        state = self.until(page, lambda state: state["file"] == "two.tessera", "the other one")
        self.assertEqual({"entity": state["selection"]["entity"], "line": 3, "column": 1, "endLine": 3, "endColumn": 5},
                         state["selection"])
        self.assertEqual("scene", state["camera"]["mode"])
        wait_until(lambda: self.kept_workspace().get("open") == ["one.tessera", "two.tessera"], "what is gone is not kept")

    def open_second(self):
        """A page that was kept with one open file, and now has two."""
        for name in ("one.tessera", "two.tessera"):
            self.scene(name)
        page = self.begin(scene=False, file="one.tessera")
        wait_until(lambda: self.kept_workspace().get("open") == ["one.tessera"], "it is kept")
        page.click_on('.panel-files [role="option"]', "two.tessera")
        self.until(page, lambda state: state["file"] == "two.tessera", "it is in the editor")
        return page

    def test_what_is_open_comes_back_whenever_the_page_is_loaded_again(self):
        page = self.open_second()
        page.reload()
        self.until(page, lambda state: state["file"] == "two.tessera", "it is in the editor again")

    def test_what_is_open_is_kept_while_the_cursor_moves(self):
        page = self.open_second()
        page.click_on(".cm-scroller")
        wait_until(lambda: page.press("Down") or page.press("Up")
                   or "two.tessera" in self.kept_workspace()["open"], "it is kept")

    def test_the_file_that_the_program_is_started_with_is_in_front_of_those_of_before(self):
        for name in ("one.tessera", "two.tessera"):
            self.scene(name)
        page = self.begin(scene=False, file="one.tessera")
        wait_until(lambda: self.kept_workspace().get("open") == ["one.tessera"], "it is kept")
        page.close()
        self.pages.remove(page)
        self.assertEqual(0, self.end_studio(self.running))
        self.running = self.studio("--workers", 1, path=self.opened / "two.tessera")
        page = self.visit(None)
        self.until(page, lambda state: state["file"] == "two.tessera", "it is in the editor")
        wait_until(lambda: self.tabs(page) == ["one.tessera", "two.tessera"], "both are open")
        self.until_final(page)

    def test_a_studio_for_reading_shows_samples_and_makes_nothing(self):
        self.scene()
        page = self.start("--read-only")
        wait_until(lambda: self.painted(page, "balloons.x3d") > 50, "the first sample has a picture")
        page.click_on('[aria-label="New scene"] button', "LUX")
        page.click_on(".samples button", "balloons")
        wait_until(lambda: page.has(".notice.error", "read-only"), "it is refused")
        self.assertEqual(SCENE, self.saved())
        self.assertEqual(["scene.tessera"], [each.name for each in self.opened.iterdir()])


# A triangle whose numbers are in t.bin.
GLTF = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"uri": "t.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                       "max": [1, 1, 0]}]}
TRIANGLE = "o sphere\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


class Drop(StudioPageTest):
    def setUp(self):
        super().setUp()
        self.desktop = self.folder / "desktop"
        self.desktop.mkdir()

    def file(self, name, content):
        path = self.desktop / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    def part_of_view(self, page, across, down):
        """A place of the picture, by its shares of width and height."""
        _, _, left, top, width, height = wait_until(lambda: page.box(".view-frame"), "the view")
        return left + across * width, top + down * height

    def includes(self, page):
        return [line for line in page.script.split("\n") if line.startswith("includes")]

    def names(self):
        return sorted(each.name for each in self.opened.iterdir())

    def test_a_model_stands_where_the_ray_meets_the_scene(self):
        page = self.begin()
        page.drop_files(*self.part_of_view(page, .5, .5), self.file("a.obj", TRIANGLE))
        wait_until(lambda: self.includes(page), "it is placed")
        self.assertEqual(TRIANGLE, self.saved("a.obj"))
        words = self.includes(page)[0].replace("{", " ").replace("}", " ").split()
        self.assertEqual('"a.obj"', words[words.index("file:") + 1])
        point = [float(words[words.index(axis) + 1]) if axis in words else 0 for axis in ("x:", "y:", "z:")]
        # The ball of radius 1.25 about the origin is in the middle, as the camera at (0, 1, 5) sees it.
        self.assertAlmostEqual(1.25, sum(each * each for each in point) ** .5, delta=.01)
        self.assertGreater(point[2], 1)
        self.until_final(page)
        self.assertEqual([], page.state["problems"])

    def test_a_model_on_the_ground_or_the_tree_stands_at_the_origin(self):
        page = self.begin()
        path = self.file("a.obj", TRIANGLE)
        page.drop_files(*self.part_of_view(page, .03, .05), path)
        wait_until(lambda: len(self.includes(page)) == 1, "it is placed")
        page.drop_files(*page.middle(".panel-scene .tree"), path)
        wait_until(lambda: len(self.includes(page)) == 2, "it is placed again")
        self.assertEqual(['includes { file: "a.obj" }', 'includes { file: "a-2.obj" }'], self.includes(page))
        self.assertEqual(["a-2.obj", "a.obj", "scene.tessera"], self.names())

    def test_a_picture_on_the_ground_is_the_background(self):
        page = self.begin()
        before = self.until_final(page)
        path = self.file("sky.png", (SAMPLES / "hall.png").read_bytes())
        page.drop_files(*self.part_of_view(page, .5, .5), path)
        wait_until(lambda: page.has(".notice", "Copied: sky.png"), "on the ball it is copied alone")
        self.assertEqual(SCENE, page.script)
        page.drop_files(*self.part_of_view(page, .03, .05), path)
        wait_until(lambda: 'panorama { texture: "panorama" }' in page.script, "it is the background")
        self.assertIn('textures { name: "panorama" image { file: "sky-2.png" } }', page.script)
        self.assertNotIn("gradient", page.script)
        self.until_final(page, before)
        self.assertEqual([], page.state["problems"])
        page.click_on(".cm-scroller")
        page.press("Ctrl-Z")
        wait_until(lambda: page.script == SCENE, "one step of undo takes it back")

    def test_what_a_model_names_is_copied_beside_it(self):
        page = self.begin()
        page.drop_files(*self.part_of_view(page, .5, .5), self.file("m.obj", "mtllib m.mtl\nusemtl red\n" + TRIANGLE),
                        self.file("m.mtl", "newmtl red\nKd 1 0 0\nmap_Kd wall.png\n"),
                        self.file("wall.png", (SAMPLES / "hall.png").read_bytes()))
        wait_until(lambda: self.includes(page), "the model is placed")
        self.until_final(page)
        self.assertEqual([], page.state["problems"])
        page.drop_files(*self.part_of_view(page, .03, .05), self.file("t.gltf", json.dumps(GLTF)),
                        self.file("t.bin", struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)))
        wait_until(lambda: len(self.includes(page)) == 2, "the other model is placed")
        self.until_final(page)
        self.assertEqual([], page.state["problems"])
        self.assertEqual(["m.mtl", "m.obj", "scene.tessera", "t.bin", "t.gltf", "wall.png"], self.names())
        self.assertEqual(2, len(self.includes(page)))
        self.assertIn('"m.obj"', self.includes(page)[0])
        self.assertIn('"t.gltf"', self.includes(page)[1])

    def test_a_file_on_the_editor_is_opened(self):
        page = self.begin()
        page.drop_files(*page.middle(".cm-content"), self.file("b.tessera", SCENE))
        self.until(page, lambda state: state["file"] == "b.tessera", "it is open")
        self.assertEqual(SCENE, page.script)
        self.assertEqual(SCENE, self.saved("scene.tessera"))

    def test_what_cannot_be_taken_is_refused_and_leaves_nothing(self):
        page = self.begin()
        place = self.part_of_view(page, .5, .5)
        for name, why in ((".hidden.obj", "hidden"), ("run.sh", "no file of a kind")):
            page.drop_files(*place, self.file(name, TRIANGLE))
            wait_until(lambda: page.has(".notice.error", why), f"{name} is refused")
        huge = self.desktop / "huge.obj"
        with huge.open("wb") as file:
            file.truncate((256 << 20) + 1)
        page.drop_files(*place, huge)
        wait_until(lambda: page.has(".notice.error", "at most 256 MiB"), "it is refused")
        self.assertEqual(["scene.tessera"], self.names())
        self.assertEqual(SCENE, page.script)

    def test_large_files_come_whole(self):
        page = self.begin()
        content = b"# " + b"x" * 5_000_001 + b"\n" + TRIANGLE.encode()
        page.drop_files(*page.middle(".panel-scene .tree"), self.file("a.obj", content))
        wait_until(lambda: self.includes(page), "it is placed")
        self.assertTrue(content == (self.opened / "a.obj").read_bytes())

    def test_what_a_killed_studio_left_is_removed(self):
        self.scene()
        left = self.opened / ".tessera-abcdefghijklmnop.part"
        left.write_text("half")
        page = self.begin()
        wait_until(lambda: not left.exists(), "it is removed")
        self.assertEqual("scene.tessera", page.state["file"])

    def test_shapes_come_by_keys_and_by_dragging(self):
        page = self.begin()
        page.evaluate("document.querySelector('.palette button').focus()")
        self.assertEqual("sphere", page.focused())
        page.press("Enter")
        wait_until(lambda: 'name: "sphere"' in page.script, "it is at the origin")
        self.until_final(page)
        self.assertNotIn("transform", page.script)
        page.drag(page.middle(".palette button", "box"), self.part_of_view(page, .5, .5))
        wait_until(lambda: 'name: "box"' in page.script, "it is on the ball")
        self.assertIn("transform { steps { translate {", page.script)
        page.drag(page.middle(".palette button", "cone"), page.middle(".panel-files"))
        self.until_final(page)
        self.assertNotIn("cone", page.script)


MODEL_SCENE = SCENE + """\
includes {
    file: "a.obj"
    transform { steps { scale { x: 2 y: 2 z: 2 } } } # twice as large
}
"""


class Models(StudioPageTest):
    def begin_with_model(self):
        (self.opened / "a.obj").write_text(TRIANGLE)
        (self.opened / "b.obj").write_text(TRIANGLE)
        self.scene(text=MODEL_SCENE)
        page = self.begin(scene=False)
        page.click_on('[role="tab"]', "Models")
        page.click_on('.panel-models [role="option"]', "a.obj")
        return page

    def open_dialog(self, page):
        page.press("Enter")
        wait_until(lambda: page.has('dialog[aria-label="A"]'), "the dialog of the model")

    def fill(self, page, label, text):
        """Types in place of what a field of the dialog has."""
        selector = f"dialog input[aria-label={json.dumps(label)}]"
        wait_until(lambda: page.evaluate(f"""(() => {{
            const all = [...document.querySelectorAll("dialog label.field")];
            const found = document.querySelector({json.dumps(selector)}) ??
              all.find((each) => each.querySelector("span").textContent === {json.dumps(label)})?.querySelector("input");
            found?.focus();
            found?.select();
            return found !== undefined;
          }})()"""), f"the field {label}")
        page.press("Backspace")
        page.type(text)

    def test_enter_accepts_and_first_works_out_what_is_no_number_yet(self):
        page = self.begin_with_model()
        self.open_dialog(page)
        self.fill(page, "Position y", "1.50")
        self.fill(page, "Scale", "2*3")
        page.press("Enter")
        wait_until(lambda: page.evaluate("document.activeElement.value") == "6", "it is worked out")
        self.assertTrue(page.has("dialog"))
        self.fill(page, "Scale", "-1")
        page.press("Enter")
        page.wait_for_frames()
        self.assertTrue(page.has("dialog"), "what is wrong is not accepted")
        self.fill(page, "Scale", "6")
        page.press("Enter")
        self.closed(page)
        wait_until(lambda: "translate { y: 1.50 }" in page.script, "the text follows")
        self.assertIn("scale { x: 6 y: 6 z: 6 }", page.script)

    def faults(self, page):
        return page.evaluate("[...document.querySelectorAll('dialog .why')].map((each) => each.textContent)")

    def closed(self, page):
        wait_until(lambda: not page.has("dialog"), "the dialog is closed")

    def test_accepting_changes_the_literals_that_differ_in_one_step(self):
        page = self.begin_with_model()
        self.open_dialog(page)
        self.fill(page, "Position y", "1.50")
        self.fill(page, "Rotation z", "30")
        self.fill(page, "Scale", "3")
        page.click_on('dialog input[aria-label="Flip x"]')
        page.click_on("dialog button", "Accept")
        self.closed(page)
        wait_until(lambda: page.script != MODEL_SCENE, "the text follows")
        self.assertTrue(page.script.startswith(SCENE))
        self.assertIn("translate { y: 1.50 }", page.script)
        self.assertIn("rotate { axis { z: 1 } angle: 30 }", page.script)
        self.assertIn("scale { x: -3 y: 3 z: 3 }", page.script)
        self.until_final(page)
        self.assertEqual([], page.state["problems"])
        page.click_on(".cm-scroller")
        page.press("Ctrl-Z")
        wait_until(lambda: page.script == MODEL_SCENE, "one step of undo takes it back")

    def test_cancelling_leaves_the_text_as_it_is(self):
        page = self.begin_with_model()
        for leave in (lambda: page.press("Escape"), lambda: page.click_on("dialog button", "Cancel")):
            self.open_dialog(page)
            self.fill(page, "Position y", "7")
            page.click_on('dialog input[aria-label="Flip x"]')
            leave()
            self.closed(page)
            self.assertEqual(MODEL_SCENE, page.script)
            page.click_on('.panel-models [role="option"]', "a.obj")

    def test_what_is_wrong_says_so_and_is_not_accepted(self):
        page = self.begin_with_model()
        self.open_dialog(page)
        # What LUX's own tests type, and what its fields let pass.
        for label, right, wrong in (
                ("File", "a.obj", ("sphere", "obj.sphere", "sphere.png", "152", "")),
                ("Position x", "0", ("-", "~", "nan", "inf", "1,5", "1;2", "")),
                ("Rotation y", "0", ("a", "b", "c", "-inf")),
                ("Scale", "2", ("0", "-1", "aba", "1e999"))):
            for text in wrong:
                self.fill(page, label, text)
                faults = wait_until(lambda: self.faults(page), f"{label}: '{text}' is wrong")
                self.assertEqual(1, len(faults), faults)
                self.assertIn("expected", faults[0])
                self.assertTrue(page.evaluate("document.activeElement.getAttribute('aria-invalid') === 'true'"))
                page.press("Ctrl-Enter")
                page.click_on("dialog button", "Accept")
                self.assertTrue(page.evaluate("document.activeElement.getAttribute('aria-invalid') === 'true'"),
                                "the wrong field is gone to")
            self.fill(page, label, right)
            wait_until(lambda: self.faults(page) == [], f"{label}: {right} is right")
        self.assertEqual(MODEL_SCENE, page.script)
        page.click_on("dialog button", "Accept")
        self.closed(page)
        self.assertEqual(MODEL_SCENE, page.script)
        page.press("Ctrl-Z")
        self.assertEqual(MODEL_SCENE, page.script)

    def test_a_model_is_added_with_its_numbers(self):
        page = self.begin_with_model()
        page.evaluate("document.querySelector('[aria-label=\"Model to add\"]').focus()")
        page.type("b")
        page.click_on(".panel-models button", "Add")
        wait_until(lambda: page.has('dialog[aria-label="B"]'), "the dialog of the model")
        page.press("Escape")
        self.closed(page)
        self.assertEqual(MODEL_SCENE, page.script)
        page.evaluate("document.querySelector('[aria-label=\"Model to add\"]').focus()")
        page.type("b")
        page.click_on(".panel-models button", "Add")
        self.fill(page, "Position x", "-2")
        page.click_on("dialog button", "Accept")
        wait_until(lambda: page.script.endswith(
            'includes { file: "b.obj" transform { steps { translate { x: -2 } } } }\n'), "it is placed")
        self.until_final(page)
        options = page.evaluate("[...document.querySelectorAll('.panel-models [role=option] .name')]"
                                ".map((each) => each.textContent)")
        self.assertEqual(["a.obj", "b.obj"], options)

    def test_a_file_outside_the_folder_of_the_scene_is_right(self):
        (self.opened / "sub").mkdir()
        (self.opened / "two.obj").write_text(TRIANGLE)
        self.scene("sub/up.tessera", MODEL_SCENE.replace("a.obj", "../two.obj"))
        for folder, options in ((self.opened, ()), (self.opened / "sub", ("--assets", self.opened))):
            self.running = self.studio("--workers", 1, *options, path=folder)
            page = self.visit(None)
            page.click_on('[role="tab"]', "Files")
            page.click_on('.panel-files [role="option"]', "up.tessera")
            self.until_final(page)
            self.assertEqual([], page.state["problems"])
            page.click_on('[role="tab"]', "Models")
            page.click_on('.panel-models [role="option"]', "two.obj")
            page.press("Enter")
            wait_until(lambda: page.has('dialog[aria-label="Two"]'), "the dialog of the model")
            self.assertEqual([], self.faults(page))
            self.fill(page, "Position y", "1.50")
            page.press("Ctrl-Enter")
            self.closed(page)
            wait_until(lambda: "translate { y: 1.50 }" in page.script, "the text follows")
            page.click_on('[role="tab"]', "Properties")
            wait_until(lambda: page.evaluate(self.live(page, "File") + "?.value") == "../two.obj", "its properties")
            self.assertFalse(page.has('[aria-invalid="true"]'))

    def live(self, page, label):
        """An expression for a field of the placement in the Properties panel."""
        return f"""[...document.querySelectorAll(".panel-properties .fields label.field")].find((each) =>
            each.querySelector("span").textContent === {json.dumps(label)})?.querySelector("input")"""

    def set_live(self, page, label, text):
        """Types in place of what the field has."""
        wait_until(lambda: page.evaluate(f"(() => {{ const found = {self.live(page, label)}; found?.focus(); "
                                         "found?.select(); return found !== undefined; })()"), f"the field {label}")
        page.type(text)

    def test_the_properties_of_a_model_set_its_placement_as_they_are_typed(self):
        page = self.begin_with_model()
        page.click_on('[role="tab"]', "Properties")
        self.set_live(page, "Position y", "1.75")
        wait_until(lambda: "translate { y: 1.75 }" in page.script, "the position follows")
        after = self.until_final(page)
        self.assertEqual(after["version"], after["picture"]["version"])
        moved = page.script
        self.set_live(page, "Rotation z", "30")
        wait_until(lambda: "rotate { axis { z: 1 } angle: 30 }" in page.script, "the rotation follows")
        self.set_live(page, "Scale", "3")
        wait_until(lambda: "scale { x: 3 y: 3 z: 3 }" in page.script, "the scale follows")
        page.click_on('.panel-properties input[aria-label="Flip x"]')
        wait_until(lambda: "scale { x: -3 y: 3 z: 3 }" in page.script, "it is mirrored")
        page.evaluate("document.querySelector('.panel-properties .fields select').focus()")
        page.type("red")
        wait_until(lambda: 'material: "red"' in page.script, "the material follows")
        self.set_live(page, "File", "b.obj")
        wait_until(lambda: 'file: "b.obj"' in page.script, "the file follows")
        self.until_final(page)
        self.assertEqual([], page.state["problems"])
        # What is typed into one field is one step of undo.
        page.click_on(".cm-scroller")
        page.press("Ctrl-Z", 5)
        self.assertEqual(moved, page.script)
        page.press("Ctrl-Z")
        self.assertEqual(MODEL_SCENE, page.script)
        page.click_on('.panel-models [role="option"]', "a.obj")
        wait_until(lambda: page.evaluate(f"{self.live(page, 'Position y')}?.value") == "0", "the fields are those of the text again")
        # What is wrong is told and not set.
        for label, wrong, right in (("File", "c.obj", "a.obj"), ("Position y", "x", "0"), ("Scale", "-1", "2")):
            self.set_live(page, label, wrong)
            wait_until(lambda: page.has(".panel-properties .fields .why", "expected"), f"{label}: {wrong} is wrong")
            self.set_live(page, label, right)
            wait_until(lambda: not page.has(".panel-properties .fields .why"), f"{label} is right again")
        page.wait_for_frames()
        self.assertEqual(MODEL_SCENE, page.script)

    def test_a_model_that_gets_a_transform_of_its_own_stays_the_selected_one(self):
        self.scene("part.x3dv", "#X3D V3.3 utf8\nPROFILE Immersive\nShape { geometry Sphere { } }\n")
        self.scene("scene.x3dv", '#X3D V3.3 utf8\nPROFILE Immersive\nInline { url "part.x3dv" }\n')
        page = self.begin(scene=False, file="scene.x3dv")
        page.click_on('[role="tab"]', "Models")
        page.click_on('.panel-models [role="option"]', "part.x3dv")
        page.click_on('[role="tab"]', "Properties")
        self.set_live(page, "Position x", "1.25")
        wait_until(lambda: "translation 1.25 0 0" in page.script, "all that was typed is in the text")
        page.click_on('.panel-properties input[aria-label="Flip y"]')
        wait_until(lambda: "scale 1 -1 1" in page.script, "it is set further")
        self.assertEqual(1, page.script.count("Transform"))
        self.until_final(page)

    def test_a_bare_model_is_opened_as_a_scene_that_places_it(self):
        (self.opened / "a.obj").write_text(TRIANGLE)
        for _ in range(2):
            self.running = self.studio("--workers", 1, path=self.opened / "a.obj")
            page = self.visit(None)
            self.until(page, lambda state: state["file"] == "untitled.tessera", "the scene is open")
            self.assertIn('file: "a.obj"', page.script)
            self.until_final(page)
            self.assertEqual(0, self.end_studio(self.running))
        self.assertEqual(["a.obj", "untitled.tessera"], sorted(each.name for each in self.opened.iterdir()))


SCRIPT = """\
size = 1
cam = Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> 45 }
Settings { camera -> cam }
red = Material { color -> rgb(1, 0, 0) }
Scene {
    Sphere { center -> vec3(-1, 0, 0) radius -> size material -> red }
    Sphere { center -> vec3(1, 0, 0) radius -> size material -> red }
}
"""


class Shared(StudioPageTest):
    def type_radius(self, page, old, text):
        # The field may still have the value before.
        wait_until(lambda: page.evaluate("""((old) => {
            const input = document.querySelector('.panel-properties input[aria-label="radius"], '
              + '.panel-properties label.number input');
            const all = [...document.querySelectorAll('.panel-properties label.number')];
            const found = all.find((each) => each.textContent.startsWith("radius"))?.querySelector("input") ?? input;
            if (found?.value !== old) return false;
            found.focus();
            found.select();
            return true;
          })(%s)""" % json.dumps(old)), "the radius")
        page.type(text)

    def test_a_literal_of_several_values_is_asked_about(self):
        self.scene("scene.crt", SCRIPT)
        page = self.begin(file="scene.crt", scene=False)
        page.click_on('[role="tab"]', "Scene")
        page.click_on('[role="treeitem"]', "Sphere")
        page.click_on('[role="tab"]', "Properties")
        self.type_radius(page, "1", "2")
        wait_until(lambda: page.has("dialog", "changes 2 things"), "it is asked")
        page.press("Escape")
        wait_until(lambda: not page.has("dialog"), "it is closed")
        self.assertEqual(SCRIPT, page.script)
        self.type_radius(page, "1", "2")
        page.click_on("dialog button", "Change all 2")
        wait_until(lambda: page.script == SCRIPT.replace("size = 1", "size = 2"), "the one literal is edited")
        self.type_radius(page, "2", "3")
        wait_until(lambda: page.script == SCRIPT.replace("size = 1", "size = 3"), "it is asked once")


class FileNames(StudioPageTest):
    def choose(self, page, name):
        """Clicks on it until it is taken: a list that was made anew meanwhile has moved."""
        def taken():
            box = page.box(".cm-tooltip-autocomplete li", name)
            if box:
                page.click_at(box[0], box[1])
            return not box
        wait_until(taken, f"{name} is chosen")

    def test_names_of_files_that_fit_are_proposed(self):
        (self.opened / "a.obj").write_text(TRIANGLE)
        (self.opened / "sky.png").write_bytes((SAMPLES / "hall.png").read_bytes())
        page = self.begin()
        proposed = lambda: page.evaluate(
            "[...document.querySelectorAll('.cm-tooltip-autocomplete .cm-completionLabel')].map((each) => each.textContent)")

        def propose(names, what):
            # On a busy machine the program may answer too late: then words of the file are proposed.
            def asked():
                page.press("Escape")
                page.press("Ctrl-Space")
                time.sleep(1)
                return proposed() == names
            wait_until(asked, what)
        page.click_on(".cm-scroller")
        page.press("Ctrl-End")
        page.type('includes { file: "')
        propose(["a.obj"], "models are proposed")
        self.choose(page, "a.obj")
        wait_until(lambda: page.script.endswith('includes { file: "a.obj"}'), "the name is typed")
        page.press("Ctrl-End")
        page.type('\ntextures { name: "sky" image { file: ')
        propose(["sky.png"], "pictures are proposed")
        self.choose(page, "sky.png")
        wait_until(lambda: 'image { file: "sky.png"' in page.script, "it is quoted")


@unittest.skipUnless(AXE.exists(), "NO AXE-CORE: the page was not built beside the program")
class Accessibility(StudioPageTest):
    def check(self, page, what):
        self.assertEqual([], page.evaluate(
            "axe.run(document, {resultTypes: ['violations']}).then((found) => found.violations"
            ".map((each) => `${each.id}: ${each.nodes.map((node) => node.target).join(' ')}`))"), what)

    def test_no_findings_on_start_page_and_dialog_of_models(self):
        (self.opened / "a.obj").write_text(TRIANGLE)
        self.scene(text=MODEL_SCENE)
        self.running = self.studio("--workers", 1)
        page = self.visit(None)
        page.evaluate(AXE.read_text() + "; 1")
        wait_until(lambda: page.has(".samples canvas"), "the samples")
        for theme in ("light", "dark"):
            page.press("F1")
            page.type(f"theme: {theme}")
            page.press("Enter")
            self.until(page, lambda state: state["theme"] == theme, theme)
            self.check(page, f"{theme}, the start page")
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        self.until_final(page)
        page.click_on('[role="tab"]', "Models")
        page.click_on('.panel-models [role="option"]', "a.obj", count=2)
        wait_until(lambda: page.has("dialog"), "the dialog")
        page.click_on('dialog input[aria-label="Scale each axis by itself"]')
        page.click_on("dialog label.number", "Position x")
        page.press("Backspace")
        page.type("-")
        wait_until(lambda: page.has("dialog .why"), "a wrong value")
        self.check(page, "the dialog")


if __name__ == "__main__":
    unittest.main()
