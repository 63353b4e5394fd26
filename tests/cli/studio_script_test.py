#!/usr/bin/env python3
"""The script of a studio's page while someone types: what folds, what the view says, what is laid out for it."""
import itertools
import signal
import time
import unittest

from studio_browser import StudioPageTest
from studio_case import SCENE
from tessera_process import wait_until

CRT = """\
Settings {
  xRes -> 64
  yRes -> 36
}
Scene {
  Sphere {
    radius -> 1 -- }
  }
}
"""
CLASSIC = """\
#X3D V3.3 utf8
PROFILE Interchange
Shape {
  geometry IndexedFaceSet {
    coordIndex [
      0 1 2 -1
    ]
    coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] }
  }
}
"""
BLOCK = """\
nodes {
  name: "}" # {
  shape { sphere { radius: 0.5 } }
}
"""


class Folding(StudioPageTest):
    def fold(self, name, text, line):
        """A page whose cursor is in a line of the file's text, which is folded by keys."""
        self.scene(name, text)
        page = self.begin(file=None, scene=False)
        page.click_on('.panel-files [role="option"]', name)
        self.until(page, lambda state: state["file"] == name, "the file is open")
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Down", line - 1)
        page.press("Ctrl-Shift-[")
        return page

    def lines(self, page):
        """The lines that are seen, as they are seen."""
        return page.evaluate("[...document.querySelectorAll('.cm-line')].map((each) => each.textContent)")

    def assert_folded(self, page, text, first, last):
        """Of these lines, which are counted from 1, what stands between the first and the last one's end is folded."""
        lines = text.split("\n")
        self.assertEqual(lines[:first - 1] + [lines[first - 1] + "…" + lines[last - 1].strip()] + lines[last:],
                         self.lines(page))
        self.assertEqual(text, page.script)

    def test_a_block_of_tessera_by_keys_and_by_its_mark(self):
        text = SCENE + BLOCK
        first, last = len(SCENE.split("\n")), len(text.split("\n")) - 1
        page = self.fold("scene.tessera", text, first)
        self.assert_folded(page, text, first, last)
        page.press("Ctrl-Shift-]")
        self.assertEqual(text.split("\n"), self.lines(page))
        page.click_on('.cm-foldGutter [title="Fold line"]')
        wait_until(lambda: page.has(".cm-foldPlaceholder"), "it is folded")
        self.assert_folded(page, text, first, last)

    def test_a_block_of_crt(self):
        self.assert_folded(self.fold("scene.crt", CRT, 6), CRT, 6, 8)

    def test_blocks_in_the_classic_encoding(self):
        page = self.fold("scene.x3dv", CLASSIC, 5)
        self.assert_folded(page, CLASSIC, 5, 7)
        page.press("Ctrl-Alt-[")
        self.assert_folded(page, CLASSIC, 3, 10)


class Words(StudioPageTest):
    def watch(self, page):
        """From now on the words of the view are kept, each as it comes."""
        page.evaluate("""void (globalThis.said = [], new MutationObserver(() =>
            said.push(document.querySelector("#view-words").textContent)).observe(document.querySelector("#view-words"),
            {characterData: true, childList: true, subtree: true}))""")

    def test_that_an_edit_is_being_read_is_said(self):
        page = self.begin()
        self.watch(page)

        def is_said():
            # Whoever reads takes as long as the test wants; after a silence of 3 s the page takes the connection for lost.
            self.running.process.send_signal(signal.SIGSTOP)
            try:
                self.write_at(page, 5, " # slow")
                for _ in range(60):
                    if "reading" in page.evaluate("said"):
                        self.assertTrue(page.state["picture"]["final"], "the picture stays")
                        return True
                    time.sleep(.05)
                return False
            finally:
                self.running.process.send_signal(signal.SIGCONT)
        wait_until(is_said, "it is said")
        wait_until(lambda: page.has("#view-words", "done"), "it is read")
        before = page.state
        self.write_at(page, 5, "\nnodes { shape { sphere { radius: ")
        self.until(page, lambda state: state["picture"]["stale"], "it is wrong, which is read too")
        page.type("0.5 } } }")
        self.until_final(page, before)
        wait_until(lambda: page.has("#view-words", "done"), "it is read")


class Layouts(StudioPageTest):
    def test_what_is_said_beside_the_keys_does_not_lay_out_the_text(self):
        """Else the browser walks through all of the editor's text with each word that changes."""
        page = self.begin()
        page.click_on(".cm-scroller")
        for selector, change in ((".view-words > span", "each.firstChild.data = 'refining, 3 samples, N %'"),
                                 (".job-words", "each.firstChild.data = 'refining, 3 samples, N %, 10 of 30 tiles'"),
                                 (".progress i", "each.style.transform = 'scaleX(.N)'"),
                                 (".tree-rows .row .name", "each.textContent = 'another N'")):
            changes = itertools.count(10)

            def is_apart(selector=selector, change=change, changes=changes):
                roots = page.layouts(f"(() => {{ const each = document.querySelector({selector!r}); "
                                     f"{change.replace('N', str(next(changes)))}; }})()")
                return (roots or "progress" in selector) and "#document" not in roots
            wait_until(is_apart, f"{selector} is laid out apart, where nothing else changes meanwhile")


if __name__ == "__main__":
    unittest.main()
