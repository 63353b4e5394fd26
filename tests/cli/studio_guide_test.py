#!/usr/bin/env python3
"""The pictures of docs/studio.md: the steps of that page in a browser, with our samples.

With TESSERA_PICTURES=docs/images they are kept there.
"""
import os
import pathlib
import re
import shutil
import unittest

from png import read_png
from studio_browser import StudioPageTest
from studio_case import SAMPLES

DOCS = pathlib.Path(__file__).parents[2] / "docs"
KEPT = os.environ.get("TESSERA_PICTURES")
SAMPLE = "still_life.tessera"


class Guide(StudioPageTest):
    def setUp(self):
        super().setUp()
        for name in os.listdir(SAMPLES):
            shutil.copy(SAMPLES / name, self.opened)

    def keep(self, page, name):
        path = self.folder / f"{name}.png"
        page.screenshot(path)
        width, height, pixels = read_png(path)
        self.assertEqual((1280, 720), (width, height))
        self.assertGreater(len({pixels[i:i + 3] for i in range(0, len(pixels), 300)}), 100, "there is something to see")
        if KEPT:
            shutil.copy(path, pathlib.Path(KEPT).resolve() / path.name)

    def test_the_pictures_of_the_guide(self):
        page = self.begin("--workers", 2, file=SAMPLE, scene=False)
        self.keep(page, "studio")

        box = page.box(".panel-view canvas")
        page.click_at(box[2] + box[4] * .5, box[3] + box[5] * .6)
        self.until(page, lambda state: state["selection"]["entity"], "something was picked")
        self.keep(page, "studio_pick")

        page.press("Escape")
        page.click_on(".cm-scroller")
        page.press("Ctrl-End")
        page.type("\nnodes { shape { sphere { raduis: 2 } } }")
        self.until(page, lambda state: any(each["suggestion"] for each in state["problems"]), "the slip is listed")
        self.until(page, lambda state: state["picture"]["stale"], "the last good picture stays, and is told to be old")
        self.keep(page, "studio_error")

    def test_the_guide_shows_what_is_made_here(self):
        made = set(re.findall(r'self\.keep\(page, "(\w+)"\)', pathlib.Path(__file__).read_text()))
        shown = set(re.findall(r"images/(studio\w*)\.png", (DOCS / "studio.md").read_text()))
        self.assertEqual(made, shown)
        for name in made:
            self.assertTrue((DOCS / "images" / f"{name}.png").exists(), name)
        self.assertIn("docs/images/studio.png", (DOCS.parent / "README.md").read_text())


if __name__ == "__main__":
    unittest.main()
