#!/usr/bin/env python3
"""What the samples of picture files are taken for: which channels are colour and coverage, and how their
numbers become linear light."""
import array
import json
import struct
import subprocess
import unittest

from stored_pictures import bmp, chunk, exr, exr_parts, pfm, png, pnm, sgi, targa, tiff
from tessera_process import TesseraTest

RGB = (188 / 255, 128 / 255, 64 / 255)
GREY = (128 / 255,)
ALPHA = (0.6,)
SCENE = """settings { width: %(width)d height: %(height)d integrator { kind: "whitted" } }
cameras { world_from_camera { steps { translate { z: 5 } } }
          orthographic { min_x: 0 max_x: %(span)d min_y: -.5 max_y: .5 } }
background { solid { r: %(behind)d g: %(behind)d b: %(behind)d } }
"""
QUAD = """textures { name: "%(i)d" image { file: "%(file)s" %(encoding)s } }
materials { name: "%(i)d" unlit { color { texture: "%(i)d" } } }
nodes { shape { materials: "%(i)d" rectangle { corner { x: %(i)d y: -.5 } edge_u { x: 1 } edge_v { y: 1 } } } }
"""


# 8 pixels by 4 of the codes 87, 46, 28 and 128, without loss.
WEBP = bytes.fromhex(
    "5249464618000000574542505650384c0c0000002f07c00010a84badca51c000")


def light(code):
    """IEC 61966-2-1."""
    return code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4


def stored(pixel, bits):
    """The values that so many bits hold."""
    most = 2 ** bits - 1
    return tuple(round(value * most) / most for value in pixel)


def lit(pixel):
    """Three channels of light, of one or three codes."""
    return [light(code) for code in (pixel * 3 if len(pixel) == 1 else pixel)]


def associated(pixel):
    """The numbers of a pixel with alpha multiplied into its colours."""
    return tuple(value * pixel[-1] for value in pixel[:-1]) + pixel[-1:]


class Row:
    """A file, and the colour and coverage that it holds."""

    def __init__(self, name, data, color, alpha=1.0, encoding="", near=2e-5):
        self.name, self.data, self.near = name, data, near
        self.color = list(color) * (3 if len(color) == 1 else 1)
        self.alpha, self.encoding = alpha, encoding

    def over(self, behind):
        return [value * self.alpha + behind * (1 - self.alpha) for value in self.color]


def integer_rows():
    for bits in 1, 2, 4, 8, 16:
        grey = stored(GREY, bits)
        yield Row(f"grey{bits}.png", png(grey, bits), lit(grey))
    for bits in 8, 16:
        rgb, grey, (alpha,) = stored(RGB, bits), stored(GREY, bits), stored(ALPHA, bits)
        for linear in False, True:
            encoding = "encoding: ENCODING_LINEAR" if linear else "encoding: ENCODING_SRGB" if bits == 16 else ""
            color, one = (rgb, grey) if linear else (lit(rgb), lit(grey))
            yield Row(f"rgb{bits}{linear}.png", png(rgb, bits), color, encoding=encoding)
            yield Row(f"rgba{bits}{linear}.png", png(rgb + (alpha,), bits), color, alpha, encoding)
            yield Row(f"ga{bits}{linear}.png", png(grey + (alpha,), bits), one, alpha, encoding)
    for bits in 1, 8, 10, 12, 16:
        near = 1e-4 if bits in (10, 12) else 2e-5
        rgb, grey, (alpha,) = stored(RGB, bits), stored(GREY, bits), stored(ALPHA, bits)
        yield Row(f"grey{bits}.tif", tiff(grey, bits), lit(grey), near=near)
        if bits == 1:
            continue
        yield Row(f"rgb{bits}.tif", tiff(rgb, bits), lit(rgb), near=near)
        yield Row(f"loose{bits}.tif", tiff(rgb + (alpha,), bits, 2), lit(rgb), alpha, near=near)
        yield Row(f"looseg{bits}.tif", tiff(grey + (alpha,), bits, 2), lit(grey), alpha, near=near)
        yield Row(f"other{bits}.tif", tiff(rgb + (alpha,), bits, 0), lit(rgb), near=near)
        for name, pixel in (("tied", rgb), ("tiedg", grey)):
            held = stored(associated(pixel + (alpha,)), bits)
            color = lit(tuple(value / held[-1] for value in held[:-1]))
            yield Row(f"{name}{bits}.tif", tiff(held, bits, 1), color, alpha, near=2 * near)
    for bits in 8, 16:
        rgb, grey, (alpha,) = stored(RGB, bits), stored(GREY, bits), stored(ALPHA, bits)
        yield Row(f"grey{bits}.sgi", sgi(grey, bits), lit(grey))
        yield Row(f"ga{bits}.sgi", sgi(grey + (alpha,), bits), lit(grey), alpha)
        yield Row(f"rgb{bits}.sgi", sgi(rgb, bits), lit(rgb))
        yield Row(f"rgba{bits}.sgi", sgi(rgb + (alpha,), bits), lit(rgb), alpha)
    rgb, (alpha,) = stored(RGB, 8), stored(ALPHA, 8)
    yield Row("grey.tga", targa(stored(GREY, 8)), lit(stored(GREY, 8)))
    yield Row("rgb.tga", targa(rgb), lit(rgb))
    yield Row("rgba.tga", targa(rgb + (alpha,)), lit(rgb), alpha)
    held = stored(associated(rgb + (alpha,)), 8)
    yield Row("tied.tga", targa(held, 4), lit(tuple(v / held[-1] for v in held[:-1])), alpha)
    for attributes in 0, 1, 2:
        yield Row(f"ignored{attributes}.tga", targa(rgb + (alpha,), attributes), lit(rgb))
    yield Row("old.tga", targa(rgb + (alpha,), None), lit(rgb), alpha)
    opaque = 0xff0000, 0xff00, 0xff, 0
    yield Row("nothing.bmp", bmp(rgb + (0,)), lit(rgb))
    yield Row("likely.bmp", bmp(rgb + (alpha,)), lit(rgb), alpha)
    yield Row("masked.bmp", bmp(rgb + (alpha,), (*opaque[:3], 0xff000000)), lit(rgb), alpha)
    yield Row("clear.bmp", bmp(rgb + (0,), (*opaque[:3], 0xff000000)), lit(rgb), 0)
    yield Row("opaque.bmp", bmp(rgb + (alpha,), opaque), lit(rgb))
    grey, other = stored(GREY, 8), stored((0.2, 0.3, 0.4), 8)
    for i in range(3):
        yield Row(f"grey_and{i}.tif", tiff(grey + other[:i + 1], 8, *[0] * (i + 1)), lit(grey))
        yield Row(f"grey_and{i}a.tif", tiff(grey + other[:i + 1] + (alpha,), 8, *[0] * (i + 1), 2), lit(grey),
                  alpha)
        yield Row(f"grey_a_and{i}.tif", tiff(grey + (alpha,) + other[:i + 1], 8, 2, *[0] * (i + 1)),
                  lit(grey), alpha)
    yield Row("rgb_and_a.tif", tiff(rgb + other[:1] + (alpha,), 8, 0, 2), lit(rgb), alpha)
    yield Row("white_is_0.tif", tiff(stored((1 - GREY[0],), 8), 8, photometric=0), lit(grey))
    yield Row("palette.tif", tiff((1 / 255,), 8, palette=[(0, 0, 0), rgb]), lit(rgb))
    yield Row("cmyk.tif", tiff(tuple(1 - v for v in rgb) + (0,), 8, photometric=5), lit(rgb))
    for is_text in False, True:
        yield Row(f"bits{is_text}.pbm", pnm((1,), 1, is_text), (1,))
        for most in 3, 31, 100, 128, 254, 255, 256, 1023, 4095, 40000, 65534, 65535:
            grey, rgb = (tuple(round(v * most) / most for v in pixel) for pixel in (GREY, RGB))
            yield Row(f"{most}{is_text}.pgm", pnm(grey, most, is_text), lit(grey), near=1e-6)
            yield Row(f"{most}{is_text}.ppm", pnm(rgb, most, is_text), lit(rgb), near=1e-6)


def float_rows():
    color = (0.75, 0.5, 0.25)
    asked = "encoding: ENCODING_SRGB"
    yield Row("rgb.pfm", pfm(color), color)
    yield Row("grey.pfm", pfm((0.5,)), (0.5,))
    for kind in "half", "float":
        yield Row(f"grey{kind}.tif", tiff((0.5,), kind), (0.5,))
        yield Row(f"rgb{kind}.tif", tiff(color, kind), color)
        yield Row(f"asked{kind}.tif", tiff(color, kind), lit(color), encoding=asked)
        yield Row(f"loose{kind}.tif", tiff(color + (0.5,), kind, 2), color, 0.5)
        yield Row(f"tied{kind}.tif", tiff(associated(color + (0.5,)), kind, 1), color, 0.5)

        def of(names, pixel):
            return exr(dict(zip(names, pixel)), kind)
        tied = associated(color + (0.5,))
        yield Row(f"y{kind}.exr", of("Y", (0.5,)), (0.5,))
        yield Row(f"ya{kind}.exr", of("YA", (0.25, 0.5)), (0.5,), 0.5)
        yield Row(f"rgb{kind}.exr", of("RGB", color), color)
        yield Row(f"linear{kind}.exr", of("RGB", color), color, encoding="encoding: ENCODING_LINEAR")
        yield Row(f"asked{kind}.exr", of("RGB", color), lit(color), encoding=asked)
        yield Row(f"rgba{kind}.exr", of("RGBA", tied), color, 0.5)
        yield Row(f"small{kind}.exr", of("rgba", tied), color, 0.5)
        yield Row(f"words{kind}.exr", of(("red", "green", "blue", "alpha"), tied), color, 0.5)
        yield Row(f"depth{kind}.exr", of("RGBZ", color + (0.5,)), color)
        yield Row(f"many{kind}.exr",
                  of(("R", "G", "B", "A", "Z", "albedo.R", "albedo.G", "albedo.B", "AR"),
                     tied + (7, 1, 1, 1, 1)), color, 0.5)
        yield Row(f"layer{kind}.exr",
                  of(("View.AO.R", "View.AO.G", "View.AO.B", "View.Combined.R", "View.Combined.G",
                      "View.Combined.B", "View.Combined.A", "View.Depth.Z"),
                     (1, 1, 1) + tied + (9,)), color, 0.5)
        yield Row(f"two{kind}.exr", of("RG", (0.75, 0.5)), (0.75, 0.5, 0))
        yield Row(f"mask{kind}.exr", of(("matte",), (0.5,)), (0.5,))
        luminance = 0.2126 * 0.75 + 0.7152 * 0.5 + 0.0722 * 0.25
        yield Row(f"chroma{kind}.exr",
                  of(("Y", "RY", "BY"), (luminance, 0.75 / luminance - 1, 0.25 / luminance - 1)), color,
                  near=1e-3)
        chroma = {"Y": luminance, "RY": 0.75 / luminance - 1, "BY": 0.25 / luminance - 1}
        for name, alpha in (("few_chroma", 1), ("few_chroma_a", 0.5)):
            held = {channel: v * (alpha if channel == "Y" else 1) for channel, v in chroma.items()}
            held.update({"A": alpha} if alpha < 1 else {})
            yield Row(f"{name}{kind}.exr", exr(held, kind, (0, 0, 7, 5), every={"RY": 2, "BY": 2}), color, alpha,
                      near=2e-3)
        inside = {name: (lambda x, y, v=v: v if 0 <= x < 2 and 0 <= y < 2 else 9)
                  for name, v in zip("RGB", color)}
        yield Row(f"overscan{kind}.exr", exr(inside, kind, (-2, -3, 4, 5), (0, 0, 1, 1)), color)
        yield Row(f"far{kind}.exr", exr(dict(zip("RGB", color)), kind, (7, 7, 9, 9), (0, 0, 1, 1)), color)


class StoredSamples(TesseraTest):
    def pixels(self, scene):
        """Three floats for each, the lowest row first."""
        self.write("scene.tessera", scene)
        result = self.run_program("render", "scene.tessera", "--workers", "0", "--spp", "1", "--quiet",
                                  "-o", "out.pfm")
        self.assertEqual(0, result.code, result.err)
        data = (self.folder / "out.pfm").read_bytes().split(b"\n", 3)[3]
        values = array.array("f", data)
        return [list(values[i:i + 3]) for i in range(0, len(values), 3)]

    def row_of(self, quads, width, behind=0):
        """A pixel of each of the quads."""
        return self.pixels(SCENE % {"width": width, "height": 1, "span": width, "behind": behind} + quads)

    def test_every_kind_is_the_colour_and_coverage_that_its_file_says(self):
        rows = [*integer_rows(), *float_rows()]
        names = [row.name for row in rows]
        self.assertEqual(len(names), len(set(names)))
        for row in rows:
            self.write(row.name, row.data)
        quads = "".join(QUAD % {"i": i, "file": row.name, "encoding": row.encoding}
                        for i, row in enumerate(rows))
        for behind in 0, 1:
            for row, pixel in zip(rows, self.row_of(quads, len(rows), behind)):
                with self.subTest(file=row.name, encoding=row.encoding, behind=behind):
                    for is_, wanted in zip(pixel, row.over(behind)):
                        self.assertAlmostEqual(wanted, is_, delta=row.near)

    def test_what_loses_a_little_is_codes_too(self):
        """JPEG, AVIF, and WebP, whose alpha OpenImageIO 2.4 multiplies into codes of 8 bits."""
        subprocess.run(["oiiotool", "--create", "16x16", "3", "--fill:color=.7372549,.5019608,.2509804",
                        "16x16", "-d", "uint8", "--compression", "jpeg:100", "-o", self.folder / "a.jpg",
                        "--quality", "100", "-o", self.folder / "a.avif"],
                       check=True, stdout=subprocess.DEVNULL)
        self.write("a.webp", WEBP)
        quads = "".join(QUAD % {"i": i, "file": name, "encoding": ""} for i, name in
                        enumerate(["a.jpg", "a.avif", "a.webp"]))
        jpeg, avif, webp = self.row_of(quads, 3)
        for i, wanted in enumerate(lit(RGB)):
            self.assertAlmostEqual(wanted, jpeg[i], delta=0.02)
            self.assertAlmostEqual(wanted, avif[i], delta=0.02)
        for i, code in enumerate((87, 46, 28)):
            self.assertAlmostEqual(light(code / 255) * 128 / 255, webp[i], delta=0.003)

    def test_what_the_library_would_read_wrongly_is_refused(self):
        rgb, alpha = stored(RGB, 8), stored(ALPHA, 8)
        for data, told in ((tiff((1 / 255,) + alpha, 8, 2, palette=[(0, 0, 0), rgb]), "a palette with alpha"),
                           (tiff(stored(GREY, 8) + alpha, 8, 2, photometric=0), "inverted greys with alpha"),
                           (tiff(rgb + (0,) + alpha, 8, 2, photometric=5), "5 inks")):
            with self.subTest(told):
                self.write("a.tif", data)
                self.write("scene.tessera", QUAD % {"i": 0, "file": "a.tif", "encoding": ""})
                self.assert_error(self.run_program("render", "scene.tessera", "-o", "out.pfm"), 1,
                                  f"a.tif: can not be read: TIFF of {told} is not known")

    def test_jpeg_2000_of_any_depth_and_with_alpha(self):
        """Without loss, of one colour."""
        rows = []
        for bits in 8, 16:
            for pixel in GREY, RGB, RGB + ALPHA:
                name, values = f"{len(pixel)}x{bits}.jp2", stored(pixel, bits)
                subprocess.run(["oiiotool", "--create", "64x64", str(len(pixel)),
                                "--fill:color=" + ",".join(map(str, values)), "64x64", "-d", f"uint{bits}",
                                "--attrib", "oiio:UnassociatedAlpha", "1", "-o", self.folder / name],
                               check=True, stdout=subprocess.DEVNULL)
                alpha = values[3] if len(pixel) == 4 else 1
                rows.append(Row(name, b"", lit(values[:3]), alpha))
        quads = "".join(QUAD % {"i": i, "file": row.name, "encoding": ""} for i, row in enumerate(rows))
        for row, pixel in zip(rows, self.row_of(quads, len(rows), 1)):
            with self.subTest(file=row.name):
                for is_, wanted in zip(pixel, row.over(1)):
                    self.assertAlmostEqual(wanted, is_, delta=row.near)

    def test_beside_an_associated_edge_nothing_is_dark(self):
        """A white disc with a soft edge, before white."""
        def cover(x, y):
            return max(0, min(1, 6.5 - ((x - 7.5) ** 2 + (y - 7.5) ** 2) ** 0.5))
        self.write("disc.exr", exr(dict.fromkeys("RGBA", cover), data=(0, 0, 15, 15)))
        quad = QUAD % {"i": 0, "file": "disc.exr", "encoding": ""}
        for side in 64, 5:  # larger than the picture, and by its levels
            scene = SCENE % {"width": side, "height": side, "span": 1, "behind": 1} + quad
            self.assertGreater(min(map(min, self.pixels(scene))), 0.999)

    def test_pixels_that_a_display_window_lacks_are_clear(self):
        self.write("part.exr", exr({"R": 1, "G": 1, "B": 1, "A": 1}, data=(0, 0, 0, 1), display=(0, 0, 1, 1)))
        quad = QUAD % {"i": 0, "file": "part.exr", "encoding": "filter: NEAREST"}
        self.assertEqual([[1, 1, 1], [0, 0, 0]], self.row_of(quad.replace("edge_u { x: 1", "edge_u { x: 2"), 2))

    def test_a_panorama_is_light_whatever_its_alpha(self):
        self.write("sky16.png", png((128 / 255,) * 3, 16))
        self.write("sky.exr", exr(dict(zip("RGBA", (0.25, 0.25, 0.25, 0.5)))))
        self.write("clear.exr", exr(dict(zip("RGBA", (0.25, 0.25, 0.25, 0)))))
        for name, wanted in ("sky16.png", light(128 / 255)), ("sky.exr", 0.25), ("clear.exr", 0.25):
            with self.subTest(name):
                scene = ("settings { width: 1 height: 1 } cameras { }\n"
                         'background { panorama { texture: "t" } }\n'
                         f'textures {{ name: "t" image {{ file: "{name}" }} }}\n')
                self.assertAlmostEqual(wanted, self.pixels(scene)[0][0], delta=1e-6)

    def test_light_without_coverage_is_added_to_what_is_behind_a_cube(self):
        faces = " ".join(f'{face}: "t"' for face in ("front", "back", "left", "right", "top", "bottom"))
        for alpha, wanted in (0, 0.25 + 0.5), (0.5, 0.25 + 0.5 * 0.5), (1, 0.25):
            self.write("light.exr", exr(dict(zip("RGBA", (0.25, 0.25, 0.25, alpha)))))
            for sky in "solid { r: .5 g: .5 b: .5 }", "rings { sky { r: .5 g: .5 b: .5 } }":
                for integrator in "whitted", "path":
                    with self.subTest(alpha=alpha, sky=sky, integrator=integrator):
                        scene = ("settings { width: 1 height: 1 integrator { kind: \"%s\" } } cameras { }\n"
                                 "background { %s cube { %s } }\n"
                                 'textures { name: "t" image { file: "light.exr" } }\n'
                                 % (integrator, sky, faces))
                        self.assertAlmostEqual(wanted, self.pixels(scene)[0][0], delta=1e-6)

    def test_info_tells_the_channels_that_are_not_used(self):
        self.write("own.exr", exr(dict.fromkeys(["R", "G", "B", "Z", "albedo.R", "albedo.G"], 0.5)))
        self.write("scene.tessera", QUAD % {"i": 0, "file": "own.exr", "encoding": ""})
        result = self.run_program("info", "scene.tessera", "--json")
        self.assertEqual(0, result.code, result.err)
        self.assertIn("channels Z, albedo.R, albedo.G of 'own.exr'", json.loads(result.out)["unused"])

    def test_info_tells_the_parts_that_are_not_used(self):
        self.write("parts.exr", exr_parts({"beauty": dict.fromkeys("RGB", 0.25), "depth": {"Z": 0.5},
                                           "id": {"Y": 0.75}}))
        self.write("scene.tessera", QUAD % {"i": 0, "file": "parts.exr", "encoding": ""})
        result = self.run_program("info", "scene.tessera", "--json")
        self.assertEqual(0, result.code, result.err)
        self.assertIn("channels depth.Z, id.Y of 'parts.exr'", json.loads(result.out)["unused"])
        self.assertEqual([[0.25] * 3], self.row_of(QUAD % {"i": 0, "file": "parts.exr", "encoding": ""}, 1))

    def test_the_part_that_has_colours_is_the_picture(self):
        self.write("parts.exr", exr_parts({"depth": {"Z": 9}, "beauty": dict.fromkeys("RGB", 0.25)}))
        self.write("one.exr", exr(dict.fromkeys("RGB", 0.25)))
        quad = QUAD % {"i": 0, "file": "parts.exr", "encoding": ""}
        self.assertEqual([[0.25] * 3], self.row_of(quad, 1))
        info = json.loads(self.run_program("info", "scene.tessera", "--json").out)
        self.assertIn("channel depth.Z of 'parts.exr'", info["unused"])
        told = "parts.exr: part 'beauty' is read, not the first"
        self.assertTrue(any(told in warning for warning in info["warnings"]), info)
        result = self.run_program("compare", "parts.exr", "one.exr")
        self.assertEqual(0, result.code, result.err)
        self.assertIn(told, result.err)
        self.write("passes.exr", exr_parts({"id": {"Y": 9}, "diffuse": dict.fromkeys("RGB", 9),
                                            "View.Combined": dict.fromkeys("RGB", 0.75)}))
        quad = QUAD % {"i": 0, "file": "passes.exr", "encoding": ""}
        self.assertEqual([[0.75] * 3], self.row_of(quad, 1), "its name says that it is the picture")
        self.write("depths.exr", exr_parts({"depth": {"Z": 0.5}, "far": {"Z": 1}}))
        quad = QUAD % {"i": 0, "file": "depths.exr", "encoding": ""}
        self.assertEqual([[0.5] * 3], self.row_of(quad, 1), "none has colours: the first")

    def test_a_gamma_that_is_not_followed_is_told(self):
        rgb, rows, told = stored(RGB, 8), [], set()
        one, usual = (chunk(b"gAMA", struct.pack(">I", gamma)) for gamma in (100000, 45455))
        for bits in 8, 16:
            plain = png(rgb, bits)
            for kind, more in (("one", one), ("usual", usual), ("sRGB", one + chunk(b"sRGB", b"\0")), ("none", b"")):
                name = f"{kind}{bits}.png"
                for encoding in "encoding: ENCODING_LINEAR", "":
                    rows.append(Row(name, plain[:33] + more + plain[33:], rgb if encoding else lit(rgb),
                                    encoding=encoding))
                if kind == "one":
                    told.add(name)
        for row in rows:
            self.write(row.name, row.data)
        quads = "".join(QUAD % {"i": i, "file": row.name, "encoding": row.encoding} for i, row in enumerate(rows))
        for row, pixel in zip(rows, self.row_of(quads, len(rows))):
            with self.subTest(file=row.name):
                for is_, wanted in zip(pixel, row.color):
                    self.assertAlmostEqual(wanted, is_, delta=1e-3)
        warnings = json.loads(self.run_program("info", "scene.tessera", "--json").out)["warnings"]
        self.assertEqual(told, {row.name for row in rows for warning in warnings
                                if row.name in warning and "gamma 1 (gAMA)" in warning})

    def test_metrics_compare_light(self):
        self.write("a.png", png(RGB, 16))
        self.write("b.exr", exr(dict(zip("RGB", lit(RGB))), "float"))
        result = self.run_program("compare", "a.png", "b.exr", "--metrics")
        rmse = next(line for line in result.out.splitlines() if line.startswith("linear rmse")).split()[2]
        self.assertLess(float(rmse), 1e-6)

    def test_compare_says_where_codes_meet_light(self):
        self.write("a.png", png(RGB, 16))
        self.write("b.exr", exr(dict(zip("RGB", lit(RGB))), "float"))
        self.write("a4.png", png(RGB + ALPHA, 16))
        self.write("b4.exr", exr(dict(zip("RGBA", (*lit(RGB), *ALPHA))), "float"))
        for pair, told in ((("a.png", "b.exr"), ["a.png: sRGB codes; b.exr: linear light"]),
                           (("b.exr", "a.png"), ["b.exr: linear light; a.png: sRGB codes"]),
                           (("a4.png", "b4.exr"),
                            ["a4.png: sRGB codes; b4.exr: linear light multiplied by alpha"]),
                           (("a.png", "a.png"), []), (("b4.exr", "b4.exr"), [])):
            for options in ([], ["--metrics"]) if told else ([],):
                with self.subTest(pair, options=options):
                    lines = self.run_program("compare", *pair, *options).out.splitlines()
                    self.assertEqual([f"as stored         {meanings}" for meanings in told],
                                     [line for line in lines if line.startswith("as stored")])


if __name__ == "__main__":
    unittest.main()
