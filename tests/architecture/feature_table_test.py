#!/usr/bin/env python3
"""docs/notes/classic_features.md and docs/notes/features.md name tests and samples that exist, samples
have what their rows name, and every sample is in the gallery."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).parents[2]
SAMPLES = ROOT / "scenes/samples"
NO_SCENES = (".mtl", ".png", ".py")  # as in golden_test.py


def rows(page):
    """Its tables' rows: feature, where it is said, tests, samples; without their heads."""
    for row in re.findall(r"^\| (?!feature|---)(.*) \|$", (ROOT / "docs" / page).read_text(), re.MULTILINE):
        yield row, re.split(r"\s*\|\s*", row)


CLASSIC, OTHERS = "notes/classic_features.md", "notes/features.md"
PAGES = [row for page in (CLASSIC, OTHERS) for row in rows(page)]


def quoted(cell):
    return re.findall(r"`([^`]+)`", cell)


def samples_of(cell):
    """The files that it names; a note in brackets may follow each."""
    return re.findall(r"`(\w+\.(?:tessera|crt|x3dv?|obj|ply|stl|glb))`", cell)


def tests_of_the_tree():
    names = set()
    for path in (ROOT / "tests").rglob("*.cpp"):
        found = re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", path.read_text(), re.MULTILINE)
        names.update(f"{suite}.{name}" for suite, name in found)
    for path in (ROOT / "tests/python").glob("test_*.py"):
        names.update(f"{path.stem}::{name}" for name in re.findall(r"^def (test_\w+)", path.read_text(), re.M))
    for path in (ROOT / "tests/cli").glob("*_test.py"):
        found = re.findall(r"^(?:class|    def) (\w+)", path.read_text(), re.M)
        names.update(f"{path.stem}::{name}" for name in found)
    for path in (ROOT / "studio/page/test").glob("*.test.ts"):
        names.add(f"page::{path.name.partition('.')[0]}")
    return names


class FeatureTable(unittest.TestCase):
    def test_every_test_named_exists(self):
        known = tests_of_the_tree()
        self.assertGreater(len(PAGES), 150)
        for row, cells in PAGES:
            self.assertEqual(len(cells), 4, row)
            named = quoted(cells[2])
            self.assertTrue(named, row)
            suite = ""
            for name in named:
                if name.endswith(".py"):
                    self.assertTrue((ROOT / "tests/cli" / name).exists(), name)
                    continue
                whole = re.match(r"\w+(\.|::)", name)
                if whole:
                    suite = whole.group()
                else:  # the suite goes without saying after the first of a row
                    name = f"{suite}{name}"
                pattern = re.compile(re.escape(name).replace(r"\*", ".*"))
                self.assertTrue(any(pattern.fullmatch(test) for test in known), name)

    def test_every_sample_exists_or_is_said_to_be_none(self):
        for row, cells in PAGES:
            self.assertTrue(samples_of(cells[3]) or cells[3] in ("–", "any"), row)
            for name in samples_of(cells[3]):
                self.assertTrue((SAMPLES / name).exists(), row)

    def test_samples_have_the_words_of_their_rows(self):
        """Of the scene description where all of a row's samples are written in it; of X3D and CRT always."""
        for row, cells in rows(CLASSIC):
            samples = samples_of(cells[3])
            if samples and all(name.endswith(".tessera") for name in samples):
                self.check_words(row, samples, [w.split(".")[-1] for w in quoted(cells[1])])
        for row, cells in rows(OTHERS):
            if samples_of(cells[3]):
                self.check_words(row, samples_of(cells[3]), quoted(cells[1]))

    def check_words(self, row, samples, words):
        text = "\n".join((SAMPLES / name).read_text() for name in samples)
        for word in words:
            if re.fullmatch(r"\w+", word):
                self.assertRegex(text, rf"\b{word}\b", row)

    def test_every_sample_is_in_the_gallery_and_a_golden_picture(self):
        gallery = (ROOT / "docs/gallery.md").read_text()
        golden = (ROOT / "tests/cli/golden.json").read_text()
        for path in SAMPLES.iterdir():
            if path.suffix not in NO_SCENES:
                self.assertIn(f"tessera render scenes/samples/{path.name}", gallery)
                self.assertIn(f'"{path.name}"', golden)
        for picture in re.findall(r"\]\((images/[\w.]+)\)", gallery):
            self.assertTrue((ROOT / "docs" / picture).exists(), picture)


if __name__ == "__main__":
    unittest.main()
