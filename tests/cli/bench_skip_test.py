#!/usr/bin/env python3
"""tessera bench skip: what it writes, and what it says of a wrong command line."""
import json
import unittest

from tessera_process import TesseraTest


class BenchSkip(TesseraTest):
    def test_every_skip_keeps_its_bound_and_is_counted(self):
        run = self.run_program("bench", "skip", "--quick", "--repeats", "1", "--json", "s.json")
        self.assertEqual(0, run.code, run.err)
        rows = json.loads((self.folder / "s.json").read_text())["rows"]
        self.assertGreaterEqual(len(rows), 16)
        for row in rows:
            self.assertTrue(row["within"], row)
            self.assertTrue(row["same_bits"] or row["bound"] != "bits", row)
            self.assertTrue(0 < row["skipped"] <= row["of"], row)
            self.assertGreater(row["seconds_off"], 0)
            self.assertIn(row["skip"], run.out)

    def test_takes_names(self):
        run = self.run_program("bench", "skip", "--quick", "--repeats", "1", "dark-lights",
                               "small-trees", "--json", "s.json")
        self.assertEqual(0, run.code, run.err)
        rows = json.loads((self.folder / "s.json").read_text())["rows"]
        self.assertEqual({"small-trees", "dark-lights"}, {row["skip"] for row in rows})
        run = self.run_program("bench", "skip", "dark-light")
        self.assertEqual(2, run.code)
        self.assertIn("did you mean 'dark-lights'?", run.err)


if __name__ == "__main__":
    unittest.main()
