#!/usr/bin/env python3
"""tessera bench studio: what it writes, and that it leaves nothing behind."""
import json
import pathlib
import unittest

import browser
from tessera_process import PATIENCE, TesseraTest, is_worker, marked_processes, wait_until

SAMPLES = pathlib.Path(__file__).resolve().parents[2] / "scenes" / "samples"


class BenchStudio(TesseraTest):
    def test_all_is_measured_once(self):
        with_browser = ["--browser", browser.PROGRAM] if browser.PROGRAM else []
        process = self.start("bench", "studio", SAMPLES, "--quick", *with_browser, "--json", "s.json")
        out, err = process.communicate(timeout=10 * PATIENCE)
        self.assertEqual(0, process.returncode, err)
        rows = {row["measure"]: row for row in json.loads((self.folder / "s.json").read_text())["rows"]}
        self.assertEqual(11 if with_browser else 10, err.count("measuring: "), err)
        for name in ("key to first pixels, all scenes (p50)", "key to first pixels, knot.tessera", "of that, trace (p50)",
                     "key in a .mtl beside 20000 triangles (p95)", "orbit of mosaic.tessera, pictures",
                     "stop, until no worker traces (p95)", "pick (p95)", "property drag, pictures",
                     "reconnect, until the text is settled (p95)", "full picture / tessera render",
                     "memory after 180 edits and 18 pictures of 4 Mpx / before", "idle, of a core",
                     *(["page, key to first pixels (p50)", "page, longest task while typing"] if with_browser else [])):
            self.assertIn(name, rows)
            self.assertIn(name, out)
            row = rows[name]
            self.assertGreaterEqual(row["value"], 0)
            missed = row["value"] > row.get("at_most", float("inf")) or row["value"] < row.get("at_least", 0)
            self.assertEqual(missed, row["misses"], row)
        self.assertEqual(0, rows["idle, messages but metrics"]["value"])
        self.assertEqual([], list(self.temporary.iterdir()))

    def test_what_ends_it_ends_its_processes(self):
        process = self.start("bench", "studio", SAMPLES, "--quick")
        while (line := process.stderr.readline()) != "measuring: orbits\n":
            self.assertTrue(line, "it ended")
        self.assertTrue(any(map(is_worker, marked_processes(self.mark))))
        process.terminate()
        _, err = process.communicate(timeout=PATIENCE)
        self.assertEqual(4, process.returncode, err)
        wait_until(lambda: marked_processes(self.mark) == [], "its studio and workers are gone")
        self.assertEqual([], list(self.temporary.iterdir()))

    def test_another_folder_is_told(self):
        run = self.run_program("bench", "studio", self.folder)
        self.assertEqual(2, run.code)
        self.assertIn("mosaic.tessera", run.err)


if __name__ == "__main__":
    unittest.main()
