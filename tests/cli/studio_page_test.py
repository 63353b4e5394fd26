#!/usr/bin/env python3
"""The page of `tessera studio` in a real browser: its keys and layout, other tabs, and what is lost."""
import json
import signal
import unittest

from studio_browser import StudioPageTest
from studio_case import SCENE
from tessera_process import wait_until


class Keyboard(StudioPageTest):
    def test_keys_move_the_camera(self):
        page = self.begin()
        page.click_on(".view-frame")
        for key in ("Left", "Right", "Up", "Down", "w", "s", "a", "d", "q", "e", "+", "-", "1", "2", "3"):
            before = page.state["camera"]
            page.press(key)
            self.until(page, lambda state: state["camera"] != before, key)
        page.press("0")
        self.until(page, lambda state: state["camera"]["mode"] == "scene", "0 is the scene's camera")

    def test_every_command_is_found_by_a_part_of_its_name(self):
        page = self.begin()
        page.press("F1")
        wait_until(lambda: page.has("dialog", "Save as"), "commands are listed")
        page.type("theme lig")
        page.press("Enter")
        self.until(page, lambda state: state["theme"] == "light", "the theme is light")

    def test_panels_by_keys_alone(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        seen = set()
        for _ in range(12):
            page.press("F6")
            seen.add(page.evaluate("document.activeElement.closest('section')?.getAttribute('aria-label')"))
        self.assertGreaterEqual(seen, {"Files", "Script", "View", "Problems"})

    def test_tab_indents_and_escape_tab_leaves(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Tab")
        self.assertNotEqual(SCENE, page.script)
        page.press("Ctrl-Z")
        page.press("Escape")
        page.press("Tab")
        self.assertEqual(SCENE, page.script)
        self.assertFalse(page.evaluate("document.activeElement.classList.contains('cm-content')"))

    def test_text_is_dragged_within_the_editor(self):
        page = self.begin()
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Shift-End")
        first, last = (page.middle(".cm-line", text) for text in ("settings {", "light {"))
        page.drag_text(first, last)
        words = SCENE.split("\n")[0]
        wait_until(lambda: words in page.script[1:], "the line is dropped below")
        self.assertTrue(page.script.startswith("\n"), page.script)
        page.press("Ctrl-Z")
        self.assertEqual(SCENE, page.script)


class Layout(StudioPageTest):
    def cut(self, page, selector):
        """The texts there that are cut off."""
        return page.evaluate(f"""[...document.querySelectorAll({json.dumps(selector)})].filter((each) =>
            each.scrollWidth > each.clientWidth || each.scrollHeight > each.clientHeight).map((each) => each.textContent)""")

    def test_words_of_the_view_and_of_dialogs_are_whole(self):
        self.scene(text=SCENE.replace("samples_per_pixel: 4", "samples_per_pixel: 65536"))
        self.running = self.studio("--workers", 1)
        page = self.visit(None)
        page.click_on('.panel-files [role="option"]', "scene.tessera")
        bar = page.box(".view-bar")
        page.click_on(".view-frame")
        page.press("Left")
        for words in ("samples, ", "stopped"):
            wait_until(lambda: page.has(".view-words", words), words)
            self.assertEqual([], self.cut(page, ".view-words > span"), page.state["picture"])
            self.assertEqual(bar, page.box(".view-bar"))
            page.click_on(".view-frame")
            page.press("Escape")
        for keys in ("Alt-E", "Ctrl-Shift-Enter"):
            page.press(keys)
            wait_until(lambda: page.has("dialog .field"), "the dialog")
            self.assertEqual([], self.cut(page, "dialog .field > span:first-child"))
            page.press("Escape")
            wait_until(lambda: not page.has("dialog"), "it is closed")

    def test_all_of_the_animation_is_reached_in_a_low_panel(self):
        page = self.begin()
        page.resize(1280, 576)
        page.click_on('[role="tab"]', "Animation")
        _, _, _, top, _, height = page.box(".panel-animation")
        self.assertLess(height, 110)
        rows = page.evaluate("[...document.querySelectorAll('.animation > *')].map((each) => "
                             "[each.offsetTop, each.offsetHeight, each.scrollHeight])")
        self.assertEqual(4, len(rows))
        for (above, its_height, _), (below, _, _) in zip(rows, rows[1:]):
            self.assertGreaterEqual(below, above + its_height, rows)
        for _, its_height, needed in rows:
            self.assertGreaterEqual(its_height, max(needed, 10), rows)
        page.middle(".animation > .fields")  # which scrolls
        _, _, _, y, _, its_height = page.box(".animation > .fields")
        self.assertTrue(top <= y and y + its_height <= top + height, (top, height, y, its_height))

    def test_splitters_by_mouse_and_keys_and_maximising(self):
        page = self.begin()
        shares = page.state["layout"]["shares"]
        x, y = page.middle('[aria-label="Width of the script"]')
        page.drag((x, y), (x + 100, y))
        wider = self.until(page, lambda state: state["layout"]["shares"] != shares, "it is moved")["layout"]["shares"]
        self.assertGreater(wider["middle"], shares["middle"])
        page.press("Left")
        self.until(page, lambda state: state["layout"]["shares"]["middle"] < wider["middle"], "moved by a key")
        page.click_on(".cm-scroller")
        page.press("Ctrl-M")
        self.until(page, lambda state: state["layout"].get("maximised") == "middle", "the script is maximised")
        page.press("Ctrl-M")
        self.until(page, lambda state: not state["layout"].get("maximised"), "and back")
        self.until_final(page)

    def test_one_row_of_tabs_where_it_is_narrow(self):
        page = self.begin()
        page.resize(320, 640)
        wait_until(lambda: page.has(".zones.narrow"), "it is narrow")
        self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), 320)
        page.click_on('[role="tab"]', "Script")
        wait_until(lambda: page.has(".cm-content"), "the script is shown")
        page.resize(1280, 720)
        wait_until(lambda: not page.has(".zones.narrow"), "all zones again")
        self.until_final(page)

    def test_how_the_view_is_looked_at_outlasts_a_reload(self):
        page = self.begin()
        page.click_on(".view-options summary")
        for label, value in (("Channel", "normal"), ("Integrator", "albedo")):
            page.evaluate(f"[...document.querySelectorAll('.view-options label.field')].find((each) => "
                          f"each.firstChild.textContent === '{label}').querySelector('select').focus()")
            page.type(value)
        page.click_on('[aria-label="Half a stop more"]')
        look = {"kind": "normal", "integrator": "albedo", "exposure": 0.5}
        self.until(page, lambda state: look.items() <= state["view"].items(), "it is looked at so")
        settings = self.folder / "config/tessera/studio.json"
        wait_until(lambda: settings.exists() and "albedo" in settings.read_text(), "it is kept")
        self.navigate(page)
        self.until(page, lambda state: look.items() <= state["view"].items(), "it is looked at so again")

    def test_the_font_of_texts_is_chosen_and_outlasts_a_reload(self):
        def font():
            return page.evaluate("getComputedStyle(document.querySelector('.cm-scroller')).fontFamily")
        page = self.begin()
        self.assertTrue(font().startswith("ui-monospace"), font())
        page.press("Ctrl-,")
        page.evaluate("document.querySelector('dialog [placeholder=\"a monospaced one\"]').focus()")
        page.type('No"to Mono')
        page.press("Tab")
        wait_until(lambda: font().startswith('"Noto Mono"'), "a quote leaves the rest of the page's style alone")
        settings = self.folder / "config/tessera/studio.json"
        wait_until(lambda: settings.exists() and "to Mono" in settings.read_text(), "it is kept")
        self.navigate(page)
        wait_until(lambda: font().startswith('"Noto Mono"'), "it is chosen still")


class Status(StudioPageTest):
    def test_the_status_bar_tells_of_text_picture_and_program(self):
        self.scene("scene.tessera", "\ufeff" + SCENE.replace("\n", "\r\n"))
        page = self.begin(scene=False)
        self.write_at(page, 1, " wrong")
        for words in ("1 error", "Line 1, column 74", "UTF-8 with mark", "CRLF", "1 worker", "connected", "Tessera"):
            wait_until(lambda: page.has(".status-bar", words), words)
        wait_until(lambda: page.evaluate(r"/\d [kMG]B/.test(document.querySelector('.status-bar').textContent)"),
                   "the memory is told")
        page.click_on(".status-bar button", "1 error")
        wait_until(lambda: page.focused().startswith("● error"), "it leads to the problems")


class Tabs(StudioPageTest):
    def test_a_second_tab_follows_and_takes_over(self):
        first = self.begin()
        second = self.visit()
        self.assertTrue(second.state["readOnly"])
        self.write_at(first, 1, " # first")
        typed = SCENE.replace("\n", " # first\n", 1)
        wait_until(lambda: second.script == typed, "it follows")
        second.click_on(".banner button", "Edit here")
        self.until(second, lambda state: not state["readOnly"], "it edits")
        self.until(first, lambda state: state["readOnly"], "the other reads")
        self.write_at(second, 1, " # second")
        wait_until(lambda: first.script == second.script == typed.replace("first\n", "first # second\n"), "both are alike")
        first.click_on(".banner button", "Edit here")
        self.until(first, lambda state: not state["readOnly"], "the first edits again")
        first.click_on(".cm-scroller")
        first.press("Ctrl-Z", len(" # first # second"))
        self.assertEqual(SCENE, first.script, "the history outlasts that another tab edited")
        wait_until(lambda: second.script == SCENE, "the other follows")


class Disk(StudioPageTest):
    def test_a_clean_text_follows_the_disk_and_can_be_undone(self):
        page = self.begin()
        theirs = SCENE.replace("1.25", "0.75")
        self.scene("scene.tessera", theirs)
        wait_until(lambda: page.script == theirs, "it follows")
        self.until_final(page)
        self.assertFalse(page.state["dirty"])
        page.click_on(".cm-scroller")
        page.press("Ctrl-Z")
        self.assertEqual(SCENE, page.script)

    def test_an_edited_text_is_asked_about(self):
        page = self.begin()
        self.write_at(page, 1, " # mine")
        mine = page.script
        self.scene("scene.tessera", SCENE + "# theirs\n")
        wait_until(lambda: page.has(".banner", "changed on the disk"), "it is asked")
        page.press("Ctrl-S")
        self.assertEqual(mine, page.script)
        self.assertEqual(SCENE + "# theirs\n", self.saved())
        page.click_on(".banner button", "Keep mine")
        page.press("Ctrl-S")
        wait_until(lambda: self.saved() == mine, "mine is saved")
        self.write_at(page, 1, " # again")
        self.scene("scene.tessera", SCENE + "# theirs\n")
        page.click_on(".banner button", "Load theirs")
        wait_until(lambda: page.script == SCENE + "# theirs\n", "theirs is loaded")

    def test_a_deleted_file_is_marked_on_its_tab(self):
        page = self.begin()
        tab = '.file-tabs [role="tab"]'
        self.assertFalse(page.has(f"{tab} .sign"))
        (self.opened / "scene.tessera").unlink()
        wait_until(lambda: page.has(f"{tab} .sign", "!"), "it is marked")
        self.assertEqual("scene.tessera is no longer on the disk", page.evaluate(f"document.querySelector('{tab}').title"))
        self.write_at(page, 1, " # kept")
        page.press("Ctrl-S")
        wait_until(lambda: not page.has(f"{tab} .sign"), "it is there again")
        self.assertEqual(page.script, self.saved())


class Recovery(StudioPageTest):
    def test_typing_goes_on_while_the_program_is_gone(self):
        page = self.begin()
        self.write_at(page, 1, " # before")
        address = self.running.address
        self.kill(self.running)
        self.until(page, lambda state: state["connection"] == "lost", "the loss is said")
        self.write_at(page, 1, " # after")
        self.running = self.studio("--workers", 1, http=address)
        self.navigate_token(page)
        self.until(page, lambda state: state["connection"] == "open", "it is connected again")
        typed = SCENE.replace("\n", " # before # after\n", 1)
        self.assertEqual(typed, page.script)
        page.press("Ctrl-S")
        wait_until(lambda: self.saved() == typed, "it is saved")

    def test_a_program_that_falls_silent_is_said_to_be_lost(self):
        page = self.begin()
        self.running.process.send_signal(signal.SIGSTOP)
        try:
            # Its socket is open all the while.
            self.until(page, lambda state: state["connection"] == "lost", "the silence is said")
            self.write_at(page, 1, " # meanwhile")
        finally:
            self.running.process.send_signal(signal.SIGCONT)
        self.until(page, lambda state: state["connection"] == "open", "it is connected again")
        typed = SCENE.replace("\n", " # meanwhile\n", 1)
        self.assertEqual(typed, page.script)
        page.press("Ctrl-S")
        wait_until(lambda: self.saved() == typed, "it is saved")

    def navigate_token(self, page):
        """Gives the token of the program that was started again."""
        self.until(page, lambda state: state["connection"] == "refused", "the token is another one")
        page.click_on('dialog input[aria-label="Token"]')
        page.type(self.running.token)
        page.press("Enter")

    def test_a_draft_is_offered_after_a_crash_of_both(self):
        page = self.begin()
        self.write_at(page, 1, " # unsaved")
        drafts = self.folder / "state/tessera/studio"
        wait_until(lambda: any(b"unsaved" in each.read_bytes() for each in drafts.glob("*")
                               if each.is_file() and each.suffix != ".part"), "the draft is kept")
        kept = self.folder / "config/tessera/studio"
        wait_until(lambda: any('"scene.tessera"' in each.read_text() for each in kept.glob("*.json")), "it is to open again")
        self.pages.remove(page)
        page.close()
        self.kill(self.running)
        self.running = self.studio("--workers", 1)
        page = self.visit(None)
        page.click_on("dialog button", "Restore")
        wait_until(lambda: page.script == SCENE.replace("\n", " # unsaved\n", 1), "the text is back")
        page.press("Ctrl-Z")
        self.assertEqual(SCENE, page.script)


class Token(StudioPageTest):
    def test_the_token_leaves_the_address_and_outlasts_a_reload(self):
        page = self.begin()
        self.assertEqual(self.running.url, page.evaluate("location.href"))
        page.reload()
        self.until(page, lambda state: state["connection"] == "open", "it is connected")

    def test_a_wrong_token_is_asked_for(self):
        page = self.begin()
        self.navigate(page, "0" * 32)
        wait_until(lambda: page.has("dialog", "Token"), "the token is asked for")
        page.type(self.running.token)
        page.press("Enter")
        self.until(page, lambda state: state["connection"] == "open", "it is connected")


if __name__ == "__main__":
    unittest.main()
