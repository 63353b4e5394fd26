#!/usr/bin/env python3
"""tessera bench error: what it writes, and what it says of a wrong command line."""
import csv
import json
import unittest
import xml.etree.ElementTree

from tessera_process import TesseraTest

KEYS = {"scene", "method", "samples", "seconds", "rmse", "bias"}
EDGE = ("bench", "error", "edge", "--size", "16x16", "--samples", "1-4", "--seeds", "3", "--cache",
        "references")


class BenchError(TesseraTest):
    def test_writes_rows_curves_and_plots(self):
        (self.folder / "plots").mkdir()
        run = self.run_program(*EDGE, "--methods", "owen", "independent+tent", "--threads", "2",
                               "--json", "e.json", "--csv", "e.csv", "--svg", "plots")
        self.assertEqual(0, run.code, run.err)
        found = json.loads((self.folder / "e.json").read_text())
        self.assertEqual(6, len(found["rows"]))
        for row in found["rows"]:
            self.assertLessEqual(KEYS, row.keys())
            self.assertEqual("edge", row["scene"])
            self.assertGreater(row["rmse"], 0)
        self.assertEqual([1, 2, 4], [row["samples"] for row in found["rows"][:3]])
        self.assertEqual({"owen", "independent+tent"}, {row["method"] for row in found["rows"]})
        with open(self.folder / "e.csv") as file:
            self.assertEqual(6, len(list(csv.DictReader(file))))
        for name in ("edge.svg", "edge-efficiency.svg"):
            root = xml.etree.ElementTree.parse(self.folder / "plots" / name).getroot()
            self.assertTrue(root.tag.endswith("svg"))
        self.assertIn("| edge | owen |", run.out)
        self.assertTrue(list((self.folder / "references").iterdir()), "the tent's are rendered")

    def test_other_pictures_and_files(self):
        self.assertEqual(0, self.run_program("bench", "error", "edge", "--samples", "1", "--seeds", "2",
                                             "--cache", "c").code)
        self.write("s.tessera", "nodes { shape { sphere { radius: 2 } } } "
                   "background { solid { r: .2 g: .5 b: .7 } } settings { width: 16 height: 16 }")
        done = self.run_program("render", "s.tessera", "--spp", "64", "-o", "s.exr")
        self.assertEqual(0, done.code, done.err)
        run = self.run_program("bench", "error", "s.tessera", "--samples", "1-2", "--seeds", "2", "--cache",
                               "c", "--reference", "s.exr", "--peer", "twin:1.5:64:s.exr", "--peer",
                               "twin:3:128:s.exr", "--json", "s.json", "--svg", ".")
        self.assertEqual(0, run.code, run.err)
        plot = (self.folder / "s-peers.svg").read_text()
        self.assertEqual(1, plot.count(">twin<"), "one name for both of its marks")
        peer = json.loads((self.folder / "s.json").read_text())["peers"][0]
        self.run_program("render", "s.tessera", "--spp", "1", "-o", "one.exr")
        told = self.run_program("compare", "one.exr", "s.exr", "--metrics").out
        for name in ("relMSE", "SMAPE", "FLIP", "SSIM"):
            self.assertRegex(told, rf"{name} +0\.\d*[1-9]")
        same = self.run_program("compare", "s.exr", "s.exr", "--metrics").out
        self.assertRegex(same, r"FLIP +0\nSSIM +1\n")
        for name in ("one", "s"):
            (self.folder / f"{name}.exr").rename(self.folder / f"{name}.EXR")
        self.assertEqual(told, self.run_program("compare", "one.EXR", "s.EXR", "--metrics").out)
        self.assertEqual(("twin", 1.5, 64, 0), tuple(peer[k] for k in ("method", "seconds", "samples", "rmse")))

    def test_tells_why_a_curve_ends(self):
        self.run_program("convert", "error:edge", "edge.tessera")
        for seed in "1", "2":
            done = self.run_program("render", "edge.tessera", "--size", "16x16", "--spp", "4", "--seed",
                                    seed, "-o", f"{seed}.exr")
            self.assertEqual(0, done.code, done.err)
        noisy = self.run_program(*EDGE, "--reference", "1.exr", "--reference", "2.exr")
        self.assertEqual(0, noisy.code, noisy.err)
        self.assertIn("edge: one straight edge and nothing else (16x16)\nreference: two given", noisy.out)
        self.assertRegex(noisy.out, "owen +ends here: its error comes within 5 times the reference's own, 0")
        exact = self.run_program(*EDGE)
        self.assertEqual(0, exact.code, exact.err)
        self.assertIn("reference: closed form", exact.out)
        self.assertNotIn("ends here", exact.out)

    def test_its_scenes_can_be_written(self):
        done = self.run_program("convert", "error:edge", "edge.tessera")
        self.assertEqual(0, done.code, done.err)
        done = self.run_program("render", "edge.tessera", "--spp", "2", "-o", "edge.exr")
        self.assertEqual(0, done.code, done.err)
        wrong = self.run_program("convert", "error:glosy", "x.tessera")
        self.assertEqual(2, wrong.code)
        self.assertIn("did you mean 'glossy'?", wrong.err)

    def test_says_what_is_wrong(self):
        for arguments, message in (
                (("edg",), "did you mean 'edge'?"),
                (("edge", "--methods", "owne"), "did you mean 'owen'?"),
                (("edge", "--samples", "1-100"), "expected powers of two"),
                (("edge", "--samples", "8-4"), "--samples"),
                (("edge", "--svg", "/dev/null/missing"), "is no folder"),
                (("edge", "--peer", "x:1:2"), "expected NAME:SECONDS:SAMPLES:FILE"),
                (("edge", "--peer", "x:0:2:y.exr"), "above 0"),
                (("edge", "--peer", "x:1:2:nosuch.exr"), "--peer: nosuch.exr: no such file"),
                (("edge", "--reference", "nosuch.exr"), "--reference: nosuch.exr: no such file"),
                (("--reference", "a.exr"), "expected one SCENE"),
                (("edge", "--seeds", "1"), "--seeds")):
            with self.subTest(arguments):
                run = self.run_program("bench", "error", *arguments)
                self.assertEqual(2, run.code, run.err)
                self.assertIn(message, run.err)


if __name__ == "__main__":
    unittest.main()
