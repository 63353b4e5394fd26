#!/usr/bin/env python3
"""Every sample scene has the bits that golden.json holds. Pixels that change on purpose change the
numerics id with them (proto/wire/version.h), since workers of both kinds may meet in one farm;
`golden_test.py --update` then writes the file anew."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from tessera_process import PROGRAM, SLOWER, TesseraTest

ROOT = pathlib.Path(__file__).parents[2]
GOLDEN = pathlib.Path(__file__).with_name("golden.json")
NO_SCENES = (".mtl", ".png", ".py")
SAMPLES = sorted(p.name for p in (ROOT / "scenes/samples").iterdir() if p.suffix not in NO_SCENES)


def numerics_id():
    text = (ROOT / "proto/wire/version.h").read_text()
    return re.search(r'kNumericsId\[\] = "([^"]+)"', text).group(1)


def pixels(name, folder, **environment):
    stats = pathlib.Path(folder) / "stats.json"
    subprocess.run(
        [PROGRAM, "render", ROOT / "scenes/samples" / name, "--size", "48x27", "--spp", "4",
         "--workers", "0", "--quiet", "-o", pathlib.Path(folder) / "picture.pfm", "--stats", stats],
        check=True, timeout=120 * SLOWER, env={**os.environ, **environment})
    return json.loads(stats.read_text())["pixels_sha256"]


class Golden(TesseraTest):
    def test_every_sample_has_its_bits(self):
        golden = json.loads(GOLDEN.read_text())
        self.assertEqual(golden["numerics_id"], numerics_id())
        self.assertEqual(sorted(golden["pixels_sha256"]), SAMPLES)
        for name in SAMPLES:
            with self.subTest(name):
                self.assertEqual(golden["pixels_sha256"][name], pixels(name, self.folder))

    def test_every_instruction_set_gives_the_same_bits(self):
        """As far as this machine has them; TESSERA_SIMD chooses one."""
        os.environ["TESSERA_SIMD"] = "none"
        self.addCleanup(os.environ.pop, "TESSERA_SIMD", None)
        refused = self.run_program("render", ROOT / "scenes/samples/pawn.obj", "--size", "32x32",
                                   "--workers", "0", "-o", "picture.pfm")
        del os.environ["TESSERA_SIMD"]
        self.assertIn("TESSERA_SIMD: 'none'; expected one of ", refused.err)
        sets = re.search(r"'none'; expected one of ([\w, ]+)", refused.err).group(1).split(", ")
        print("instruction sets:", *sets, flush=True)
        self.assertGreaterEqual(len(sets), 2, "the baseline and something better")
        golden = json.loads(GOLDEN.read_text())["pixels_sha256"]
        for simd in sets:
            for name in SAMPLES:
                with self.subTest(simd=simd, name=name):
                    self.assertEqual(golden[name], pixels(name, self.folder, TESSERA_SIMD=simd))


if __name__ == "__main__" and "--update" in sys.argv:
    with tempfile.TemporaryDirectory() as scratch:
        digests = {name: pixels(name, scratch) for name in SAMPLES}
    GOLDEN.write_text(json.dumps(
        {"numerics_id": numerics_id(), "pixels_sha256": digests}, indent=2) + "\n")
elif __name__ == "__main__":
    unittest.main()
