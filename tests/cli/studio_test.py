#!/usr/bin/env python3
"""The page of `tessera studio` in a real browser: keys and pointer go in, and what the page tells of itself is held
against what the program and the disk have."""
import os
import signal
import unittest

from studio_browser import StudioPageTest
from studio_case import SAMPLES, SCENE
from tessera_process import is_worker, marked_processes, wait_until

LINES = SCENE.count("\n")
# The editor closes what is opened, so that the last key is the one that makes another scene.
ANOTHER = " nodes{shape{sphere{center{x:2"


class Files(StudioPageTest):
    def test_a_file_is_opened_edited_and_saved(self):
        page = self.begin()
        self.assertEqual(SCENE, page.script)
        self.assertEqual("tessera", page.state["language"])
        self.write_at(page, 1, " # one")
        self.assertTrue(page.state["dirty"])
        self.assertTrue(page.has('[aria-label="unsaved"]'))
        self.assertEqual(SCENE, self.saved(), "nothing is saved by itself")
        page.press("Ctrl-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        self.assertEqual(SCENE.replace("\n", " # one\n", 1), self.saved())
        self.assertFalse(page.has('[aria-label="unsaved"]'))

    def test_line_ends_and_mark_outlast_an_edit(self):
        text = "\ufeff" + SCENE.replace("\n", "\r\n").rstrip()
        self.scene("scene.tessera", text)
        page = self.begin(scene=False)
        self.write_at(page, 1, " # ä😀")
        page.press("Alt-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        self.assertEqual(text.replace("\r\n", " # ä😀\r\n", 1).encode(),
                         (self.opened / "scene.tessera").read_bytes())

    def test_saving_under_another_name(self):
        page = self.begin()
        page.press("Ctrl-Shift-S")
        page.press("Ctrl-A")
        page.type("other.tessera")
        page.press("Enter")
        self.until(page, lambda state: state["file"] == "other.tessera", "the copy is open")
        self.assertEqual(SCENE, self.saved("other.tessera"))

    def test_several_files_and_closing_one_that_is_not_saved(self):
        self.scene("other.tessera", SCENE.replace("1.25", ".5"))
        page = self.begin()
        page.click_on('.panel-files [role="option"]', "other.tessera")
        self.until(page, lambda state: state["file"] == "other.tessera", "the other file is shown")
        page.press("Alt-PageUp")
        self.assertEqual("scene.tessera", page.state["file"])
        self.write_at(page, 1, "#")
        page.press("Alt-W")
        wait_until(lambda: page.has("dialog", "not saved"), "it is asked about")
        page.press("Escape")
        self.assertEqual("scene.tessera", page.state["file"])
        page.press("Alt-W")
        page.click_on("dialog button", "Discard")
        self.until(page, lambda state: state["file"] == "other.tessera", "it is closed")
        self.assertEqual(SCENE, self.saved())
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        self.until(page, lambda state: state["file"] == "scene.tessera", "it is open again")
        self.assertEqual(SCENE, page.script, "what was discarded is gone")

    def test_the_start_page_lists_scenes(self):
        self.scene("sub.tessera")
        page = self.begin(file=None)
        page.click_on(".start button", "sub.tessera")
        self.until(page, lambda state: state["file"] == "sub.tessera", "it is open")

    def test_what_cannot_be_edited_says_so_and_is_placed_in_a_scene(self):
        self.scene("large.tessera", SCENE + "# a line of a file that is too long to be edited\n" * 180_000)
        self.scene("latin.tessera", b"# caf\xe9\n" + SCENE.encode())
        self.scene("wide.tessera", SCENE.encode("utf-16"))
        page = self.begin(file=None)
        for name, encoding, why in (("wide.tessera", "UTF-16", "only UTF-8 can be edited"), ("latin.tessera", "not UTF-8", "byte 0xe9"),
                                    ("large.tessera", "UTF-8", "more than 8 MiB: its beginning is shown")):
            page.click_on('.panel-files [role="option"]', name)
            self.until(page, lambda state: state["file"] == name, f"{name} is open")
            wait_until(lambda: page.has(".banner", why), f"it is said why {name} is not edited")
            self.assertTrue(page.state["readOnly"])
            self.assertIn(encoding, page.evaluate("[...document.querySelectorAll('.status-bar span')].map((each) => each.textContent)"))
        page.click_on(".banner button", "Place it in a new scene")
        self.until(page, lambda state: state["file"] == "untitled.tessera", "a scene is open")
        self.assertIn('file: "large.tessera"', page.script)
        self.until_final(page)
        self.assertFalse(page.state["readOnly"])

    def test_a_viewer_cannot_edit(self):
        page = self.begin("--workers", 1, "--read-only")
        self.assertTrue(page.state["readOnly"])
        self.write_at(page, 1, "x")
        self.assertEqual(SCENE, page.script)


class Typing(StudioPageTest):
    def test_undo_and_redo_outlast_saving(self):
        page = self.begin()
        self.write_at(page, 1, " # one")
        page.press("Ctrl-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        page.press("Ctrl-Z", 6)
        self.assertEqual(SCENE, page.script)
        page.press("Ctrl-Y", 6)
        self.assertEqual(SCENE.replace("\n", " # one\n", 1), page.script)
        page.press("Ctrl-Z", 6)
        page.press("Ctrl-Shift-Z", 6)
        self.assertEqual(SCENE.replace("\n", " # one\n", 1), page.script)

    def test_find_replace_and_go_to_line(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Ctrl-F")
        page.type("radius")
        page.press("Enter")
        selected = page.state["selection"]
        self.assertEqual((5, len("radius")), (selected["line"], selected["endColumn"] - selected["column"]))
        page.press("Escape")
        page.press("Alt-G")
        page.type("3")
        page.press("Enter")
        self.assertEqual(3, page.state["selection"]["line"])
        page.press("Escape")
        self.assertEqual(SCENE, page.script)

    def test_replacing_by_keys(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Ctrl-H")
        page.type("name")
        found = []
        for key in ("F3", "F3", "F3", "Shift-F3"):
            page.press(key)
            found.append(page.state["selection"]["line"])
        self.assertEqual([2, 4, 5, 4], found)
        page.evaluate("document.querySelector('.cm-search [name=replace]').focus()")
        page.type("other")
        page.click_on(".cm-search button", "replace all")
        self.assertEqual(SCENE.replace("name", "other"), page.script)
        page.press("Escape")
        wait_until(lambda: not page.has(".cm-search"), "the search is closed")

    def test_many_cursors(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Ctrl-Alt-Down", 2)
        page.type("#")
        first, second, third, rest = SCENE.split("\n", 3)
        self.assertEqual(f"#{first}\n#{second}\n#{third}\n{rest}", page.script)
        page.press("Ctrl-Z")
        self.assertEqual(SCENE, page.script)
        # The words that are the same as the selected one get cursors, too.
        page.press("Escape")
        self.write_at(page, 4, "", end=False)
        page.press("Right", SCENE.split("\n")[3].index('red"') + 1)
        page.press("Ctrl-D", 2)
        page.type("blue")
        self.assertEqual(SCENE.replace("red", "blue"), page.script)
        self.until_final(page)

    def test_text_that_is_composed_comes_once(self):
        page = self.begin()
        self.write_at(page, 1, " # ")
        before = page.script
        for part in ("に", "にh", "にほ", "にほん"):
            page.call("Input.imeSetComposition", text=part, selectionStart=len(part), selectionEnd=len(part))
            page.wait_for_frames()
        self.assertEqual(before.replace(" # ", " # にほん"), page.script)
        page.call("Input.insertText", text="日本")
        composed = before.replace(" # ", " # 日本")
        self.assertEqual(composed, page.script)
        # A key that ends another composition is the input method's, and no command's.
        page.call("Input.imeSetComposition", text="ä", selectionStart=1, selectionEnd=1)
        page.call("Input.imeSetComposition", text="", selectionStart=0, selectionEnd=0)
        self.assertEqual(composed, page.script)
        page.press("Ctrl-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        self.assertEqual(composed, self.saved())

    def test_the_ruler_stands_at_column_120(self):
        self.scene(text=SCENE + "# " + "x" * 130)
        page = self.begin(scene=False)
        page.press("F1")
        page.type("Layout: CRT")  # whose script is wide
        page.press("Enter")
        self.until(page, lambda state: state["layout"]["preset"] == "CRT", "the script is wide")
        self.write_at(page, SCENE.count("\n") + 1, "", end=False)
        page.press("Right", 120)

        def lefts():
            page.wait_for_frames()
            return page.evaluate("['.ruler', '.cm-cursor-primary'].map((each) => document.querySelector(each).getBoundingClientRect().left)")
        wait_until(lambda: (found := lefts()) and abs(found[0] - found[1]) < 2, "the ruler is behind 120 columns")

    def test_occurrences_of_the_selected_word_are_framed_and_marked_beside_the_scroll_bar(self):
        page = self.begin()
        self.write_at(page, 4, "", end=False)
        page.press("Right", SCENE.split("\n")[3].index('red"') + 1)
        self.assertEqual(0, page.evaluate("document.querySelectorAll('.overview .occurrence').length"))
        page.press("Ctrl-D")
        framed = "[...document.querySelectorAll('.cm-selectionMatch')].map((each) => [each.textContent, getComputedStyle(each).outlineStyle])"
        wait_until(lambda: page.evaluate(framed) == [["red", "solid"]], "the other one is framed")
        tops = "[...document.querySelectorAll('.overview .occurrence')].map((each) => Math.round(parseFloat(each.style.top)))"
        lines = SCENE.count("\n") + 1
        wait_until(lambda: page.evaluate(tops) == [round((line - .5) / lines * 100) for line in (4, 5)], "both have marks at their height")
        page.press("Right")
        wait_until(lambda: page.evaluate(tops) == [], "nothing is selected any more")

    def test_lines_are_indented_as_they_are_typed(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        page.press("Ctrl-End")
        page.type("nodes {\nname: ")
        self.assertTrue(page.script.startswith(SCENE + "nodes {\n"), page.script[len(SCENE):])
        last = page.script.split("\n")[LINES + 1]
        self.assertTrue(last.startswith("  "), repr(last))
        self.assertEqual(last.strip(), "name:")

    def test_line_numbers_and_the_line_of_the_cursor(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        page.press("Ctrl-End")
        self.assertTrue(page.has(".cm-gutterElement", str(LINES)))
        self.assertTrue(page.has(".cm-activeLine"))
        self.assertTrue(page.has(".status-bar", f"Line {LINES + 1}, column 1"))


class Errors(StudioPageTest):
    def test_an_error_is_marked_listed_and_mended_by_a_key(self):
        page = self.begin()
        before = page.box(".cm-line", "name: \"sun\"")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Down", 4)
        page.press("End")
        page.press("Left", len(": 1.25 } } }"))
        page.type("s")
        self.assertIn("radiuss", page.script)
        state = self.until(page, lambda state: state["problems"], "the problem is told")
        problem, = state["problems"]
        column = SCENE.split("\n")[4].index("radius") + 1
        self.assertEqual(("error", "scene.tessera", 5, column, "radius"),
                         tuple(map(problem.get, ("severity", "file", "line", "column", "suggestion"))))
        wait_until(lambda: page.has(".cm-lintRange-error") and page.has('.panel-problems [role="option"]'),
                   "it is underlined and listed")
        after = page.box(".cm-line", "name: \"sun\"")
        self.assertEqual((before[3], before[5]), (after[3], after[5]), "no line moves")
        self.assertTrue(page.state["picture"]["stale"])
        page.press("Ctrl-.")
        self.until(page, lambda state: not state["problems"], "it is mended")
        self.assertEqual(SCENE, page.script)
        self.until(page, lambda state: not state["picture"]["stale"], "the picture is up to date")

    def follow_problem_to_part(self):
        """A scene whose problem is in a part of it, and a click on that problem; the page."""
        (self.opened / "part.tessera").write_text("# part\nnodes { shape { sphere { radius: x } } }\n")
        self.scene("scene.tessera", 'includes { file: "part.tessera" }\n')
        page = self.begin(file=None, scene=False)
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        self.until(page, lambda state: state["problems"], "the problem is told")
        page.click_on('.panel-problems [role="option"]', "part.tessera")
        return page

    def test_a_problem_leads_to_its_place(self):
        page = self.follow_problem_to_part()
        state = self.until(page, lambda state: state["file"] == "part.tessera", "its file is open")
        self.until(page, lambda state: state["selection"]["line"] == 2, "the cursor is at the place")

    def test_no_problem_is_shown_at_a_place_of_an_older_text(self):
        page = self.follow_problem_to_part()
        self.until(page, lambda state: state["file"] == "part.tessera", "its file is open")
        page.press("Ctrl-Home")
        self.running.process.send_signal(signal.SIGSTOP)
        try:
            page.press("Enter")
            # Longer than problems wait for the next key.
            page.evaluate("new Promise((done) => setTimeout(done, 600))")
            self.assertEqual([], page.state["problems"])
        finally:
            self.running.process.send_signal(signal.SIGCONT)
        self.until(page, lambda state: [each["line"] for each in state["problems"]] == [3], "it is told of the text as it is")


class Live(StudioPageTest):
    def test_the_picture_follows_the_text(self):
        page = self.begin()
        before = page.pixels()
        self.write_at(page, 5, ANOTHER)
        state = self.until_final(page)
        self.assertEqual(state["version"], state["picture"]["version"])
        self.assertFalse(before == page.pixels())

    def test_comments_and_blanks_start_nothing(self):
        page = self.begin()
        before = page.state["picture"]["serial"]
        self.write_at(page, 5, "  # a comment")
        page.press("Ctrl-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        self.assertEqual(before, page.state["picture"]["serial"])

    def test_wrong_text_keeps_the_last_good_picture(self):
        page = self.begin()
        before = page.pixels()
        self.write_at(page, 5, " wrong")
        self.until(page, lambda state: state["picture"]["stale"], "it is told to be old")
        wait_until(lambda: page.has("#view-words", "as of "), "the view says so")
        self.assert_same(before, page.pixels())
        page.press("Backspace", len("wrong"))
        self.until(page, lambda state: not state["picture"]["stale"], "it is right again")
        self.assert_same(before, page.pixels())

    def test_pause_resume_and_stop_by_keys(self):
        page = self.begin()
        page.click_on(".view-frame")
        page.press("Space")
        wait_until(lambda: page.has("#view-words", "paused"), "it is paused")
        page.press("Space")
        wait_until(lambda: not page.has("#view-words", "paused"), "it goes on")
        self.until_final(page)

    def test_the_title_tells_how_far_the_picture_has_come(self):
        self.scene(text=SCENE.replace("samples_per_pixel: 4", "samples_per_pixel: 65536"))
        self.running = self.studio("--workers", 1)
        page = self.visit(None)
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        title = wait_until(lambda: (told := page.evaluate("document.title"))[:1].isdigit() and told, "it is told")
        self.assertRegex(title, r"^\d+ % – scene\.tessera – Tessera Studio$")
        self.write_at(page, 1, "", end=False)
        page.press("Right", SCENE.index("4 } }"))
        page.press("Delete", 5)
        page.type("1")
        self.until_final(page)
        wait_until(lambda: page.evaluate("document.title") == "• scene.tessera – Tessera Studio", "the picture is done")

    def test_rendering_on_save_and_by_hand(self):
        page = self.begin()
        for mode, order in (("on save", "Ctrl-S"), ("by hand", "Alt-P")):
            before = self.until_final(page)
            self.command(page, f"Render: {mode}")
            counted = page.text(".summary")
            self.write_at(page, 5, ANOTHER)
            wait_until(lambda: page.text(".summary") != counted, "what was typed is read")
            self.assertEqual(before["picture"]["serial"], page.state["picture"]["serial"])
            page.press(order)
            self.until_final(page, after=before)

    def command(self, page, name):
        page.press("F1")
        wait_until(lambda: page.has("dialog"), "the commands are listed")
        page.type(name)
        page.press("Enter")
        wait_until(lambda: not page.has("dialog"), "the command is run")


class SamePixels(StudioPageTest):
    def test_the_picture_is_that_of_render(self):
        page = self.begin()
        self.write_at(page, 5, ANOTHER)
        state = self.until_final(page)
        page.press("Ctrl-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        width, height, shown = page.pixels()
        self.assertEqual((width, height), (state["view"]["width"], state["view"]["height"]))
        self.assert_same(self.rendered(size=(width, height)), shown)


class Camera(StudioPageTest):
    def setUp(self):
        super().setUp()
        self.browser_page = self.begin()
        self.view = self.browser_page.middle(".view-frame")

    def moved(self, what, act):
        """The camera after that was done."""
        page = self.browser_page
        before = page.state["camera"]
        act()
        self.until(page, lambda state: state["camera"] != before, f"{what} moves the camera")
        page.wait_for_frames()
        return page.state["camera"]

    def test_the_mouse_orbits_pans_looks_and_dollies(self):
        page, (x, y) = self.browser_page, self.view
        self.assertEqual("scene", page.state["camera"]["mode"])
        first = page.state["camera"]
        orbited = self.moved("dragging", lambda: page.drag((x, y), (x + 60, y + 10)))
        self.assertEqual("free", orbited["mode"])
        self.assertEqual(first["target"], orbited["target"])
        self.assertAlmostEqual(self.distance(first), self.distance(orbited), 6)
        panned = self.moved("Shift", lambda: page.drag((x, y), (x + 40, y), held=("Shift",)))
        self.assertNotEqual(orbited["target"], panned["target"])
        looked = self.moved("right", lambda: page.drag((x, y), (x + 40, y), button="right"))
        self.assertEqual(panned["eye"], looked["eye"])
        nearer = self.moved("the wheel", lambda: page.wheel(x, y, -1))
        self.assertLess(self.distance(nearer), self.distance(looked))
        narrower = self.moved("Ctrl and the wheel", lambda: page.wheel(x, y, -1, held=("Ctrl",)))
        self.assertLess(narrower["fov"], nearer["fov"])
        self.assertEqual(narrower["eye"], nearer["eye"])
        self.until_final(page)

    def test_a_worker_that_is_killed_in_an_orbit_costs_nothing(self):
        page, (x, y) = self.browser_page, self.view
        before = page.state["camera"]
        workers = [each for each in marked_processes(self.mark) if is_worker(each)]
        page.pointer("mouseMoved", x, y)
        page.pointer("mousePressed", x, y, "left", 1, clickCount=1)
        for step in range(1, 61):
            page.pointer("mouseMoved", x + step, y, "left", 1)
            if step == 30:
                os.kill(workers[0], signal.SIGKILL)
            page.wait_for_frames()
        page.pointer("mouseReleased", x + 60, y, "left", 0, clickCount=1)
        after = self.until_final(page)
        self.assertNotEqual(before["eye"], after["camera"]["eye"])
        self.assertNotIn(workers[0], marked_processes(self.mark))
        page.press("F1")
        page.type("Write camera")
        page.press("Enter")
        self.until(page, lambda state: state["camera"]["mode"] == "scene", "it is written")
        self.until_final(page)
        page.press("Ctrl-S")
        wait_until(lambda: self.saved() == page.script, "it is saved")
        width, height = page.state["view"]["width"], page.state["view"]["height"]
        self.assert_same(page.pixels()[2], self.rendered("scene.tessera", size=(width, height)))

    def test_a_free_camera_outlasts_edits_saving_and_reconnecting(self):
        page, (x, y) = self.browser_page, self.view
        free = self.moved("dragging", lambda: page.drag((x, y), (x + 60, y + 10)))
        self.write_at(page, 5, ANOTHER)
        page.press("Ctrl-S")
        before = self.until_final(page)
        self.assertEqual(free, page.state["camera"])
        shown = page.pixels()
        self.running.process.send_signal(signal.SIGSTOP)
        try:
            self.until(page, lambda state: state["connection"] == "lost", "the connection is lost")
            self.assertEqual(free, page.state["camera"])
        finally:
            self.running.process.send_signal(signal.SIGCONT)
        self.until(page, lambda state: state["connection"] == "open", "it is connected again")
        # The picture that is made over the new connection is seen from there, too.
        self.until_final(page, before)
        self.assertEqual(free, page.state["camera"])
        self.assert_same(shown, page.pixels())
        self.assertTrue(page.has(".chip", "free"))
        page.click_on(".view-frame")
        page.press("Home")
        self.until(page, lambda state: state["camera"]["mode"] == "scene", "Home leads back")
        self.assertTrue(page.has(".chip", "scene’s: front"))

    def test_a_panorama_has_no_field_of_view_of_the_view(self):
        page = self.browser_page
        page.click_on(".view-options summary")
        wait_until(lambda: page.has(".camera-fields", "Field of view"), "a perspective has one")
        self.scene("scene.tessera", SCENE.replace('name: "front"', 'name: "front" spherical { }'))
        wait_until(lambda: "spherical" in page.script, "the page follows the file")
        wait_until(lambda: not page.has(".camera-fields", "Field of view"), "a panorama has none")
        self.assertFalse(page.has(".camera-fields", "It spans"))
        self.assertTrue(page.has(".camera-fields", "Target"))
        self.until_final(page)

    def test_a_camera_that_was_moved_is_written_to_the_one_that_it_was(self):
        page = self.browser_page
        other = 'cameras { name: "side" world_from_camera { steps { look_at { eye { x: 5 } target { } } } } }\n'
        before = page.state
        self.write_at(page, 2, "\n" + other.rstrip())
        self.until_final(page, before)
        self.choose_camera(page, "side")
        self.until(page, lambda state: state["camera"]["eye"] == [5, 0, 0], "the other camera is seen through")
        page.click_on(".view-frame")
        self.moved("an arrow", lambda: page.press("Left"))
        self.until(page, lambda state: state["camera"]["mode"] == "free", "it is moved")
        text = page.script
        page.press("F1")
        page.type("Write camera")
        page.press("Enter")
        wait_until(lambda: page.script != text, "it is written")
        self.until(page, lambda state: state["camera"]["mode"] == "scene", "the view sees through it")
        wait_until(lambda: page.has(".chip", "side"), "it is named above the picture")
        lines = page.script.split("\n")
        self.assertEqual(SCENE.split("\n")[1], lines[1], "the first camera stays")
        self.assertTrue(lines[2].startswith('cameras { name: "side"'))
        self.assertNotEqual(other.rstrip(), lines[2])
        self.until_final(page)
        page.press("F1")
        page.type("Camera: copy")
        page.press("Enter")
        wait_until(lambda: page.has(".notice", "In the clipboard: " + lines[2]), "its text can be pasted into another scene")

    def test_a_camera_without_a_name_is_chosen_and_written(self):
        page = self.browser_page
        other = "cameras { world_from_camera { steps { look_at { eye { x: 5 } target { } } } } }"
        before = page.state
        self.write_at(page, 2, "\n" + other)
        before = self.until_final(page, before)
        self.choose_camera(page, "camera 2")
        chosen = self.until(page, lambda state: state["camera"]["eye"] == [5, 0, 0], "the other camera is seen through")
        wait_until(lambda: page.has(".chip", "scene’s: camera 2"), "it is told")
        self.until_final(page, before)
        width, height, pixels = page.pixels()
        page.press("Ctrl-S")
        wait_until(lambda: self.saved() == page.script, "it is saved")
        self.assert_same(self.rendered("scene.tessera", "--camera", 2, size=(width, height)), pixels)
        page.click_on(".view-frame")
        self.moved("an arrow", lambda: page.press("Left"))
        text = page.script
        page.press("F1")
        page.type("Write camera")
        page.press("Enter")
        wait_until(lambda: page.script != text, "it is written")
        self.until(page, lambda state: state["camera"]["mode"] == "scene" and state["camera"] != chosen["camera"],
                   "the view sees through it")
        lines = page.script.split("\n")
        self.assertEqual(SCENE.split("\n")[1], lines[1], "the first camera stays")
        self.assertNotEqual(other, lines[2])

    def test_the_picture_of_a_written_camera_is_that_of_render(self):
        page = self.browser_page
        cornell = (SAMPLES / "cornell.tessera").read_text()
        self.scene("scene.tessera", cornell)
        wait_until(lambda: page.script == cornell, "the page follows the file")
        self.until_final(page)
        page.click_on(".view-frame")
        # The numbers of the mouse and of the keys are longer than those that are written.
        for key in ("Left", "Up", "W", "Shift-Left", "A"):
            self.moved(key, lambda key=key: page.press(key))
        self.until_final(page)
        free, text = page.state, page.script
        page.press("F1")
        page.type("Write camera")
        page.press("Enter")
        wait_until(lambda: page.script != text, "it is written")
        self.until_final(page, free)
        self.assertEqual("scene", page.state["camera"]["mode"])
        page.press("Ctrl-S")
        wait_until(lambda: self.saved() == page.script, "it is saved")
        width, height, pixels = page.pixels()
        self.assert_same(pixels, self.rendered(size=(width, height)))

    @staticmethod
    def choose_camera(page, name):
        """In the list above the picture, by keys."""
        wait_until(lambda: page.has('select[aria-label="Camera"]'), "there are several cameras")
        page.evaluate("document.querySelector('select[aria-label=\"Camera\"]').focus()")
        page.type(name)

    def test_each_scene_keeps_its_camera_and_what_was_picked_in_it(self):
        page = self.browser_page
        self.scene("other.tessera", SCENE.replace("1.25", ".5"))

        def show(name):
            page.click_on('.file-tabs [role="tab"]', name)
            self.until(page, lambda state: state["file"] == name, f"{name} is shown")
            self.until_final(page)

        def seen():
            return page.state["camera"], page.state["selection"]["entity"], page.evaluate(
                "document.querySelector('.chain').textContent")

        page.click_at(*self.view)
        wait_until(lambda: page.has(".chain button", "ball"), "the ball is picked")
        first_camera = self.moved("an arrow", lambda: page.press("Left"))
        first = seen()
        page.press("Ctrl-Shift-S")
        page.press("Ctrl-A")
        page.type("copy.tessera\n")
        self.until(page, lambda state: state["file"] == "copy.tessera", "the copy is shown")
        self.until_final(page)
        self.assertEqual(first_camera, page.state["camera"])
        wait_until(lambda: page.has('.panel-files [role="option"]', "copy.tessera"), "files are listed")
        page.click_on('.panel-files [role="option"]', "other.tessera")
        self.until(page, lambda state: state["file"] == "other.tessera", "the other one is shown")
        self.until_final(page)
        camera, entity, chain = seen()
        self.assertEqual(("scene", None), (camera["mode"], entity))
        self.assertNotIn("ball", chain)
        page.click_on(".view-frame")
        wait_until(lambda: page.has(".chain button"), "something is picked")
        self.moved("an arrow", lambda: page.press("Up"))
        second = seen()
        self.assertNotEqual(first, second)
        show("scene.tessera")
        self.assertEqual(first, seen())
        show("other.tessera")
        self.assertEqual(second, seen())

    @staticmethod
    def distance(camera):
        return sum((a - b) ** 2 for a, b in zip(camera["eye"], camera["target"])) ** .5


class Numbers(StudioPageTest):
    def test_a_wrong_number_is_said_and_not_applied(self):
        page = self.begin()
        page.click_on(".view-options summary")
        _, y = page.middle(".view-options label.number", "Samples")
        box = page.box(".view-options label.number", "Samples")
        page.click_at(box[2] + box[4] - 30, y)
        for wrong in ("nan", "inf", "1,5", "1;2", "0", "-1", "1.5"):
            page.press("Ctrl-A")
            page.type(wrong)
            wait_until(lambda: page.has(".view-options label.wrong .why", "expected"), f"{wrong} is wrong")
            self.assertNotIn(page.state["view"]["samples"], (0, -1, 1.5))
        page.press("Ctrl-A")
        page.type("9")
        state = self.until(page, lambda state: state["picture"]["samples"] == 9 and state["picture"]["final"], "9 samples")
        self.assertFalse(page.has(".view-options label.wrong"))
        self.assertEqual(9, state["view"]["samples"])


    def test_camera_numbers_that_make_no_view_are_said_and_not_applied(self):
        page = self.begin()
        page.click_on(".view-options summary")

        def type_in(label, text):
            page.evaluate(f"""(() => {{ const field = [...document.querySelectorAll(".camera-fields label.number")].find((each) =>
                each.textContent.startsWith({label!r})); field.querySelector("input").focus(); }})()""")
            page.press("Ctrl-A")
            page.type(text)

        type_in("Up z", "0")
        before = self.until(page, lambda state: state["camera"]["up"][2] == 0, "the camera is turned")["camera"]
        for label, text, expected in (("Up y", "0", "an up that is not 0 0 0"), ("Eye z", "0", "not along the view")):
            type_in(label, text)
            wait_until(lambda: page.has(".camera-fields label.wrong .why", f"found {text}; expected "), f"{label} is wrong")
            self.assertIn(expected, page.text(".camera-fields label.wrong .why"))
            self.assertEqual(before, page.state["camera"])
            page.press("Escape")
            wait_until(lambda: not page.has(".camera-fields label.wrong"), "it is right again")
        type_in("Eye y", "0")
        moved = self.until(page, lambda state: state["camera"]["eye"] == [0, 0, 5], "the camera is moved")["camera"]
        type_in("Eye z", "0")
        wait_until(lambda: page.has(".camera-fields label.wrong .why", "an eye that is not at the target"), "it is wrong")
        self.assertEqual(moved, page.state["camera"])


    def test_width_and_height_are_typed(self):
        page = self.begin()
        self.write_at(page, 1, "", end=False)
        page.click_on('[role="tab"]', "Properties")
        self.until(page, lambda state: state["selection"]["entity"] == "settings", "the settings are selected")

        def type_in(label, text):
            wait_until(lambda: page.evaluate(f"""(() => {{ const field = [...document.querySelectorAll(".panel-properties label.number")].find((each) =>
                each.querySelector("span").textContent === {label!r}); field?.querySelector("input").focus(); return field !== undefined; }})()"""), label)
            page.press("Ctrl-A")
            page.call("Input.insertText", text=text)  # at once, as what is pasted: some begin with what is right

        # What LUX's own tests type, and more.
        for label, wrong in (("width", ("blah", "0", "65537", "9.5")), ("height", ("-1", "1e2", "nan"))):
            for text in wrong:
                type_in(label, text)
                wait_until(lambda: page.evaluate("document.activeElement.ariaInvalid") == "true", f"{label}: {text} is wrong")
                why = page.evaluate("document.getElementById(document.activeElement.getAttribute('aria-describedby')).textContent")
                self.assertIn("expected a whole number from 1 to 65536", why)
                self.assertEqual(SCENE, page.script)
        type_in("height", "64")
        wait_until(lambda: page.script == SCENE.replace("height: 54", "height: 64"), "the literal is replaced")

    def test_no_full_picture_is_made_while_a_field_is_wrong(self):
        page = self.begin()
        page.click_on(".view-options summary")
        page.evaluate("""[...document.querySelectorAll(".view-options label.number")].find((each) =>
            each.textContent.startsWith("Samples")).querySelector("input").focus()""")
        page.type("none")
        wait_until(lambda: page.has(".view-options label.wrong"), "it is wrong")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Enter")
        wait_until(lambda: page.has(".notice.error", "Samples: found “none”; expected a whole number"), "it is said")
        self.assertEqual("none", page.evaluate("document.activeElement.value"), "the field has the focus")
        page.click_on('[role="tab"]', "Farm")
        self.assertFalse(page.has('table[aria-label="Full pictures"]'))
        page.evaluate("document.querySelector('.view-options label.wrong input').focus()")
        page.press("Ctrl-A")
        page.type("2")
        page.press("Ctrl-Enter")
        wait_until(lambda: page.has('table[aria-label="Full pictures"]', "done"), "it is made once no field is wrong")


class Tone(StudioPageTest):
    def test_exposure_by_keys_traces_nothing(self):
        page = self.begin()
        before, dark = page.state["picture"]["serial"], page.pixels()
        page.click_on(".view-frame")
        page.press("]", 2)
        self.until(page, lambda state: state["view"]["exposure"] == 1, "a stop more")
        # The picture of the first half stop may come before that of both.
        width, height, _ = dark
        bright = self.rendered("scene.tessera", "--exposure", 1, size=(width, height))
        wait_until(lambda: page.pixels() == (width, height, bright), "it is as bright as that of render")
        self.assertEqual(before, page.state["picture"]["serial"])
        page.press("[", 2)
        wait_until(lambda: page.pixels() == dark, "it is as before")
        self.assertEqual(before, page.state["picture"]["serial"])


if __name__ == "__main__":
    unittest.main()
