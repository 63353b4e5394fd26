#!/usr/bin/env python3
"""Panels of the studio's page: the tree, properties, models and settings change the text in its smallest parts."""
import json
import os
import unittest

from studio_browser import StudioPageTest
from studio_case import SCENE
from tessera_process import is_worker, marked_processes, wait_until

SPHERE = "o sphere\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


SCRIPT = """red = Material { color -> rgb(.8, .1, .1) }
Settings { camera -> Camera { position -> vec3(0, 1, -6) pointing -> vec3(0, 0, 0) fov -> 50 } }
block = Macro(x) { Sphere { center -> vec3(x, 0, 0) radius -> .6 material -> red } }
Scene {
  Box { cornerA -> vec3(-9, -2, -9) cornerB -> vec3(9, -1, 9) material -> red }
  block(-1)
  i = 0
  while (i < 3) { block(i) i = i + 1 }
}
"""


class PanelsTest(StudioPageTest):
    def show(self, page, panel):
        page.click_on('[role="tab"]', panel)

    def click_scrolled(self, page, selector, text=None):
        """Clicks on the first of these that has the text, wherever its panel is scrolled to."""
        wait_until(lambda: page.evaluate(f"""(() => {{
            const found = [...document.querySelectorAll({json.dumps(selector)})].find((each) =>
              each.textContent.includes({json.dumps(text or "")}));
            found?.scrollIntoView({{ block: "center" }});
            return found !== undefined;
          }})()"""), f"{selector} {text or ''}")
        page.click_on(selector, text)

    def choose(self, page, name):
        """Selects an entity in the tree."""
        self.show(page, "Scene")
        wait_until(lambda: page.evaluate(f"""(() => {{
            const row = [...document.querySelectorAll('[role="treeitem"]')].find((each) =>
              each.querySelector(".name").textContent === {json.dumps(name)});
            row?.scrollIntoView({{ block: "center" }});
            row?.setAttribute("data-chosen", "");
            return row !== undefined;
          }})()"""), f"{name} is in the tree")
        page.click_on("[data-chosen]")
        page.evaluate("document.querySelector('[data-chosen]')?.removeAttribute('data-chosen')")

    def properties(self, page, name):
        self.choose(page, name)
        self.show(page, "Properties")

    def field(self, label):
        return f"input[aria-label={json.dumps(label)}]"

    def input_of(self, page, label):
        """The middle of the field with that label, whose label is beside it."""
        return wait_until(lambda: page.evaluate(f"""(() => {{
            for (const each of document.querySelectorAll("label.field")) {{
              if (each.querySelector("span")?.textContent !== {json.dumps(label)}) continue;
              const input = each.querySelector("input");
              input.scrollIntoView({{ block: "center" }});
              const box = input.getBoundingClientRect();
              return [box.x + box.width / 2, box.y + box.height / 2];
            }}
            return null;
          }})()"""), f"the field {label}")

    def has_text(self, page, text, what):
        wait_until(lambda: page.script == text, what)

    def value(self, page, label):
        self.input_of(page, label)
        return page.evaluate(f"""[...document.querySelectorAll("label.field")].find((each) =>
            each.querySelector("span")?.textContent === {json.dumps(label)}).querySelector("input").value""")

    def invalid(self, page):
        return page.evaluate("document.querySelector('[aria-invalid=\"true\"]') !== null")


class Tree(PanelsTest):
    def test_the_tree_selects_the_text_and_the_cursor_the_tree(self):
        page = self.begin()
        self.choose(page, "ball")
        state = self.until(page, lambda each: each["selection"]["entity"] == "nodes[0]", "the ball is selected")
        lines = SCENE.split("\n")
        self.assertTrue(lines[state["selection"]["line"] - 1].startswith('nodes { name: "ball"'))
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        self.until(page, lambda each: each["selection"]["entity"] == "settings", "the cursor's entity is selected")

    def test_entities_are_added_doubled_and_removed(self):
        page = self.begin()
        self.choose(page, "ball")
        self.until(page, lambda each: each["selection"]["entity"] == "nodes[0]", "the ball is selected")
        page.press("Ctrl-D")
        wait_until(lambda: page.script.count("radius: 1.25") == 2, "there are two")
        self.until(page, lambda each: each["selection"]["entity"] == "nodes[1]", "the copy is selected")
        page.press("Delete")
        self.has_text(page, SCENE, "the copy was selected, and is gone")


    def test_ten_thousand_entities(self):
        balls = (f'nodes {{ name: "n{i}" transform {{ steps {{ translate {{ x: {i % 100} z: {-(i // 100)} }} }} }} '
                 'shape { materials: "red" sphere { radius: .3 } } }\n' for i in range(10_000))
        self.scene(text=SCENE + "".join(balls))
        page = self.begin(scene=False)
        self.show(page, "Scene")
        drawn = "document.querySelectorAll('[role=\"treeitem\"]').length"
        wait_until(lambda: page.has('[role="treeitem"]', "ball"), "the tree is there")
        self.assertLess(page.evaluate(drawn), 60, "rows that nobody sees are not drawn")
        page.click_on('[role="treeitem"]', "Scene")
        page.press("End")
        wait_until(lambda: page.has('[role="treeitem"]', "n9999"), "the last row is seen")
        self.assertLess(page.evaluate(drawn), 60)
        page.click_on('input[aria-label="Search the scene"]')
        page.type("n5123")
        wait_until(lambda: page.evaluate(drawn) == 2, "what is searched for is found, and what it stands in")
        page.click_on('[role="treeitem"]', "n5123")
        self.until(page, lambda state: state["selection"]["entity"] == "nodes[5125]", "it is selected")
        self.write_at(page, 1, "# typed\n", end=False)
        self.assertTrue(page.script.startswith("# typed\nsettings"))
        self.until_final(page)


class Properties(PanelsTest):
    def test_a_number_is_written_as_it_is_typed(self):
        page = self.begin()
        self.properties(page, "sphere")
        page.click_at(*self.input_of(page, "sphere.radius"))
        page.press("Ctrl-A")
        page.type("0.50")
        self.has_text(page, SCENE.replace("1.25", "0.50"), "the literal is replaced")
        after = self.until_final(page)
        self.assertEqual(after["version"], after["picture"]["version"])
        page.press("Escape")
        self.has_text(page, SCENE, "Escape gives the value back that was there")

    def test_wrong_numbers_are_told_and_not_applied(self):
        page = self.begin()
        self.properties(page, "sphere")
        page.click_at(*self.input_of(page, "sphere.radius"))
        for wrong in ("nan", "inf", "1,5", "1;2", "x"):
            page.press("Ctrl-A")
            page.press("Delete")
            wait_until(lambda: self.invalid(page), "nothing is wrong")
            page.type(wrong)
            self.assertTrue(self.invalid(page), wrong)
            told = page.evaluate("document.getElementById(document.querySelector('[aria-invalid=\"true\"]')"
                                 ".getAttribute('aria-describedby')).textContent")
            self.assertIn("found", told)
            self.assertIn("expected", told)
            self.assertIn("sphere { radius: 1", page.script)
        page.press("Ctrl-A")
        page.type("2*(1+.5)")
        page.press("Enter")
        self.has_text(page, SCENE.replace("1.25", "3.0"), "arithmetic is worked out on Enter")
        self.assertFalse(self.invalid(page))

    def test_a_drag_is_one_step_of_undo(self):
        page = self.begin()
        self.properties(page, "sphere")
        x, y = self.input_of(page, "sphere.radius")
        page.drag((x, y), (x + 40, y))
        wait_until(lambda: self.value(page, "sphere.radius") == "1.75", "a pixel is one per cent")
        self.has_text(page, SCENE.replace("1.25", "1.75"), "the text follows")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Z")
        self.has_text(page, SCENE, "one step takes the drag back")

    def test_a_file_that_changes_on_the_disk_in_mid_drag_loses_neither(self):
        page = self.begin()
        self.properties(page, "sphere")
        x, y = self.input_of(page, "sphere.radius")
        theirs = SCENE + "# theirs\n"
        page.pointer("mouseMoved", x, y)
        page.pointer("mousePressed", x, y, "left", 1, clickCount=1)
        for step in range(1, 41):
            page.pointer("mouseMoved", x + step, y, "left", 1)
            if step == 20:
                wait_until(lambda: "1.25" not in page.script, "the text follows")
                self.scene(text=theirs)
                wait_until(lambda: page.has(".banner", "changed on the disk"), "it is told")
        page.pointer("mouseReleased", x + 40, y, "left", 0, clickCount=1)
        self.has_text(page, SCENE.replace("1.25", "1.75"), "the drag goes on to its end")
        self.assertEqual(theirs, self.saved())
        page.click_on(".banner button", "Load theirs")
        self.has_text(page, theirs, "theirs is loaded")

    def test_absent_fields_have_their_defaults_and_are_reset(self):
        page = self.begin()
        self.properties(page, "sphere")
        self.click_scrolled(page, self.field("flip_normals"))
        wait_until(lambda: "flip_normals: true" in page.script, "the field is inserted")
        self.click_scrolled(page, 'button[aria-label="Reset flip_normals to false"]')
        self.has_text(page, SCENE, "it is left out again")

    def test_the_text_of_a_macro_says_how_many_things_change(self):
        self.scene("scene.crt", SCRIPT)
        page = self.begin(file="scene.crt", scene=False)
        self.properties(page, "Sphere")
        wait_until(lambda: page.has(".times-made", "makes 4 things"), "two calls make it, one of them in three turns")
        self.properties(page, "Box")
        wait_until(lambda: page.has(".property-head", "Box"), "the box is shown")
        self.assertFalse(page.has(".times-made"), "it is there once")

    def test_references_jump(self):
        page = self.begin()
        self.properties(page, "sphere")
        self.click_scrolled(page, 'button[aria-label="Go to red"]')
        self.until(page, lambda each: each["selection"]["entity"] == "materials[0]", "the material is selected")


class Models(PanelsTest):
    def test_models_are_added_doubled_and_removed(self):
        self.scene("sphere.obj", SPHERE)
        page = self.begin()
        self.show(page, "Models")
        page.evaluate("""(() => { const select = document.querySelector('select[aria-label="Model to add"]');
            select.value = "sphere.obj"; select.dispatchEvent(new Event("change", { bubbles: true })); })()""")
        page.click_on(".panel-models button", "Add")
        page.click_on("dialog button", "Accept")
        wait_until(lambda: page.script.startswith(SCENE) and 'file: "sphere.obj"' in page.script, "it is placed")
        one = page.script
        page.click_on('.panel-models [role="option"]', "sphere.obj")
        page.press("Ctrl-D")
        wait_until(lambda: page.script.count("sphere.obj") == 2, "it is there twice")
        self.until(page, lambda each: each["selection"]["entity"] == "includes[1]", "the copy is selected")
        page.click_on('.panel-models [role="option"][aria-selected="true"]')
        page.press("Delete")
        self.has_text(page, one, "one is removed")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.click_on(".panel-models button:disabled", "Delete")
        self.assertEqual(one, page.script, "none is chosen, none is deleted")
        page.click_on('.panel-models [role="option"]', "sphere.obj")
        page.click_on(".panel-models button:enabled", "Delete")
        self.has_text(page, SCENE, "the button deletes the one that is chosen")
        self.until_final(page)

    def test_a_bare_model_becomes_a_scene_that_places_it(self):
        self.scene("sphere.obj", SPHERE)
        page = self.begin()
        self.show(page, "Models")
        page.evaluate("""(() => { const select = document.querySelector('select[aria-label="Model to add"]');
            select.value = "sphere.obj"; select.dispatchEvent(new Event("change", { bubbles: true })); })()""")
        page.click_on(".panel-models button", "New scene")
        self.until(page, lambda each: each["file"] == "untitled.tessera", "the new scene is open")
        self.assertIn('file: "sphere.obj"', page.script)
        self.until_final(page)
        self.assertEqual([], page.state["problems"])


class Settings(PanelsTest):
    def test_overrides_of_the_view_are_written_to_the_source(self):
        page = self.begin()
        page.click_on(".view-options summary")
        page.click_at(*self.input_of(page, "Samples"))
        page.type("9")
        self.until(page, lambda each: each["view"]["samples"] == 9, "the view has other samples")
        self.assertEqual(SCENE, page.script)
        self.click_scrolled(page, ".view-options button", "Write settings to source")
        self.has_text(page, SCENE.replace("samples_per_pixel: 4", "samples_per_pixel: 9"), "the literal is replaced")

    def test_the_view_has_a_size_of_its_own_until_it_goes_back(self):
        page = self.begin()
        page.click_on(".view-options summary")
        page.click_at(*self.input_of(page, "Width"))
        before = self.until_final(page)
        own = before["view"]["width"], before["view"]["height"]
        self.assertFalse(page.has(".view-bar .chip", "own settings"))
        page.type("300")
        page.click_at(*self.input_of(page, "Height"))
        page.type("200")
        self.until(page, lambda each: (each["view"]["width"], each["view"]["height"]) == (300, 200), "another size")
        self.until(page, lambda each: each["picture"]["final"] and each["picture"]["serial"] > before["picture"]["serial"],
                   "the last picture is shown")
        wait_until(lambda: page.pixels()[:2] == (300, 200), "it has that size")
        self.assert_same(self.rendered(size=(300, 200)), page.pixels()[2])
        _, _, left, top, width, height = page.box(".view-frame")
        self.assertAlmostEqual(1.5, width / height, delta=0.02)
        # A click is on the pixel that is seen there.
        page.click_at(left + width / 2, top + height / 2)
        self.until(page, lambda each: each["selection"]["entity"] == "nodes[0]", "the ball is in the middle")
        self.assertEqual(SCENE, page.script)
        self.assertTrue(page.has(".setting.own", "Width"))
        self.click_scrolled(page, '.view-options button[aria-label="height as the scene says"]')
        self.until(page, lambda each: each["view"]["height"] == 54, "the scene says the height")
        page.click_at(*self.input_of(page, "Height"))
        page.type("9000")
        page.click_at(*self.input_of(page, "Width"))
        page.type("3687")
        wait_until(lambda: self.invalid(page), "it is too large")
        self.assertIn("at most 3686 beside 9000", page.evaluate("document.querySelector('.view-options').textContent"))
        page.press("Ctrl-A")
        page.type("16385")
        wait_until(lambda: page.has(".view-options .why", "found 16385; expected a whole number from 1 to 16384"),
                   "no program makes a view of that width")
        page.click_on(".view-bar .chip", "own settings")
        self.until(page, lambda each: (each["view"]["width"], each["view"]["height"]) == own, "it is as the pane is")
        self.assertFalse(page.has(".setting.own"))
        self.assertFalse(page.has(".view-bar .chip", "own settings"))

    def test_size_and_output_of_the_view_are_written_to_the_source(self):
        page = self.begin()
        page.click_on(".view-options summary")
        page.click_at(*self.input_of(page, "Width"))
        page.type("120")
        page.evaluate("""(() => { const label = [...document.querySelectorAll(".view-options label")].find((each) =>
            each.querySelector("span").textContent === "Tone map"), select = label.querySelector("select");
            select.value = "filmic"; select.dispatchEvent(new Event("change", { bubbles: true })); })()""")
        wait_until(lambda: page.has(".setting.own", "Tone map"), "it is marked")
        self.assertEqual(SCENE, page.script)
        self.click_scrolled(page, ".view-options button", "Write settings to source")
        self.has_text(page, SCENE.replace("width: 96", "width: 120").replace(
            "samples_per_pixel: 4 } }", "samples_per_pixel: 4 } output { tone_map: FILMIC } }"), "both are written")


class Completion(PanelsTest):
    def test_words_of_the_language_are_proposed(self):
        page = self.begin()
        self.write_at(page, 1, " ")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Right", len("settings { "))
        page.press("Ctrl-Space")
        wait_until(lambda: page.has(".cm-tooltip-autocomplete li", "accelerator"), "a field that is not there yet")
        page.press("Escape")


class Rows(PanelsTest):
    def expected(self, page, field):
        return page.evaluate(f"""(() => {{
            const row = [...document.querySelectorAll(".property")].find((each) =>
              each.querySelector(".label").textContent === {json.dumps(field)});
            const words = row?.querySelector(".expected");
            return words && words.getBoundingClientRect().height > 0 ? words.textContent : null;
          }})()""")

    def test_a_row_tells_range_and_colour_where_there_is_width(self):
        page = self.begin()
        self.properties(page, "red")
        wait_until(lambda: self.expected(page, "classic.diffuse.value") == "#da5959 in sRGB", "the colour is told")
        self.assertEqual("0 to 0.3", self.expected(page, "classic.grain"))
        page.resize(900, 720)
        page.drag(page.middle('[role="separator"][aria-label="Width of the script"]'), (800, 300))
        wait_until(lambda: self.expected(page, "classic.grain") is None, "there is no width for it")

    def test_keys_of_the_view_are_commands(self):
        page = self.begin()
        page.press("F1")
        page.type("orbit to the left")
        wait_until(lambda: page.has(".commands .row kbd", "Left in the view"), "its key is listed")
        page.press("Enter")
        moved = self.until(page, lambda state: state["camera"]["mode"] == "free", "the camera is moved")["camera"]
        page.click_on(".view-frame")
        page.press("Home")
        self.until(page, lambda state: state["camera"]["mode"] == "scene", "it is the scene's again")
        page.press("Left")
        self.assertEqual(moved, self.until(page, lambda state: state["camera"]["mode"] == "free", "the key does the same")["camera"])


class Docking(PanelsTest):
    def zone(self, page, panel):
        return next((name for name, zone in page.state["layout"]["zones"].items() if panel in zone["tabs"]), None)

    def test_tabs_are_moved_by_keys(self):
        page = self.begin()
        self.assertEqual("bottom", self.zone(page, "Console"))
        self.show(page, "Console")
        page.press("Ctrl-Alt-Left")
        self.until(page, lambda state: "Console" in state["layout"]["zones"]["low"]["tabs"], "it is in the zone before")
        wait_until(lambda: page.focused() == "Console", "its tab keeps the focus")
        page.press("Ctrl-Alt-Right")
        self.until(page, lambda state: state["layout"]["zones"]["bottom"]["shown"] == "Console", "it is back")

    def test_a_tab_is_dropped_on_a_panel(self):
        page = self.begin()
        page.drag_text(page.middle('[role="tab"]', "Graphs"), page.middle(".panel-scene"))
        self.until(page, lambda state: state["layout"]["zones"]["low"]["shown"] == "Graphs", "it is where it was dropped")


class Texts(PanelsTest):
    def test_the_texts_of_page_and_disk_are_compared(self):
        page = self.begin()
        self.write_at(page, 1, " # mine")
        self.scene("scene.tessera", SCENE + "# theirs\n")
        page.click_on(".banner button", "Compare")
        wait_until(lambda: page.has('dialog[aria-label="Compare scene.tessera"]'), "they are compared")
        marked = page.evaluate("[...document.querySelectorAll('.compared-texts td.differs')].map((each) => each.textContent)")
        first = SCENE.split("\n")[0]
        self.assertEqual([f"−{first}", f"+{first} # mine", "−# theirs"], marked)
        page.click_on("dialog button", "Load theirs")
        wait_until(lambda: page.script == SCENE + "# theirs\n", "theirs is loaded")
        self.assertFalse(page.has("dialog"))

    def test_no_picture_is_shown_without_a_scene(self):
        page = self.begin()
        self.assertTrue(page.evaluate("getComputedStyle(document.querySelector('.view-frame')).visibility === 'visible'"))
        page.click_on(".cm-scroller")
        page.press("Alt-W")
        self.until(page, lambda state: state["file"] is None, "no file is open")
        wait_until(lambda: page.has("#view-words", "open or drop a scene"), "the view says so")
        self.assertEqual("hidden", page.evaluate("getComputedStyle(document.querySelector('.view-frame')).visibility"))
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        self.until_final(page)
        wait_until(lambda: page.evaluate("getComputedStyle(document.querySelector('.view-frame')).visibility") == "visible",
                   "the picture is shown again")


class NextStart(PanelsTest):
    def test_workers_of_the_next_start(self):
        page = self.begin()
        page.press("Ctrl-,")
        for label, text in (("Workers", "3"), ("Their nice level", "5")):
            page.click_at(*self.input_of(page, label))
            page.type(text)
        page.press("Tab")
        page.press("Escape")
        kept = self.folder / "config/tessera/studio.json"
        wait_until(lambda: kept.exists() and '"nice":5' in kept.read_text().replace(" ", ""), "they are kept")
        self.assertEqual(0, self.end_studio(self.running))
        own = os.getpriority(os.PRIO_PROCESS, 0)
        self.running = self.studio()
        workers = wait_until(lambda: (found := [each for each in marked_processes(self.mark) if is_worker(each)]) and
                             len(found) == 3 and found, "three workers are there")
        wait_until(lambda: {os.getpriority(os.PRIO_PROCESS, each) for each in workers} == {own + 5}, "they are nice")
        page = self.visit(None)
        page.press("Ctrl-,")
        page.click_at(*self.input_of(page, "Workers"))
        page.press("Ctrl-A")
        page.press("Delete")
        wait_until(lambda: '"workers"' not in kept.read_text(), "a number that was cleared is kept no more")


if __name__ == "__main__":
    unittest.main()
