#!/usr/bin/env python3
"""Clicks on the page's picture: the text that they select, the chain, the outlines and the pivot."""
import signal
import time
import unittest

from studio_browser import StudioPageTest
from studio_pick_test import PART, SCENE
from tessera_process import wait_until


class Pick(StudioPageTest):
    def begin(self, *options, **more):
        self.scene("scene.tessera", SCENE)
        self.scene("part.crt", PART)
        return super().begin(*options, scene=False, **more)

    def on_picture(self, page, right, down):
        """A point of the picture, by shares of its sides."""
        _, _, x, y, width, height = page.box(".view-frame")
        return x + right * width, y + down * height

    def until_selected(self, page, file, line):
        return self.until(page, lambda state: (state["file"], state["selection"]["line"]) == (file, line),
                          f"{file}:{line} is selected")

    def outlined(self, page, name):
        return int(page.evaluate(f"document.querySelector('.outlines').dataset.{name} ?? 0"))

    def test_a_click_selects_the_text_and_the_chain_is_walked(self):
        page = self.begin()
        page.click_at(*self.on_picture(page, .38, .5))
        state = self.until_selected(page, "scene.tessera", 4)
        self.assertEqual((8, 2), (state["selection"]["endLine"], state["selection"]["endColumn"]))
        self.assertEqual("nodes[1]", state["selection"]["entity"])
        page.click_at(*self.on_picture(page, .62, .6))
        self.until_selected(page, "part.crt", 4)
        for line in (8, 8):
            page.press("Alt-Up")
            self.until_selected(page, "part.crt", line)
        page.press("Alt-Up")
        self.until_selected(page, "scene.tessera", 9)
        page.press("Alt-Down", 3)
        self.until_selected(page, "part.crt", 4)
        page.click_on(".chain button", "material")
        self.until_selected(page, "part.crt", 2)
        page.click_at(*self.on_picture(page, .38, .5))
        self.until_selected(page, "scene.tessera", 3)  # what is picked is a material until another kind is

    def test_a_click_on_an_older_picture_selects_its_text_where_that_is_now(self):
        page = self.begin()
        self.write_at(page, 1, "nodes { shape { oops } }\n# a line\n", end=False)
        self.until(page, lambda state: state["picture"]["stale"], "the picture is older than the text, which is wrong")
        page.click_at(*self.on_picture(page, .38, .5))
        state = self.until_selected(page, "scene.tessera", 6)
        self.assertEqual((10, 2), (state["selection"]["endLine"], state["selection"]["endColumn"]))
        self.until(page, lambda state: state["selection"]["entity"] == "nodes[2]", "the ball is another entity by now")
        wait_until(lambda: self.outlined(page, "selected") == 1, "the ball is outlined")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        self.until(page, lambda state: state["selection"]["entity"] == "nodes[0]", "what was typed is selected")
        wait_until(lambda: self.outlined(page, "selected") == 0, "which the picture does not show")

    def test_a_late_answer_to_a_click_leaves_the_cursor_where_it_was_put_since(self):
        page = self.begin()

        def is_answered():
            self.running.process.send_signal(signal.SIGSTOP)
            try:
                page.click_at(*self.on_picture(page, .38, .5))
                page.click_on(".cm-scroller")
                page.press("Ctrl-End")
            finally:
                self.running.process.send_signal(signal.SIGCONT)
            for _ in range(100):
                if page.has(".chain button", "ball"):
                    return True
                time.sleep(.05)
            return False  # after a silence of 3 s the page takes the connection for lost, and the question with it
        wait_until(is_answered, "the answer is there")
        self.assertEqual(SCENE.count("\n") + 1, page.state["selection"]["line"])

    def test_what_is_under_the_pointer_and_the_cursor_is_outlined(self):
        page = self.begin()
        page.pointer("mouseMoved", *self.on_picture(page, .38, .5))
        wait_until(lambda: self.outlined(page, "hovered") > 0, "the ball is outlined")
        self.assertTrue(page.has(".hover-name", "ball"))
        page.pointer("mouseMoved", *self.on_picture(page, .5, .03))
        wait_until(lambda: self.outlined(page, "hovered") == 0, "nothing is")
        self.write_at(page, 5, "")
        wait_until(lambda: self.outlined(page, "selected") == 1, "the cursor's node is outlined")

    def test_a_cross_hair_picks_by_keys_alone(self):
        page = self.begin()
        page.press("F1")
        page.type("show view")
        page.press("Enter")
        page.press("Enter")
        wait_until(lambda: page.has(".crosshair"), "the cross-hair is there")
        camera = page.state["camera"]
        _, _, x, y, width, _ = page.box(".view-frame")
        target = x + .38 * width
        while page.box(".crosshair")[0] > target:
            page.press("Left")
            page.wait_for_frames()
        page.press("Enter")
        self.until_selected(page, "scene.tessera", 4)
        page.press("Escape")
        wait_until(lambda: not page.has(".crosshair"), "it is gone")
        self.assertEqual(camera, page.state["camera"])

    def test_a_double_click_sets_what_is_orbited_about(self):
        page = self.begin()
        at = self.on_picture(page, .38, .5)
        page.click_at(*at)
        page.click_at(*at, count=2)
        self.until(page, lambda state: state["view"]["pivot"], "what is orbited about is known")
        before = page.state["camera"]
        page.drag(at, (at[0] + 60, at[1]))
        after = self.until(page, lambda state: state["camera"]["eye"] != before["eye"], "it turned")["camera"]
        self.assertNotEqual(before["target"], after["target"])


if __name__ == "__main__":
    unittest.main()
