#!/usr/bin/env python3
"""docs/local_illumination.md names tests and samples that exist, and every sample is in the gallery."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).parents[2]
TABLE = (ROOT / "docs/local_illumination.md").read_text()


def tests_of_the_tree():
    names = set()
    for path in (ROOT / "tests").rglob("*.cpp"):
        found = re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", path.read_text(), re.MULTILINE)
        names.update(f"{suite}.{name}" for suite, name in found)
    return names


class FeatureTable(unittest.TestCase):
    def test_every_test_named_exists(self):
        known = tests_of_the_tree()
        for row in re.findall(r"^\| (?!feature|---)(.*) \|$", TABLE, re.MULTILINE):
            cells = re.split(r"\s*\|\s*", row)
            self.assertEqual(len(cells), 4, row)
            named = re.findall(r"`([^`]+)`", cells[2])
            self.assertTrue(named, row)
            suite = ""
            for name in named:
                if name.endswith(".py"):
                    self.assertTrue((ROOT / "tests/cli" / name).exists(), name)
                    continue
                if "." in name:
                    suite = name.split(".")[0]
                else:  # the suite goes without saying after the first of a row
                    name = f"{suite}.{name}"
                pattern = re.compile(re.escape(name).replace(r"\*", ".*"))
                self.assertTrue(any(pattern.fullmatch(test) for test in known), name)

    def test_every_sample_exists_and_is_in_the_gallery(self):
        samples = ROOT / "scenes/samples"
        for name in re.findall(r"`(\w+\.(?:tessera|crt|x3d|obj))`", TABLE):
            if name not in ("x.obj", "x.x3d"):
                self.assertTrue((samples / name).exists(), name)
        gallery = (ROOT / "docs/gallery.md").read_text()
        for path in samples.iterdir():
            if path.suffix in (".tessera", ".crt"):
                self.assertIn(path.name, gallery)


if __name__ == "__main__":
    unittest.main()
