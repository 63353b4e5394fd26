#!/usr/bin/env python3
"""tessera bench skip: what it writes, and what it says of a wrong command line."""
import json
import unittest

from tessera_process import TesseraTest


class BenchSkip(TesseraTest):
    def test_every_kind_keeps_the_bits(self):
        run = self.run_program("bench", "skip", "--quick", "--repeats", "1", "--json", "s.json")
        self.assertEqual(0, run.code, run.err)
        rows = json.loads((self.folder / "s.json").read_text())["rows"]
        self.assertGreaterEqual(len(rows), 10)
        for row in rows:
            self.assertTrue(row["same_bits"], row)
            self.assertGreater(row["seconds_with"], 0)
            self.assertIn(row["unneeded"], run.out)

    def test_takes_names(self):
        run = self.run_program("bench", "skip", "--quick", "--repeats", "1", "black-lights", "textures", "--json", "s.json")
        self.assertEqual(0, run.code, run.err)
        rows = json.loads((self.folder / "s.json").read_text())["rows"]
        self.assertEqual({"textures", "black-lights"}, {row["unneeded"] for row in rows})
        run = self.run_program("bench", "skip", "black-light")
        self.assertEqual(2, run.code)
        self.assertIn("did you mean 'black-lights'?", run.err)


if __name__ == "__main__":
    unittest.main()
