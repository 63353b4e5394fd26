#!/usr/bin/env python3
"""Which picture files are read, and that none leads to a file outside of the scene's folder."""
import ctypes
import os
import shutil
import struct
import subprocess
import unittest
import zlib

from tessera_process import TesseraTest, nightly

WIDTH, HEIGHT = 16, 12
SECRET = (200, 30, 90)  # the colour of the pictures that no scene may show
SCENE = """textures { name: "t" image { file: "%s" } }
background { panorama { texture: "t" } }
settings { width: 8 height: 8 sampling { samples_per_pixel: 1 } }
cameras { }
"""
MANIFEST = """<?xml version="1.0"?>
<MPD xmlns="urn:mpeg:dash:schema:mpd:2011" profiles="urn:mpeg:dash:profile:isoff-on-demand:2011"
 type="static" mediaPresentationDuration="PT1S" minBufferTime="PT1S"><Period>
<AdaptationSet contentType="video" mimeType="video/mp4">
<Representation id="1" bandwidth="1000" width="16" height="12" codecs="png">
<BaseURL>%s</BaseURL></Representation></AdaptationSet></Period></MPD>
"""


def png(width, height, color):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))
    rows = (b"\0" + bytes(color) * width) * height
    return (b"\x89PNG\r\n\x1a\n"
            + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def atom(kind, *parts):
    body = b"".join(parts)
    return struct.pack(">I4s", 8 + len(body), kind) + body


def movie(width, height, color, frames=10):
    """A QuickTime movie of one colour, whose frames are PNG."""
    picture = png(width, height, color)
    length = 100 * frames
    matrix = struct.pack(">9I", 0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000)
    none = bytes(4)  # version and flags
    kind = atom(b"ftyp", b"qt  ", bytes(4), b"qt  ")

    def header(at):
        entry = atom(b"png ", bytes(6), struct.pack(">H", 1), bytes(16),
                     struct.pack(">HHIIIH", width, height, 0x480000, 0x480000, 0, 1), bytes(32),
                     struct.pack(">Hh", 24, -1))
        table = atom(b"stbl", atom(b"stsd", none, struct.pack(">I", 1), entry),
                     atom(b"stts", none, struct.pack(">3I", 1, frames, 100)),
                     atom(b"stsc", none, struct.pack(">4I", 1, 1, frames, 1)),
                     atom(b"stsz", none, struct.pack(">2I", len(picture), frames)),
                     atom(b"stco", none, struct.pack(">2I", 1, at)))
        media = atom(b"minf", atom(b"vmhd", none, bytes(8)),
                     atom(b"dinf", atom(b"dref", none, struct.pack(">I", 1),
                                        atom(b"url ", b"\0\0\0\1"))), table)
        track = atom(b"trak",
                     atom(b"tkhd", b"\0\0\0\7", struct.pack(">5I", 0, 0, 1, 0, length), bytes(16),
                          matrix, struct.pack(">2I", width << 16, height << 16)),
                     atom(b"mdia",
                          atom(b"mdhd", none, struct.pack(">4IHH", 0, 0, 1000, length, 0, 0)),
                          atom(b"hdlr", none, b"mhlr", b"vide", bytes(13)), media))
        return atom(b"moov", atom(b"mvhd", none, struct.pack(">4I", 0, 0, 1000, length),
                                  b"\0\1\0\0\1\0", bytes(10), matrix, bytes(24),
                                  struct.pack(">I", 2)), track)

    data_at = len(kind) + len(header(0)) + 8
    return kind + header(data_at) + atom(b"mdat", picture * frames)


def dds():
    """Uncompressed, blue, green, red."""
    return (b"DDS " + struct.pack("<7I", 124, 0x100f, HEIGHT, WIDTH, 3 * WIDTH, 0, 0) + bytes(44)
            + struct.pack("<8I", 32, 0x40, 0, 24, 0xff0000, 0xff00, 0xff, 0)
            + struct.pack("<5I", 0x1000, 0, 0, 0, 0) + bytes((90, 30, 200)) * (WIDTH * HEIGHT))


def psd():
    """Three channels of bytes, one after the other."""
    planes = b"".join(bytes([value]) * (WIDTH * HEIGHT) for value in SECRET)
    return (b"8BPS" + struct.pack(">H6xHIIHH", 1, 3, HEIGHT, WIDTH, 8, 3) + bytes(12) + bytes(2)
            + planes)


# Of the size and colour above, by OpenJPEG, without its comment.
JPEG_2000 = bytes.fromhex(
    "ff4fff51002f0000000000100000000c0000000000000000000000100000000c0000000000000000000307010107"
    "0101070101ff52000c00000001000104040001ff5c00074040484850ff90000a00000000004c0001ff93cfb44414"
    "005c8886ab000006120c09ce1212ff7fcfb440115054aef6b8400000006120a09bc241c7d4221150548886ab0000"
    "061212cddc8006120f808080ffd9")


def jp2():
    """The stream in boxes."""
    return (atom(b"jP  ", b"\r\n\x87\n") + atom(b"ftyp", b"jp2 ", bytes(4), b"jp2 ")
            + atom(b"jp2h", atom(b"ihdr", struct.pack(">2IH4B", HEIGHT, WIDTH, 3, 7, 7, 0, 0)),
                   atom(b"colr", b"\1\0\0", struct.pack(">I", 16)))
            + atom(b"jp2c", JPEG_2000))


LIBC = ctypes.CDLL(None, use_errno=True)


def kernel_has_landlock():
    LANDLOCK_CREATE_RULESET, VERSION = 444, 1
    return LIBC.syscall(LANDLOCK_CREATE_RULESET, None, 0, VERSION) > 0


class Watch:
    """Knows whether anybody opens a folder."""

    def __init__(self, folder):
        IN_OPEN = 0x20
        self.descriptor = LIBC.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        assert LIBC.inotify_add_watch(self.descriptor, bytes(folder), IN_OPEN) > 0

    def was_opened(self):
        try:
            return len(os.read(self.descriptor, 4096)) > 0
        except BlockingIOError:
            return False

    def close(self):
        os.close(self.descriptor)


class PictureFormats(TesseraTest):
    def setUp(self):
        super().setUp()
        (self.folder / "scene").mkdir()
        (self.folder / "private").mkdir()
        self.write("private/holiday.mp4", movie(WIDTH, HEIGHT, SECRET))

    looked_into = None

    def environment(self):
        if not self.looked_into:
            return super().environment()
        return {**super().environment(), "OIIO_LIBRARY_PATH": self.looked_into}

    def render(self, scene="scene/scene.tessera", options=("--quiet",)):
        (self.folder / "out.ppm").unlink(missing_ok=True)
        return self.run_program("render", scene, "--workers", "0", "--threads", "1", *options,
                                "--tone-map", "clamp", "--transfer", "srgb", "-o", "out.ppm")

    def test_a_manifest_leads_nowhere(self):
        outside = (self.folder / "private/holiday.mp4").resolve()
        for name in "floor.mov", "floor.mpd", "floor.png":
            for url in "../private/holiday.mp4", f"file://{outside}", str(outside):
                with self.subTest(name=name, url=url):
                    self.write(f"scene/{name}", MANIFEST % url)
                    self.write("scene/scene.tessera", SCENE % name)
                    self.assert_error(self.render(), 1, f"scene/{name}: is an XML document",
                                      "expected an image file (PNG, JPEG, ")
                    self.assertFalse((self.folder / "out.ppm").exists())

    def test_a_manifest_is_no_picture_of_other_formats_either(self):
        self.write("scene/floor.mov", MANIFEST % "../private/holiday.mp4")
        self.write("scene/scene.x3dv", '#X3D V3.3 utf8\nShape { appearance Appearance { texture '
                   'ImageTexture { url "floor.mov" } } geometry Box { } }\n')
        result = self.render("scene/scene.x3dv", options=["--size", "16x16"])
        self.assertEqual(0, result.code, result.err)
        self.assertRegex(result.err, "floor.mov.*: is an XML document")
        self.assertNotIn(bytes(SECRET), (self.folder / "out.ppm").read_bytes())

    @unittest.skipUnless(kernel_has_landlock(), "this kernel has no Landlock")
    def test_the_codec_opens_nothing_for_a_library_that_asks(self):
        """OpenImageIO looks into the folder of that variable as soon as it reads a picture."""
        self.write("a.png", png(WIDTH, HEIGHT, SECRET))
        subprocess.run(["oiiotool", self.folder / "a.png", "-o", self.folder / "scene/floor.tif"],
                       check=True)
        self.write("scene/scene.tessera", SCENE % "floor.tif")
        watch = Watch(self.folder / "private")
        self.addCleanup(watch.close)
        self.looked_into = str(self.folder / "private")
        subprocess.run(["oiiotool", "--info", self.folder / "scene/floor.tif"], check=True,
                       env=self.environment(), stdout=subprocess.DEVNULL)
        self.assertTrue(watch.was_opened())
        result = self.render()
        self.assertEqual(0, result.code, result.err)
        self.assertEqual(bytes(SECRET), (self.folder / "out.ppm").read_bytes()[-3:])
        self.assertFalse(watch.was_opened())

    def test_no_movie_is_read(self):
        self.write("scene/floor.png", movie(WIDTH, HEIGHT, SECRET))
        self.write("scene/scene.tessera", SCENE % "floor.png")
        self.assert_error(self.render(), 1, "scene/floor.png: is a movie")
        compared = self.run_program("compare", "scene/floor.png", "scene/floor.png")
        self.assert_error(compared, 2, "scene/floor.png: is a movie")

    @nightly
    def test_every_format_is_read_whatever_its_name(self):
        self.write("a.png", png(WIDTH, HEIGHT, SECRET))
        self.write("a.dds", dds())
        self.write("a.psd", psd())
        self.write("a.j2k", JPEG_2000)
        self.write("a.jp2", jp2())
        exact = "png gif bmp tif exr tga ppm dds psd sgi ico j2k jp2".split()
        near = "jpg hdr webp heic avif".split()
        self.write("scene/scene.tessera", SCENE % "texture.mov")
        for ending in exact + near:
            with self.subTest(ending=ending):
                file = self.folder / f"a.{ending}"
                if not file.exists():
                    # What holds floats is taken for linear.
                    linear = ending in ("exr", "hdr")
                    options = ["--colorconvert", "sRGB", "linear"] if linear else []
                    subprocess.run(["oiiotool", self.folder / "a.png", *options, "-o", file],
                                   check=True, stdout=subprocess.DEVNULL)
                shutil.copy(file, self.folder / "scene/texture.mov")
                result = self.render()
                self.assertEqual(0, result.code, result.err)
                pixel = (self.folder / "out.ppm").read_bytes()[-3:]
                for value, wanted in zip(pixel, SECRET):
                    self.assertAlmostEqual(wanted, value, delta=0 if ending in exact else 4)


if __name__ == "__main__":
    unittest.main()
