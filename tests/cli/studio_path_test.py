#!/usr/bin/env python3
"""The one path through the studio's page that every run of the tests walks, in a real browser: a scene is opened,
changed, broken, mended and saved. The nightly tests of the page go into each of these."""
import unittest

from studio_browser import StudioPageTest
from studio_case import SCENE
from tessera_process import wait_until

BALL = SCENE.split("\n").index('nodes { name: "ball" shape { materials: "red" sphere { radius: 1.25 } } }') + 1
AFTER_RADIUS = len(" } } }")


class Path(StudioPageTest):
    def test_a_scene_is_opened_changed_broken_mended_and_saved(self):
        page = self.begin()
        self.assertEqual(SCENE, page.script)
        width, height, opened = page.pixels()
        self.assert_same(opened, self.rendered(size=(width, height)))

        self.write_at(page, BALL, "")
        page.press("Left", AFTER_RADIUS)
        page.press("Backspace", len("1.25"))
        page.type(".75")
        changed = SCENE.replace("1.25", ".75")
        self.assertEqual(changed, page.script)
        self.until_final(page)
        _, _, smaller = page.pixels()
        self.assertFalse(smaller == opened, "the picture is that of the ball as it was")

        page.type("x")
        problem = self.until(page, lambda state: state["problems"], "the problem is told")["problems"][-1]
        self.assertEqual(("error", "scene.tessera", BALL), (problem["severity"], problem["file"], problem["line"]))
        wait_until(lambda: page.has(".cm-lintRange-error") and page.has('.panel-problems [role="option"]', "'x' is no field of Sphere"),
                   "it is underlined and listed")
        wait_until(lambda: page.has("#view-words", "as of "), "the picture is told to be old")
        self.assert_same(smaller, page.pixels()[2])

        page.press("Backspace")
        self.until(page, lambda state: not state["problems"] and not state["picture"]["stale"], "it is mended")
        self.until_final(page)
        self.assert_same(smaller, page.pixels()[2])
        self.assertEqual(SCENE, self.saved(), "nothing is saved by itself")
        page.press("Ctrl-S")
        self.until(page, lambda state: not state["dirty"], "it is saved")
        self.assertEqual(changed, self.saved())
        self.assert_same(smaller, self.rendered(size=(width, height)))


if __name__ == "__main__":
    unittest.main()
