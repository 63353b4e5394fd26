#!/usr/bin/env python3
"""Full pictures, workers, graphs, the log and animations in the studio's page."""
import os
import pathlib
import re
import shlex
import signal
import unittest

import scenes
from png import read_png
from studio_browser import StudioPageTest
from studio_case import SCENE
from tessera_process import PATIENCE, PROGRAM, is_worker, marked_processes, wait_until

AXE = pathlib.Path(PROGRAM).parents[1] / "studio/page/work/node_modules/axe-core/axe.min.js"


class FarmPageTest(StudioPageTest):
    def show(self, page, panel):
        page.click_on('[role="tab"]', panel)

    def text_of(self, page, selector):
        return page.evaluate(f"[...document.querySelectorAll({selector!r})].map((each) => each.textContent).join('\\n')")

    def has_words(self, page, selector, pattern, what):
        return wait_until(lambda: re.search(pattern, self.text_of(page, selector)), what)

    def rendered_there(self, page):
        """A full picture, by its keys, which is done."""
        page.press("Ctrl-Enter")
        self.show(page, "Farm")
        self.has_words(page, 'table[aria-label="Full pictures"]', "done", "the full picture is done")

    def check_axe(self, page, where):
        page.evaluate(AXE.read_text() + ";0")
        found = page.evaluate("axe.run(document, {resultTypes: ['violations']}).then((found) => found.violations"
                              ".map((each) => `${each.id}: ${each.nodes[0].html.slice(0, 200)}`))")
        self.assertEqual([], found, where)

    def test_a_full_picture_is_looked_at(self):
        page = self.begin()
        self.rendered_there(page)
        page.click_on("td.orders button", "Look")
        self.has_words(page, "dialog [role=status]", "96 × 54", "the picture is there")
        shown = page.evaluate("""(() => { const film = document.querySelector("dialog canvas");
            const bytes = film.getContext("2d").getImageData(0, 0, film.width, film.height).data;
            return [film.width, film.height, [...bytes].filter((each, at) => at % 4 < 3)]; })()""")
        self.assertEqual([96, 54], shown[:2])
        self.assert_same(bytes(shown[2]), self.rendered())
        self.check_axe(page, "the picture")
        page.press("Escape")
        wait_until(lambda: not page.has("dialog"), "it is closed")

    def test_the_command_that_adds_a_worker(self):
        page = self.begin()
        self.show(page, "Farm")
        page.click_on(".add-worker summary")
        command = self.text_of(page, ".add-worker code")
        self.check_axe(page, "the farm")
        worker = self.start(*shlex.split(command)[1:])
        wait_until(lambda: page.evaluate("document.querySelectorAll('table[aria-label=Workers] tbody tr').length") == 2,
                   "the worker is in the table")
        self.end_studio(self.running)
        worker.communicate(timeout=PATIENCE)

    def test_graphs_tell_values(self):
        page = self.begin()
        self.show(page, "Graphs")
        wait_until(lambda: page.has(".timeline svg"), "the workers' rows are there")
        self.assertIn("in use", page.evaluate("document.querySelector('.timeline svg').getAttribute('aria-label')"))
        x, y = page.middle(".graph", "CPU of the machine")
        page.pointer("mouseMoved", x, y)
        page.pointer("mouseMoved", x + 2, y)
        self.has_words(page, ".graph output", r"%, \d+ s ago", "the value under the pointer")
        # Who reads the table by ear has it without asking for it.
        for words in ("Rays a second", "Use of ", "up to "):
            self.has_words(page, ".graphs-table table", words, f"the table has {words}")
        self.assertFalse(page.has(".graphs-table > :not(.visually-hidden) > table"))
        self.check_axe(page, "the graphs without their table")
        x, y = page.middle(".timeline svg")
        page.pointer("mouseMoved", x, y)
        page.pointer("mouseMoved", x + 2, y)
        self.has_words(page, ".timeline output", r"\d %, \d+ s ago", "the use of a worker under the pointer")
        page.click_on(".graphs-table button", "As a table")
        wait_until(lambda: page.has(".graphs-table > :not(.visually-hidden) > table"), "the table is seen")
        self.check_axe(page, "the graphs")

    def test_the_log_leads_to_the_line(self):
        self.scene("wrong.tessera", "cameras { }\nnodes { shape { sphere { radius: x } } }\n")
        page = self.begin()
        page.click_on('.panel-files [role="option"]', "wrong.tessera")
        self.until(page, lambda state: state["file"] == "wrong.tessera", "it is open")
        page.press("Ctrl-Enter")
        self.show(page, "Console")
        page.click_on(".log button", "wrong.tessera:2")
        self.until(page, lambda state: state["selection"]["line"] == 2, "the cursor is there")

    def test_the_log_tells_how_long_scenes_took_to_be_read(self):
        page = self.begin()
        self.show(page, "Console")
        reads = r"'scene\.tessera': read (in|\d+ times, each in) \d+\.\d"
        self.has_words(page, ".log", reads, "it was read")
        before = len(re.findall(reads, self.text_of(page, ".log")))
        self.write_at(page, 1, " # one comment")
        wait_until(lambda: len(re.findall(reads, self.text_of(page, ".log"))) > before, "and once more")

    def test_a_worker_that_is_lost_is_not_counted(self):
        page = self.begin("--workers", "2")
        self.show(page, "Farm")
        seen = """(() => [[...document.querySelectorAll('table[aria-label="Workers"] tbody tr')].map((each) =>
            each.cells[1].textContent), document.querySelector(".status-bar").textContent.match(/(\\d+) worker/)[1]])()"""
        wait_until(lambda: page.evaluate(seen) == [["active", "active"], "2"], "both are there")
        os.kill([each for each in marked_processes(self.mark) if is_worker(each)][0], signal.SIGKILL)
        states, count = wait_until(lambda: (found := page.evaluate(seen)) and "lost" in found[0] and found,
                                   "one is lost")
        self.assertEqual(str(len(states) - states.count("lost")), count)

    def test_an_animation_has_the_scenes_frames(self):
        self.scene("moving.tessera", scenes.MOVING.replace("frames { per_second: 10 }",
                                                           "frames { first: 1 last: 3 per_second: 10 }") +
                   'includes { file: "part.tessera" }')
        part = "nodes { shape { sphere { radius: .2 } } }"
        self.scene("part.tessera", part)
        page = self.begin(file="moving.tessera")
        self.show(page, "Animation")
        values = wait_until(lambda: (found := page.evaluate(
            "[...document.querySelectorAll('.animation .fields input')].map((each) => each.value)")) == ["1", "3", "10"]
            and found, "first, last and rate are the scene's")
        self.assertTrue(values)
        page.click_on(".animation button", "Make frames")
        wait_until(lambda: page.evaluate("document.querySelector('.frames').getAttribute('aria-label')") ==
                   "3 of 3 frames are there", "the frames are made")
        # A comment changes none of them, so that nothing is traced.
        other = self.page(self.running)

        def tiles():
            other.forget()
            return [sum(each["tiles"] for each in other.receive("workers")["list"]) for _ in range(2)][1]
        before = tiles()
        self.write_at(page, 1, " # moves")
        self.until(page, lambda state: state["picture"]["version"] == state["version"], "the text was read")
        wait_until(lambda: page.evaluate("document.querySelector('.frames').getAttribute('aria-label')") ==
                   "3 of 3 frames are there", "the frames are still right")
        self.assertEqual(before, tiles())
        # It plays on where another panel covers its own.
        page.click_on(".animation button", "Play")
        self.show(page, "Farm")
        self.assertFalse(page.has(".animation"))
        seen = set()
        shown = "[...document.querySelectorAll('canvas.playback')].map((each) => each.toDataURL()).join()"
        wait_until(lambda: seen.add(page.evaluate(shown)) or len(seen - {""}) == 3, "all three frames are seen")
        # What is typed elsewhere into a file that the scene includes changes them.
        self.open(other, "part.tessera")
        at = part.index(".2")
        self.edit(other, 1, (at, at + 2, ".7"), file="part.tessera")
        anew = set()
        wait_until(lambda: anew.add(page.evaluate(shown)) or len(anew - seen - {""}) >= 3, "the frames are made anew")

    def test_an_animation_without_motion_is_asked_about(self):
        page = self.begin()
        self.show(page, "Animation")
        self.set_field(page, "Last frame", "2")
        page.click_on(".animation button", "Render the frames")
        self.has_words(page, "dialog p", "Nothing in scene.tessera depends on the frame", "it is asked first")
        page.press("Escape")
        self.assertEqual([], self.pictures())
        page.click_on(".animation button", "Render the frames")
        page.click_on("dialog button", "Render all")
        wait_until(lambda: len(self.pictures()) == 3, "they are rendered where that is wanted")
        # Files that exist are asked about, too.
        self.until_done(page, 1)
        self.show(page, "Animation")
        page.click_on(".animation button", "Render the frames")
        page.click_on("dialog button", "Render all")
        self.has_words(page, "dialog p", "3 of the files exist, frame.0000.png first: replace them", "it is asked")

    def pictures(self):
        return sorted(each.name for each in self.opened.glob("*.png"))

    def set_field(self, page, label, text):
        """By keys, in the field with that label."""
        page.evaluate(f"""[...(document.querySelector("dialog") ?? document).querySelectorAll("label.field")].find((each) =>
            each.querySelector("span").textContent === {label!r}).querySelector("input").focus()""")
        page.press("Ctrl-A")
        page.type(text)

    def until_done(self, page, count):
        """Until so many full pictures are done."""
        self.show(page, "Farm")
        wait_until(lambda: len(re.findall("done", self.text_of(page, 'table[aria-label="Full pictures"]'))) == count,
                   f"{count} full pictures are done")

    def test_render_becomes_stop(self):
        self.scene(text=SCENE.replace("samples_per_pixel: 4", "samples_per_pixel: 65536"))
        self.running = self.studio("--workers", 1)
        page = self.visit(None)
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        self.until(page, lambda state: state["picture"]["samples"] > 0, "it is traced")
        page.click_on(".toolbar button", "Render")
        wait_until(lambda: page.has(".toolbar button", "Stop"), "it is Stop while it renders")
        self.assertFalse(page.has(".toolbar button", "Render"))
        page.click_on(".toolbar button", "Stop")
        self.show(page, "Farm")
        self.has_words(page, 'table[aria-label="Full pictures"]', "cancelled", "the full picture is cancelled")
        wait_until(lambda: page.has(".toolbar button", "Render"), "it is Render again")

    def open_dialog(self, page, command, title):
        page.press("F1")
        page.type(command)
        page.press("Enter")
        wait_until(lambda: page.has(f'dialog[aria-label="{title}"]'), f"{title} is open")

    def type_name(self, page, name):
        """Over the stem of the name that the form proposes."""
        selection = ("(({ tagName, selectionStart, selectionEnd }) => tagName === 'INPUT' && selectionStart === 0"
                     " && selectionEnd > 0)(document.activeElement)")
        wait_until(lambda: page.evaluate(selection), "the stem is selected")
        page.type(name)

    def notices(self, page):
        return self.text_of(page, ".notice span")

    def test_a_render_over_a_file_asks_once_and_keeps_the_form(self):
        page = self.begin()
        (self.opened / "scene.png").write_bytes(b"before")
        self.open_dialog(page, "with options", "Full picture")
        self.set_field(page, "Width", "20")
        self.set_field(page, "Height", "10")
        page.press("Enter")
        self.has_words(page, 'dialog[aria-label="Replace files"] p', r"^scene\.png exists: replace it\?$", "it is asked")
        page.press("Escape")
        self.assertEqual(["20", "10"], page.evaluate("[...document.querySelectorAll('dialog .number input')].slice(0, 2).map((each) => each.value)"))
        self.assertEqual("", self.notices(page))
        self.assertEqual(b"before", (self.opened / "scene.png").read_bytes())
        page.click_on('dialog[aria-label="Full picture"] button', "Render")
        page.click_on('dialog[aria-label="Replace files"] button', "Replace")
        wait_until(lambda: not page.has("dialog"), "the form is closed")
        self.has_words(page, ".notice span", r"^The full picture of scene\.tessera is ordered\.$", "it is said")
        self.until_done(page, 1)
        self.assertEqual((20, 10), read_png(self.opened / "scene.png")[:2])

    def test_a_refused_order_keeps_the_form_and_says_why(self):
        page = self.begin()
        self.open_dialog(page, "Export", "Export")
        self.type_name(page, "none/out")
        page.press("Enter")
        self.has_words(page, "dialog [role=alert]", "'none/out.png' cannot be written: its folder is not there", "it says why")
        self.assertTrue(page.has('dialog[aria-label="Export"]'))
        self.assertEqual("", self.notices(page))

    def test_a_form_says_which_of_its_fields_is_wrong_and_can_be_sent_again(self):
        page = self.begin()
        # A field of the page behind the form has no part in it.
        page.click_on(".view-options summary")
        self.set_field(page, "Samples", "none")
        self.open_dialog(page, "with options", "Full picture")
        self.set_field(page, "Width", "0")
        page.click_on("dialog button.primary")
        self.has_words(page, "dialog [role=alert]", "^Width: found 0; expected a whole number", "it says what is wrong")
        self.set_field(page, "Width", "20")
        page.press("Enter")
        self.has_words(page, "dialog [role=alert]", "^Height: found nothing; expected width and height", "half a size is none")
        self.set_field(page, "Height", "10")
        page.press("Enter")
        self.until_done(page, 1)
        self.assertEqual((20, 10), read_png(self.opened / "scene.png")[:2])

    def test_an_export_has_its_own_size_samples_and_values(self):
        page = self.begin()
        self.open_dialog(page, "Export", "Export")
        self.type_name(page, "own.exr")
        page.press("Delete", 4)
        page.evaluate("document.querySelector('dialog select').focus()")
        page.type("made")
        for label, text in (("Width", "24"), ("Height", "16"), ("Samples", "2")):
            self.set_field(page, label, text)
        page.click_on("dialog label", "depth")
        page.click_on("dialog button.primary")
        wait_until(lambda: not page.has("dialog"), "it is ordered")
        self.until_done(page, 1)
        result = self.run_program("render", self.opened / "scene.tessera", "-o", self.folder / "own.exr", "--size", "24x16",
                                  "--spp", "2", "--aovs", "depth", "--quiet")
        self.assertEqual(0, result.code, result.err)
        self.assertEqual((self.folder / "own.exr").read_bytes(), (self.opened / "own.exr").read_bytes())

    def test_a_moved_camera_has_no_command_until_it_is_written(self):
        page = self.begin()
        page.click_on(".view-frame")
        page.press("Left")
        self.until(page, lambda state: state["camera"]["mode"] == "free", "it is moved")
        self.open_dialog(page, "with options", "Full picture")
        page.click_on("dialog button", "Copy command line")
        self.has_words(page, 'dialog[aria-label="No command line"] p', "a camera that was moved", "it says why")
        page.click_on('dialog[aria-label="No command line"] button', "Write camera")
        self.until(page, lambda state: state["camera"]["mode"] == "scene", "it is written, and seen through")
        wait_until(lambda: not page.has('dialog[aria-label="No command line"]'), "the question is closed")
        page.click_on("dialog button", "Copy command line")
        self.has_words(page, ".notice span", r"In the clipboard: tessera render \S+/scene\.tessera ", "there is a command line")


if __name__ == "__main__":
    unittest.main()
