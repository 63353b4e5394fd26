#!/usr/bin/env python3
"""A build with -DTESSERA_STUDIO=OFF runs no node, and embeds the page that says what is lacking."""
import pathlib
import subprocess
import unittest

from tessera_process import TesseraTest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class StudioOff(TesseraTest):
    def run_cmake(self, *arguments):
        """What it said; it must succeed."""
        done = subprocess.run(["cmake", *map(str, arguments)], cwd=ROOT, env=self.environment(), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        self.assertEqual(0, done.returncode, done.stdout[-5000:])
        return done.stdout

    def test_it_is_built_without_node_and_says_that_it_has_no_page(self):
        build = self.folder / "build"
        told = self.run_cmake("--preset", "release", "-B", build, "-DTESSERA_STUDIO=OFF", "-DTESSERA_TESTS=ON")
        self.assertIn("tessera studio is built without its page, as TESSERA_STUDIO is OFF", told)
        commands = self.run_cmake("--build", build, "--", "-t", "commands")
        self.assertIn("studio/page/absent -DFUNCTION=find_studio_page_file", commands)
        for tool in ("npm", "node ", "nodejs", "node_modules"):
            self.assertNotIn(tool, commands)


if __name__ == "__main__":
    unittest.main()
