#!/usr/bin/env python3
"""Pictures without their background: what is over it, in files, however the frame is cut."""
import struct
import unittest

import scenes
from exr import read_exr
from png import chunks, unfiltered
from service_test import ServiceTest

OPTION = "--transparent-background"
SIZE = ["--size", "70x45"]
FEW = ["--spp", 8]
SOLID = (.25, .5, 1)


def solid_scene():
    before = scenes.glass_scene()
    at = before.index("background {")
    return (before[:at] + "background { solid { r: .25 g: .5 b: 1 } }" +
            before[before.index("\n", at):])


def read_rgba(path):
    """Rows of pixels from the top, each the four numbers of 8 bits that PNG has."""
    import zlib
    parts = dict(chunks(path.read_bytes()))
    width, height, depth, kind = struct.unpack_from(">IIBB", parts[b"IHDR"])
    assert (depth, kind) == (8, 6), "no RGBA of 8 bits"
    packed = b"".join(body for name, body in chunks(path.read_bytes()) if name == b"IDAT")
    pixels = unfiltered(zlib.decompress(packed), 4 * width, 4)
    return [tuple(pixels[i:i + 4]) for i in range(0, len(pixels), 4)]


def linear(byte):
    code = byte / 255
    return code / 12.92 if code <= .04045 else ((code + .055) / 1.055) ** 2.4


class TransparentBackground(ServiceTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", solid_scene())

    def render(self, *options, name="a.exr"):
        samples = [] if "--spp" in options else FEW
        result = self.run_program("render", self.scene, "-o", name, "--quiet", *SIZE, *samples, *options)
        self.assertEqual(0, result.code, result.err)
        return self.folder / name

    def channels(self, *options, name="a.exr"):
        return read_exr(self.render(*options, name=name))[1]

    def bytes_of(self, *options, name="a.exr"):
        return {c: v.tobytes() for c, v in self.channels(*options, name=name).items()}

    def test_over_the_background_it_is_the_picture_with_that(self):
        for options in ([], ["--integrator", "path"], ["--filter", "mitchell"],
                        ["--spp", 64, "--target-error", ".02"]):
            options += ["--workers", 0]
            whole, found = self.channels(*options), self.channels(*options, OPTION)
            self.assertEqual({"R", "G", "B", "A"}, set(found))
            alphas = found["A"]
            self.assertTrue(any(0 < alpha < 1 for alpha in alphas), options)
            self.assertIn(0, alphas)
            self.assertIn(1, alphas)
            for channel, behind in zip("RGB", SOLID):
                for with_it, color, alpha in zip(whole[channel], found[channel], alphas):
                    self.assertAlmostEqual(with_it, color + (1 - alpha) * behind, delta=1e-5)
                    if alpha == 0:
                        self.assertEqual(0, color)

    def test_png_has_colours_that_alpha_is_the_share_of(self):
        exr = self.channels("--workers", 0, OPTION)
        pixels = read_rgba(self.render("--workers", 0, OPTION, name="a.png"))
        for i, pixel in enumerate(pixels):
            alpha = exr["A"][i]
            self.assertAlmostEqual(255 * alpha, pixel[3], delta=.51)
            if pixel[3] == 0:
                self.assertEqual((0, 0, 0), pixel[:3]) if alpha == 0 else None
                continue
            for channel, byte in zip("RGB", pixel):
                light = min(max(exr[channel][i] / alpha, 0), 1)
                self.assertAlmostEqual(light, linear(byte), delta=.006)

    def test_the_same_bits_however_it_is_cut_and_whoever_traces(self):
        reference = self.bytes_of("--workers", 0, "--threads", 1, "--tile", 64, OPTION)
        for workers, threads, tile in ((0, 2, 8), (1, 1, 5), (3, 2, 16)):
            self.assertEqual(reference, self.bytes_of("--workers", workers, "--threads", threads,
                                                      "--tile", tile, OPTION))
        crop = self.channels("--workers", 0, "--crop", "20,10,50,30", OPTION)
        whole = self.channels("--workers", 0, OPTION)
        for channel, values in crop.items():
            self.assertEqual([whole[channel][70 * y + x] for y in range(10, 30) for x in range(20, 50)],
                             list(values))
        service, worker = self.serve(), self.worker()
        self.assertEqual(reference, self.bytes_of("--connect", self.endpoint, OPTION))
        job = int(self.ask("submit", self.scene, *SIZE, *FEW, OPTION))
        self.ask("fetch", job, "--wait", "-o", "b.exr", "-o", "b.png")
        self.assertEqual(reference, {c: v.tobytes() for c, v in read_exr(self.folder / "b.exr")[1].items()})
        self.assertEqual(self.render("--workers", 0, OPTION, name="c.png").read_bytes(),
                         (self.folder / "b.png").read_bytes())
        self.assert_error(self.run_program("fetch", job, "-o", "b.jpg", "--connect", self.endpoint), 2,
                          OPTION, "b.jpg", ".png")
        self.stop(service, worker)

    def test_beside_aovs_and_the_denoiser(self):
        plain = self.bytes_of("--workers", 0, OPTION)
        beside = self.bytes_of("--workers", 0, OPTION, "--aovs", "depth,samples")
        self.assertEqual({"R", "G", "B", "A", "Z", "samples"}, set(beside))
        self.assertEqual(plain, {channel: beside[channel] for channel in plain})
        denoised = self.bytes_of("--workers", 0, OPTION, "--denoise")
        self.assertEqual(plain["A"], denoised["A"])

    def test_an_animation_keeps_it(self):
        self.scene = self.write("scene.tessera", scenes.MOVING)
        parts = list(chunks(self.render("--frames", "0-2", OPTION, name="a.apng").read_bytes()))
        self.assertEqual(6, dict(parts)[b"IHDR"][9])
        self.assertEqual(3, sum(name == b"fcTL" for name, _ in parts))
        # Each frame takes the place of the one before: neither is blended.
        self.assertEqual({b"\0\0"}, {body[-2:] for name, body in parts if name == b"fcTL"})

    def test_what_holds_no_alpha_is_refused(self):
        for name in ("a.jpg", "a.ppm", "a.gif", "a.hdr", "a.bmp"):
            result = self.run_program("render", self.scene, OPTION, "-o", name)
            self.assert_error(result, 2, OPTION, name, "no alpha", ".png, .apng, .exr")
        self.assert_error(self.run_program("render", self.scene, OPTION, "--integrator", "normals"), 2,
                          OPTION, "is for light", "normals")
        for name in ("a.tif", "a.tga", "a.webp"):
            self.render(OPTION, name=name)


if __name__ == "__main__":
    unittest.main()
