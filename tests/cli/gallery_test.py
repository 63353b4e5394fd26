#!/usr/bin/env python3
"""docs/gallery.md: each picture says of itself what its command's would today."""
import pathlib
import re
import struct
import unittest

from tessera_process import TesseraTest

ROOT = pathlib.Path(__file__).parents[2]
DOCS = ROOT / "docs"


def shown():
    """(options of `tessera render`, picture) of each scene."""
    page = (DOCS / "gallery.md").read_text()
    return re.findall(r"```sh\ntessera render ([^\n]*)\n```\n\n!\[[^\]]*\]\((images/\S+\.png)\)", page)


def size_and_words(path):
    """Of a PNG: width and height, and the chunks of text."""
    data, at, size, words = path.read_bytes(), 8, None, []
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            size = "%dx%d" % struct.unpack_from(">II", body)
        elif kind in (b"tEXt", b"iTXt", b"zTXt"):
            words.append((kind, body))
        at += 12 + length
    return size, words


class Gallery(TesseraTest):
    def test_pictures_tell_what_their_commands_would(self):
        pictures = {f"images/{path.name}" for path in (DOCS / "images").glob("*.png")}
        self.assertEqual({each for each in pictures if not each.startswith("images/studio")} - {"images/page.png"}, {picture for _, picture in shown()})
        for options, picture in shown():
            with self.subTest(picture):
                scene, *options = options.split()
                size = "960x540"
                if "--size" in options:
                    at = options.index("--size")
                    _, size = options[at:at + 2]
                    del options[at:at + 2]
                # The words are the same for all sizes.
                result = self.run_program("render", ROOT / scene, *options, "--size", "2x2",
                                          "--workers", 0, "--quiet", "-o", "small.png")
                self.assertEqual(0, result.code, result.err)
                words = size_and_words(self.folder / "small.png")[1]
                self.assertGreater(len(words), 3)
                self.assertEqual((size, words), size_and_words(DOCS / picture))


if __name__ == "__main__":
    unittest.main()
