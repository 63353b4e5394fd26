#!/usr/bin/env python3
"""How the picture of the studio is looked at: enlarged, probed, compared, from several sides."""
import json
import math
import re
import shutil
import unittest

from exr import read_exr
from png import read_png
from studio_browser import StudioPageTest
from studio_case import SAMPLES, SCENE
from tessera_process import wait_until


class LookTest(StudioPageTest):
    def on_picture(self, page, right, down):
        """A point of the picture's frame, by shares of its sides; whole, as wheels and clicks are told."""
        _, _, x, y, width, height = page.box(".view-frame")
        return math.ceil(x + right * width), math.ceil(y + down * height)

    def film(self, width, height, *options, file="scene.tessera"):
        """The channels that `tessera render` makes."""
        result = self.run_program("render", self.opened / file, "-o", self.folder / "own.exr", "--size",
                                  f"{width}x{height}", "--quiet", *options)
        self.assertEqual(0, result.code, result.err)
        return read_exr(self.folder / "own.exr")[1]

    def shown_as(self, page, text, what):
        """The picture that is seen is that of another text."""
        self.scene("own.tessera", text)
        width, height, _ = page.pixels()
        expected = self.rendered("own.tessera", size=(width, height))
        wait_until(lambda: page.state["picture"]["final"] and page.pixels()[2] == expected, what)

    def probed(self, page, pixel=None):
        """What the table of values says, once it is of that pixel and has all values."""
        def read():
            rows = page.evaluate("[...document.querySelectorAll('.probed tr')].map((row) => [...row.cells].map((cell) => "
                                 "cell.textContent))")
            found = {name: values for name, *values in rows}
            is_there = "samples" in found and (pixel is None or found["pixel"] == [str(each) for each in pixel])
            return found if is_there else None
        return wait_until(read, f"the values of {pixel or 'the pixel'} are shown")


class Tiles(LookTest):
    LONG = SCENE.replace("samples_per_pixel: 4", "samples_per_pixel: 65536")
    COLOURS = ["#e69f00", "#56b4e9"]

    def colours(self, page):
        """Those of workers that the outlines have, in order."""
        found = page.evaluate("""(() => {
            const canvas = document.querySelector("canvas.tiles");
            const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            const found = new Set();
            for (let i = 0; i < data.length; i += 4) {
              if (data[i + 3] === 255) found.add("#" + [0, 1, 2].map((j) => data[i + j].toString(16).padStart(2, "0")).join(""));
            }
            return [...found];
          })()""")
        return [each for each in self.COLOURS if each in found]

    def toggle(self, page):
        page.press("F1")
        page.type("outline tiles")
        page.press("Enter")

    def test_tiles_are_outlined_by_worker_on_demand(self):
        self.scene(text=self.LONG)
        self.running = self.studio("--workers", 2)
        page = self.visit(None)
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        self.until(page, lambda state: state["picture"]["samples"] > 4, "it is traced")
        self.assertEqual([], self.colours(page))
        self.assertFalse(page.has(".worker-legend"))
        self.toggle(page)
        wait_until(lambda: self.colours(page) == self.COLOURS, "tiles of both workers are outlined")
        listed = "[...document.querySelectorAll('.worker-legend li')].map((each) => each.firstChild.nextSibling.data)"
        page.click_on('[role="tab"]', "Farm")
        rows = "[...document.querySelectorAll('[aria-label=\"Workers\"] tbody tr')].map((row) => row.cells[0].textContent)"
        wait_until(lambda: len(page.evaluate(rows)) == 2, "the panel lists both workers")
        names = page.evaluate(rows)
        numbers, workers = zip(*sorted(each.split(" ") for each in page.evaluate(listed)))
        self.assertEqual((("1", "2"), sorted(names)), (numbers, sorted(workers)))
        # They go with what is traced, or with the wish for them.
        page.click_on(".view-frame")
        page.press("Escape")
        wait_until(lambda: not self.colours(page), "nothing is traced")
        page.click_on(".view-bar button", "Refresh")
        wait_until(lambda: self.colours(page), "tiles are outlined again")
        self.toggle(page)
        wait_until(lambda: not self.colours(page) and not page.has(".worker-legend"), "they are gone")


class Probe(LookTest):
    CHANNELS = {"light": "RGB", "albedo": ("albedo.R", "albedo.G", "albedo.B"), "normal": ("N.X", "N.Y", "N.Z"),
                "depth": ("Z",), "position": ("P.X", "P.Y", "P.Z"), "id": ("id",), "samples": ("samples",),
                "variance": ("variance.R", "variance.G", "variance.B"), "primitive": ("primitive",)}

    def assert_of_film(self, probed, film, pixels, width):
        """The probed numbers are those of the film and of the picture, to the digits that are shown."""
        x, y = map(int, probed["pixel"])
        for layer, channels in self.CHANNELS.items():
            expected = [float(f"{film[channel][y * width + x]:.5g}") for channel in channels]
            self.assertEqual(expected, [float(each) for each in probed[layer]], layer)
        shown = pixels[3 * (y * width + x):][:3]
        self.assertEqual([str(each) for each in shown] + ["#" + shown.hex()], probed["8 bit"])

    def test_every_value_of_the_film_is_under_the_pointer(self):
        page = self.begin()
        at = self.on_picture(page, .5, .5)
        page.click_on(".view-frame")
        page.press("p")
        before = page.state
        page.pointer("mouseMoved", *at)
        first = self.probed(page)
        self.until(page, lambda state: state["picture"]["final"], "the last picture is shown")
        width, height, pixels = page.pixels()
        film = self.film(width, height, "--aovs", "all")
        pixel = int(first["pixel"][0]), int(first["pixel"][1])
        # What refines the picture refines the numbers.
        wait_until(lambda: self.probed(page, pixel)["samples"] == ["4"], "the last pass is probed")
        self.assert_of_film(self.probed(page, pixel), film, pixels, width)
        self.assertEqual(before["camera"], page.state["camera"])
        # Another tone has other bytes of the same light.
        of_first_tone = self.probed(page, pixel)["8 bit"]
        page.press("]")
        wait_until(lambda: self.probed(page, pixel)["8 bit"] != of_first_tone, "the bytes are those of the new tone")
        wait_until(lambda: page.pixels()[2] != pixels, "the picture has the new tone")
        self.assert_of_film(self.probed(page, pixel), film, page.pixels()[2], width)

    def test_the_cross_hair_is_moved_by_keys_and_picks(self):
        page = self.begin()
        page.click_on(".view-frame")
        page.pointer("mouseMoved", 5, 5)
        page.press("p")
        page.press("Enter")
        first = self.probed(page)
        x, y = map(int, first["pixel"])
        page.press("Right")
        page.press("Shift-Down", 10)
        self.assertEqual("scene", page.state["camera"]["mode"], "the arrows move the cross-hair alone")
        self.probed(page, (x + 16, y + 10))
        self.assertTrue(page.has(".crosshair"))
        page.press("Enter")
        self.until(page, lambda state: state["selection"]["line"] == 5, "the ball's text is selected")
        page.press("Escape")
        wait_until(lambda: not page.has(".crosshair"), "the cross-hair is gone")
        page.press("Right")
        self.until(page, lambda state: state["camera"]["mode"] == "free", "the arrows orbit again")


class Zoom(LookTest):
    def type_into(self, page, label, text):
        """Types into a field below the picture."""
        page.evaluate(f"""[...document.querySelectorAll(".view-options label.field")].find((each) =>
            each.querySelector("span").textContent === {json.dumps(label)}).querySelector("input").focus()""")
        page.press("Ctrl-A")
        page.type(text)

    def zoomed(self, page, factor):
        return self.until(page, lambda state: state["view"]["zoom"] == factor, f"the picture is {factor} times as large")

    def test_pixels_are_enlarged_about_the_pointer(self):
        page = self.begin()
        at = self.on_picture(page, .4, .6)
        page.click_at(*at)
        page.wait_for_frames()
        page.press("p")
        before = self.probed(page)["pixel"]
        serial = self.until_final(page)["picture"]["serial"]
        for factor in (2, 3, 4, 6, 8):
            page.wheel(*at, -1, held=("Alt",))
            self.zoomed(page, factor)
        # The same pixel is under the pointer, and eight points on the screen further the next one.
        page.pointer("mouseMoved", at[0] + 8, at[1])
        x, y = int(before[0]), int(before[1])
        self.probed(page, (x + 1, y))
        page.pointer("mouseMoved", at[0], at[1] - 16)
        self.probed(page, (x, y - 2))
        page.drag(at, (at[0] + 80, at[1]), held=("Alt",))
        page.pointer("mouseMoved", at[0] + 80, at[1] + 1)
        self.probed(page, (x, y))
        state = page.state
        self.assertEqual(("scene", serial), (state["camera"]["mode"], state["picture"]["serial"]), "nothing is traced")
        page.press("o")
        self.zoomed(page, 1)

    def test_keys_enlarge_up_to_64_and_the_button_goes_back(self):
        page = self.begin()
        page.click_on(".view-frame")
        page.press("z", 20)
        self.zoomed(page, 64)
        page.press("Shift-Z")
        self.zoomed(page, 48)
        page.press("p")
        at = self.on_picture(page, .5, .5)
        page.pointer("mouseMoved", *at)
        x, y = map(int, self.probed(page)["pixel"])
        width = page.box(".view-frame")[4]
        page.press("Ctrl-Right")
        page.pointer("mouseMoved", at[0] + 1, at[1])
        moved = self.probed(page)["pixel"]
        wait_until(lambda: abs(int(self.probed(page)["pixel"][0]) - x - width / 480) <= 1, f"a tenth of the frame: {moved}")
        page.click_on(".view-bar button", "48:1")
        self.zoomed(page, 1)

    def test_scales_are_points_of_the_screen_for_a_pixel(self):
        page = self.begin()
        page.click_on(".view-options summary")
        self.type_into(page, "Width", "1600")
        self.type_into(page, "Height", "900")
        self.until(page, lambda state: (state["view"]["width"], state["view"]["height"]) == (1600, 900), "another size")
        sheet = lambda: page.evaluate("document.querySelector('.view-sheet').getBoundingClientRect().width")
        frame = page.box(".view-frame")[4]
        self.assertLess(frame, 800)
        wait_until(lambda: page.has(".view-bar button", "fit"), "that it is reduced is told")
        self.assertEqual(frame, sheet())
        page.click_on(".view-bar button", "fit")
        self.zoomed(page, 1)
        self.assertAlmostEqual(1600, sheet(), delta=1e-3)
        wait_until(lambda: page.has(".view-bar button", "1:1"), "that it is 1:1 is told")
        at = self.on_picture(page, .5, .5)
        page.click_at(*at)
        page.press("z", 3)
        self.zoomed(page, 4)
        self.assertAlmostEqual(6400, sheet(), delta=1e-2)
        page.press("z", 20)
        self.zoomed(page, 64)
        self.assertAlmostEqual(64 * 1600, sheet(), delta=1)
        page.press("Shift-O")
        wait_until(lambda: abs(sheet() - frame) < 1, "all of the picture is seen")
        page.press("o")
        self.zoomed(page, 1)

    def test_a_drag_over_the_enlarged_picture_moves_what_is_under_it(self):
        page = self.begin()
        page.click_on(".view-frame")
        page.press("z", 3)
        self.zoomed(page, 4)
        before = page.state["camera"]
        at = self.on_picture(page, .5, .5)
        page.drag(at, (at[0] + 40, at[1]), held=("Shift",))
        enlarged = self.until(page, lambda state: state["camera"] != before, "it pans")["camera"]
        page.press("o")
        page.press("Home")
        self.until(page, lambda state: state["camera"]["mode"] == "scene", "the scene's camera")
        page.drag(at, (at[0] + 10, at[1]), held=("Shift",))
        plain = self.until(page, lambda state: state["camera"]["mode"] == "free", "it pans")["camera"]
        for one, other in zip(enlarged["eye"], plain["eye"]):
            self.assertAlmostEqual(one, other, 9)


class Compare(LookTest):
    NAMES = {"max difference": "max difference", "mean difference": "mean difference", "rmse": "rmse",
             "linear rmse": "rmse", "SMAPE": "SMAPE", "FLIP": "FLIP", "SSIM": "SSIM",
             "99.9 % are within": "99.9 % are within", "mean ratio": "mean ratio"}

    def seen(self, page):
        """The rows of the picture as they are on the screen, where nothing lies over them; the pointer is elsewhere."""
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.pointer("mouseMoved", 2, 2)
        wait_until(lambda: page.evaluate("document.querySelector('.outlines').dataset.hovered === '0' && "
                                         "document.querySelector('.outlines').dataset.selected === '0'"), "no rims")
        page.wait_for_frames()
        page.screenshot(self.folder / "seen.png")
        width, _, pixels = read_png(self.folder / "seen.png")
        _, _, x, y, w, h = (round(each) for each in page.box(".view-frame"))
        rows = range(h * 2 // 5, h * 3 // 4)
        return [pixels[3 * ((y + row) * width + x):][:3 * w] for row in rows]

    def rows_of(self, page):
        width, height, pixels = page.pixels()
        return [pixels[3 * row * width:][:3 * width] for row in range(height * 2 // 5, height * 3 // 4)]

    def command(self, page, name):
        page.press("F1")
        page.type(name)
        page.press("Enter")

    def edited(self, page):
        """Pins what is shown, and changes the scene by the editor's keys."""
        page.click_on(".view-bar button", "Pin")
        wait_until(lambda: page.has(".compare"), "it is pinned")
        first = self.rows_of(page)
        self.write_at(page, 5, ' nodes { name: "small" transform { steps { translate { x: 1 z: 2 } } } shape { '
                               'materials: "red" sphere { radius: .4 } } }')
        self.shown_as(page, page.script, "the changed scene is shown")
        second = self.rows_of(page)
        self.assertNotEqual(first, second)
        return first, second

    def test_the_pinned_picture_in_place_of_the_other_and_beside_it(self):
        page = self.begin()
        first, second = self.edited(page)
        self.assert_same(second, self.seen(page))
        self.command(page, "the pinned picture, or")
        wait_until(lambda: self.seen(page) == first, "the pinned picture is seen")
        self.command(page, "the pinned picture, or")
        wait_until(lambda: self.seen(page) == second, "the other one is seen")
        self.command(page, "compare: wipe")
        middle = len(first[0]) // 6
        left = [row[:3 * (middle - 3)] for row in first]
        right = [row[3 * (middle + 3):] for row in second]
        wait_until(lambda: [row[:3 * (middle - 3)] for row in self.seen(page)] == left, "the pinned one left of the line")
        self.assert_same(right, [row[3 * (middle + 3):] for row in self.seen(page)])
        # By mouse and by keys.
        x, y = page.middle(".wipe-line")
        box = page.box(".view-frame")
        page.drag((x, y), (box[2] + .25 * box[4], y))
        line = '[role="separator"].wipe-line'
        wait_until(lambda: page.evaluate(f"document.querySelector('{line}').ariaValueNow") == "25", "the line was moved")
        page.press("Right", 2)
        wait_until(lambda: page.evaluate(f"document.querySelector('{line}').ariaValueNow") == "27", "by keys, too")
        page.click_on(".compare button", "Unpin")
        wait_until(lambda: self.seen(page) == second, "nothing is pinned")

    def test_the_numbers_are_those_of_compare(self):
        page = self.begin()
        self.edited(page)
        page.press("Ctrl-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        self.command(page, "compare: difference")
        serial = page.state["picture"]["serial"]
        wait_until(lambda: page.has(f'.numbers[data-serial="{serial}"]'), "the last picture is compared")
        shown = dict(page.evaluate("[...document.querySelectorAll('.numbers tr')].map((row) => [...row.cells].map("
                                   "(cell) => cell.textContent))"))
        width, height, _ = page.pixels()
        self.scene("before.tessera")
        for name in ("before", "scene"):
            result = self.run_program("render", self.opened / f"{name}.tessera", "-o", self.folder / f"{name}.exr",
                                      "--size", f"{width}x{height}", "--quiet")
            self.assertEqual(0, result.code, result.err)
        result = self.run_program("compare", self.folder / "scene.exr", self.folder / "before.exr", "--metrics",
                                  "--max-diff", 1000)
        self.assertEqual(0, result.code, result.err)
        lines = {line[:18].strip(): line[18:].strip() for line in result.out.splitlines()}
        for theirs, ours in self.NAMES.items():
            self.assertEqual(float(f"{float(lines[theirs]):.5g}"), float(shown[ours]), ours)
        self.assertEqual(float(f"{float(lines['relMSE'].split(',')[0]):.5g}"), float(shown["relMSE"]))
        self.assertEqual(lines["differing pixels"].split()[0], shown["differing pixels"])
        self.assertEqual(lines["the worst pixel"].split(":")[0].replace(",", ", "), shown["worst pixel"])
        self.assertGreater(float(shown["rmse"]), 0)
        scale = page.evaluate("[...document.querySelectorAll('.legend .steps span')].map((each) => each.textContent)")
        most = float(shown["max difference"])
        for text, share in zip(scale, (0, 1 / 16, 1 / 4, 9 / 16, 1), strict=True):
            self.assertAlmostEqual(share * most, float(text), delta=.01 * most, msg="a scale of the colours")

    def test_the_picture_before_an_edit(self):
        page = self.begin()
        page.click_on(".view-bar button", "Before")
        wait_until(lambda: page.has(".notices", "before"), "there is none yet")
        first = self.rows_of(page)
        self.write_at(page, 5, "")
        page.press("Left", len(" } } }"))
        page.press("Backspace")  # one change: the radius is 1.2
        self.shown_as(page, SCENE.replace("1.25", "1.2"), "the smaller ball is shown")
        page.click_on(".view-bar button", "Before")
        wait_until(lambda: page.has(".wipe-line"), "it is beside the other")
        self.command(page, "the pinned picture, or")
        wait_until(lambda: self.seen(page) == first, "the picture before the edit is seen")

    def test_pictures_of_two_sizes_are_not_compared(self):
        page = self.begin()
        page.click_on(".view-frame")
        page.press("c")
        wait_until(lambda: page.has(".compare"), "it is pinned")
        page.press("n")
        wait_until(lambda: page.has(".compare .numbers"), "it equals itself")
        self.assertEqual("0", page.evaluate("document.querySelector('.numbers td').textContent"))
        page.resize(1400, 800)
        wait_until(lambda: page.has(".compare [role=alert]", "sizes differ"), "it says why not")


class Panes(LookTest):
    CAMERA = """cameras {{ world_from_camera {{ steps {{ look_at {{
        eye {{ x: {eye[0]!r} y: {eye[1]!r} z: {eye[2]!r} }} target {{ x: {target[0]!r} y: {target[1]!r} z: {target[2]!r} }}
        up {{ x: {up[0]!r} y: {up[1]!r} z: {up[2]!r} }} }} }} }}
        orthographic {{ min_x: {low!r} min_y: {low!r} max_x: {high!r} max_y: {high!r} }} }}"""

    def set_panes(self, page, count):
        page.press("F1")
        page.type(f"view: {count} pane")
        page.press("Enter")
        return self.all_final(page, count)

    def all_final(self, page, count):
        return self.until(page, lambda state: len(state["panes"]) == count and all(
            pane["final"] and pane["size"][0] > 0 for pane in state["panes"]),
            f"{count} panes show their last pictures")["panes"]

    def pixels_of(self, page, number, size):
        """A pane's picture, once it has its size: the one before is shown until then."""
        return wait_until(lambda: (seen := page.pixels(number))[:2] == tuple(size) and seen[2], "a picture of the size")

    def at(self, page, pane, right=.5, down=.5):
        x, y, w, h = page.evaluate(f"""(() => {{ const box = document.querySelectorAll('.view-frame')[{pane}]
            .getBoundingClientRect(); return [box.x, box.y, box.width, box.height]; }})()""")
        return x + right * w, y + down * h

    def test_four_panes_show_the_sides_as_render_does(self):
        page = self.begin()
        panes = self.set_panes(page, 4)
        self.assertEqual([None, "top", "front", "side"], [pane["side"] for pane in panes])
        pictures = {}
        for number, pane in enumerate(panes):
            width, height = pane["size"]
            pictures[number] = self.pixels_of(page, number, pane["size"])
            if number == 0:
                continue
            camera = pane["camera"]
            half = camera["orthographic"] / 2
            lines = SCENE.splitlines()
            lines[1] = self.CAMERA.format(**camera, low=-half, high=half).replace("\n", " ")
            self.scene("own.tessera", "\n".join(lines))
            self.assert_same(self.rendered("own.tessera", size=(width, height)), pictures[number])
            # The ball is the scene: it fills the shorter side but for the margin.
            self.assertAlmostEqual(1.1 * 2.5, camera["orthographic"], 9)
        self.assertEqual(4, len(set(pictures.values())))
        # They follow the text, and are gone when they are not seen.
        self.write_at(page, 5, ' nodes { shape { sphere { center { y: 3 } } } }')
        self.until(page, lambda state: state["panes"][2]["camera"]["orthographic"] > panes[2]["camera"]["orthographic"],
                   "the scene is larger")
        wait_until(lambda: page.pixels(2)[2] != pictures[2], "another picture")
        self.set_panes(page, 1)
        self.assertEqual(1, page.evaluate("document.querySelectorAll('.view-frame').length"))

    def test_hovering_and_picking_in_each_pane(self):
        page = self.begin()
        self.set_panes(page, 4)
        for number in range(4):
            outlines = f"document.querySelectorAll('.outlines')[{number}].dataset.hovered"
            page.pointer("mouseMoved", *self.at(page, number))
            wait_until(lambda: int(page.evaluate(outlines)) > 0, f"the ball is outlined in pane {number + 1}")
            wait_until(lambda: page.has(".hover-name", "ball"), "its name is told")
            page.press("Ctrl-Home")
            page.click_at(*self.at(page, number))
            self.until(page, lambda state: state["selection"]["line"] == 5, "its text is selected")
            page.click_at(*self.at(page, number, .02, .95))
            page.click_on(".cm-scroller")
            page.press("Ctrl-Home")
            self.until(page, lambda state: state["selection"]["line"] == 1, "the cursor is elsewhere")

    def test_a_side_is_moved_and_fitted_again(self):
        page = self.begin()
        first = self.set_panes(page, 2)[1]["camera"]

        def moved(act, what):
            before = page.state["panes"][1]["camera"]
            act()
            return self.until(page, lambda state: state["panes"][1]["camera"] != before, what)["panes"][1]["camera"]
        x, y = self.at(page, 1)
        panned = moved(lambda: page.drag((x, y), (x + 30, y + 20)), "a drag moves it")
        self.assertLess(panned["target"][0], first["target"][0])
        self.assertLess(panned["target"][2], first["target"][2])
        self.assertEqual(first["up"], panned["up"])
        for side in range(3):
            self.assertAlmostEqual(first["eye"][side] - first["target"][side], panned["eye"][side] - panned["target"][side], 9)
        nearer = moved(lambda: page.wheel(x, y, -3), "the wheel enlarges")
        self.assertLess(nearer["orthographic"], panned["orthographic"])
        moved(lambda: page.press("Right"), "an arrow moves it")
        self.assertEqual("scene", page.state["camera"]["mode"], "the first pane stays")
        moved(lambda: page.press("3"), "a key chooses the side")
        self.assertEqual("side", page.state["panes"][1]["side"])
        moved(lambda: page.press("1"), "and back")
        self.assertEqual(first, page.state["panes"][1]["camera"])
        self.all_final(page, 2)

    def test_splits_are_moved_and_kept(self):
        page = self.begin()
        before = self.set_panes(page, 4)
        across, down = '[aria-label="Width of the left panes"]', '[aria-label="Height of the upper panes"]'
        # They cross in the middle.
        x, y = page.box(across)[:2]
        page.drag((x, y + 30), (x - 60, y + 30))
        after = self.until(page, lambda state: state["panes"][0]["size"][0] < before[0]["size"][0] - 50, "it is narrower")
        self.assertGreater(after["panes"][1]["size"][0], before[1]["size"][0])
        x, y = page.box(down)[:2]
        page.click_at(x + 30, y)
        wait_until(lambda: page.focused() == "Height of the upper panes", "the split has the focus")
        page.press("Down", 4)
        self.until(page, lambda state: state["panes"][0]["size"][1] > before[0]["size"][1], "it is higher")
        self.all_final(page, 4)
        self.assertEqual("54", page.evaluate(f"document.querySelector('{down}').ariaValueNow"))
        kept = self.folder / "config/tessera/studio.json"
        wait_until(lambda: kept.exists() and '"down":0.54' in kept.read_text().replace(" ", ""), "it is kept")
        page.call("Page.navigate", url="about:blank")
        self.navigate(page)
        self.until(page, lambda state: len(state["panes"]) == 4, "four panes again")
        self.assertEqual("54", page.evaluate(f"document.querySelector('{down}').ariaValueNow"))


class Tree(LookTest):
    SMALL = 'nodes { name: "small" transform { steps { translate { x: 1 z: 2 } } } shape { materials: "red" sphere { radius: .4 } } }\n'

    def row(self, page, name):
        return wait_until(lambda: page.has('.tree .row', name) and page.evaluate(
            "[...document.querySelectorAll('.tree .row')].find((row) => row.querySelector('.name').textContent === "
            f"'{name}')?.textContent"), f"the row of {name}")

    def test_what_is_hidden_or_alone_is_so_in_the_view_alone(self):
        self.scene("scene.tessera", SCENE + self.SMALL)
        page = self.begin(scene=False)
        wait_until(lambda: "(1, 0, 2)" in self.row(page, "small"), "the centre of the small ball")
        # Each line of the text is an entity of the scene.
        self.assertEqual(str(len((SCENE + self.SMALL).splitlines())), page.text(".tree .row .count"))
        self.assertTrue(page.has(".summary", "bounds: (-1.25, -1.25, -1.25) to (1.4, 1.25, 2.4)"))
        page.click_on(".tree .row .name", "small")
        page.press("h")
        self.shown_as(page, SCENE, "the small ball is hidden")
        page.click_on(".view-bar button", "1 hidden")
        self.shown_as(page, SCENE + self.SMALL, "all is shown")
        page.click_on(".tree .row .name", "small")
        page.press("s")
        ball = next(line for line in SCENE.splitlines(True) if '"ball"' in line)
        self.shown_as(page, SCENE.replace(ball, "") + self.SMALL, "the small ball is alone")
        self.assertTrue(page.has(".view-bar button", "1 alone"))
        # An edit keeps it; the button that tells of it ends it.
        self.write_at(page, 7, " ")
        page.click_on(".view-bar button", "1 alone")
        self.shown_as(page, SCENE + self.SMALL, "all is shown again")
        self.assertEqual(SCENE + self.SMALL[:-1] + " \n", page.script)

    def test_f_frames_what_is_selected_and_shift_f_all(self):
        self.scene("scene.tessera", SCENE + self.SMALL)
        page = self.begin(scene=False)
        self.row(page, "small")
        page.click_on(".tree .row .name", "small")
        # A click would select what is under it.
        while not page.evaluate("document.activeElement.matches('.view-frame')"):
            page.press("F6")
        page.press("f")
        framed = self.until(page, lambda state: state["camera"]["mode"] == "free", "the camera is moved")["camera"]
        for got, expected in zip(framed["target"], (1, 0, 2)):
            self.assertAlmostEqual(expected, got, 5)
        near = math.dist(framed["eye"], framed["target"])
        page.press("Shift-F")
        whole = self.until(page, lambda state: state["camera"] != framed, "all is framed")["camera"]
        for got, expected in zip(whole["target"], (.075, 0, .575)):
            self.assertAlmostEqual(expected, got, 5)
        # As the half diagonals of their boxes.
        wide = math.dist(whole["eye"], whole["target"])
        self.assertAlmostEqual(math.dist((-1.25, -1.25, -1.25), (1.4, 1.25, 2.4)) / math.dist((0, 0, 0), (.8, .8, .8)), wide / near, 4)

    def test_ten_thousand_rows(self):
        self.scene("many.tessera", SCENE + "".join(
            f'nodes {{ name: "n{i}" transform {{ steps {{ translate {{ x: {i % 100} z: {-i // 100} }} }} }} '
            "shape { sphere { radius: .1 } } }\n" for i in range(10_000)))
        page = self.begin(file="many.tessera", scene=False)
        self.row(page, "ball")
        page.click_on(".tree .row .name", "ball")
        page.press("End")
        self.row(page, "n9999")
        self.assertEqual("nodes[10001].shape", page.state["selection"]["entity"])
        self.assertLess(page.evaluate("document.querySelectorAll('.tree .row').length"), 100)
        wait_until(lambda: "(99, 0, -100)" in self.row(page, "n9999"), "its centre is told")
        page.click_on('[aria-label="Search the scene"]')
        page.type("n5432")
        wait_until(lambda: page.evaluate("document.querySelectorAll('.tree .row').length") <= 3, "one is found")
        self.row(page, "n5432")


class Turning(LookTest):
    def turned(self, page, pattern, before, act):
        """The numbers after the pattern in the text, once they are others than before."""
        def numbers():
            found = re.search(pattern + r"([^}]*)", page.script)
            return found and [float(each) for each in re.findall(r"-?[\d.]+(?:e-?\d+)?", found[1])]
        self.assertEqual(before, numbers())
        camera = page.state["camera"]
        act()
        wait_until(lambda: numbers() != before, "the text was edited")
        self.until_final(page)
        self.assertEqual(camera, page.state["camera"])
        return numbers()

    def undo_to(self, page, text):
        """By one step."""
        page.click_on(".cm-scroller")
        wait_until(lambda: page.evaluate("document.activeElement.classList.contains('cm-content')"), "the editor has the focus")
        page.press("Ctrl-Z")
        wait_until(lambda: page.script == text, "one step of undo")

    def drag_background(self, page, start, end, field):
        """Takes hold of it, and goes on once the program has told its fields."""
        wait_until(lambda: page.has(".tree .row .name"), "what the text has is known")
        page.click_on('[role="tab"]', "Properties")
        page.pointer("mouseMoved", *start, held=("Ctrl",))
        page.pointer("mousePressed", *start, "left", 1, ("Ctrl",), clickCount=1)
        page.pointer("mouseMoved", start[0] + 10, start[1], "left", 1, ("Ctrl",))
        wait_until(lambda: page.has(".property", field), "its fields are known")
        page.pointer("mouseMoved", *end, "left", 1, ("Ctrl",))
        page.wait_for_frames()
        page.pointer("mouseReleased", *end, "left", 0, ("Ctrl",), clickCount=1)

    def test_the_light_that_is_selected_follows_the_pointer(self):
        page = self.begin()
        page.click_on(".tree .row .name", "directional")
        wait_until(lambda: page.state["selection"]["entity"] == "nodes[1].light", "the light is selected")
        wait_until(lambda: page.evaluate("document.querySelector('.panel-properties, .panel-scene') !== null"), "it is there")
        x, y = self.on_picture(page, .5, .3)
        after = self.turned(page, r"direction \{", [-.5, -1, -.6], lambda: page.drag((x, y), (x + 80, y), held=("Ctrl",)))
        self.assertLess(after[0], -.5, "the light comes from further right")
        self.saved_as_text(page)
        self.undo_to(page, SCENE)

    def test_a_light_with_a_place_is_moved_and_turned(self):
        spot = SCENE.splitlines()
        spot[-1] = ('nodes { name: "above" light { spot { position { x: 0 y: 3 z: 0 } direction { x: 0 y: -1 z: 0 } '
                    "beam_width: 20 cut_off: 40 } } }")
        spot = "\n".join(spot) + "\n"
        self.scene(text=spot)
        page = self.begin(scene=False)
        page.click_on(".tree .row .name", "spot")
        page.click_on('[role="tab"]', "Properties")
        wait_until(lambda: page.has(".property", "position"), "the light is selected")
        x, y = self.on_picture(page, .5, .3)
        after = self.turned(page, r"position \{", [0, 3, 0], lambda: page.drag((x, y), (x + 40, y), held=("Ctrl",)))
        self.assertGreater(after[0], .1)
        self.assertEqual([3, 0], after[1:], "along the plane that faces the camera")
        self.saved_as_text(page)
        self.undo_to(page, spot)
        self.until_final(page)
        after = self.turned(page, r" direction \{", [0, -1, 0], lambda: page.drag((x, y), (x + 40, y), held=("Ctrl", "Shift")))
        self.assertIn("position { x: 0 y: 3 z: 0 }", page.script)

    def saved_as_text(self, page):
        """The picture is that of the text."""
        self.scene("own.tessera", page.script)
        width, height, pixels = page.pixels()
        self.assert_same(self.rendered("own.tessera", size=(width, height)), pixels)

    def test_the_sun_of_the_background_where_no_light_is_selected(self):
        sky = "background { sun_and_sky { sun_direction { x: 0 y: 1 z: 1 } } }"
        lines = SCENE.splitlines()
        lines[2] = sky
        self.scene("scene.tessera", "\n".join(lines) + "\n")
        page = self.begin(scene=False)
        x, y = self.on_picture(page, .5, .3)
        after = self.turned(page, r"sun_direction \{", [0, 1, 1], lambda: self.drag_background(page, (x, y), (x + 80, y), "sun_direction"))
        self.assertGreater(after[0], 0, "it follows the pointer")

    def test_a_panorama_is_turned_and_its_camera_turns(self):
        shutil.copy(SAMPLES / "hall.png", self.opened)
        lines = SCENE.splitlines()
        lines[1] = 'cameras { spherical { field_of_view: 120 } world_from_camera { steps { look_at { eye { y: 1 z: 5 } target { } } } } }'
        lines[2] = 'textures { name: "hall" image { file: "hall.png" } } background { panorama { texture: "hall" angle: 25 } }'
        self.scene("scene.tessera", "\n".join(lines) + "\n")
        page = self.begin(scene=False)
        x, y = self.on_picture(page, .5, .3)
        self.turned(page, r"angle:", [25], lambda: self.drag_background(page, (x, y), (x + 100, y), "angle"))
        wait_until(lambda: "angle: -10 " in page.script, "it turns by .35 degrees a pixel")
        before = page.state["camera"]
        page.drag((x, y), (x + 50, y + 10))
        turned = self.until(page, lambda state: state["camera"]["mode"] == "free", "the camera turns")["camera"]
        self.assertEqual(before["eye"], turned["eye"], "about itself")
        self.assertNotEqual(before["target"], turned["target"])
        page.press("Left")
        again = self.until(page, lambda state: state["camera"] != turned, "by keys, too")["camera"]
        self.assertEqual(before["eye"], again["eye"])


if __name__ == "__main__":
    unittest.main()
