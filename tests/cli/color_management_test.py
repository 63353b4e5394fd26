#!/usr/bin/env python3
"""Output through OpenColorIO: --ocio-view and its like."""
import struct
import unittest

from tessera_process import TesseraTest, nightly

CONFIG = """ocio_profile_version: 1
roles:
  scene_linear: plain
  default: plain
displays:
  screen:
    - !<View> {name: halved, colorspace: half}
    - !<View> {name: as is, colorspace: plain}
  projector:
    - !<View> {name: quarter, colorspace: quarter}
active_displays: [screen, projector]
active_views: [halved, as is, quarter]
colorspaces:
  - !<ColorSpace>
    name: plain
  - !<ColorSpace>
    name: half
    from_reference: !<MatrixTransform> {matrix: [.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: quarter
    from_reference: !<MatrixTransform> {matrix: [.25, 0, 0, 0, 0, .25, 0, 0, 0, 0, .25, 0, 0, 0, 0, 1]}
"""
# Nothing but a background of one colour.
SCENE = """background { solid { r: .8 g: .4 b: .2 } }
settings { width: 8 height: 8 sampling { samples_per_pixel: 1 } }
cameras { }
"""


class ColorManagement(TesseraTest):
    def setUp(self):
        super().setUp()
        self.write("scene.tessera", SCENE)
        self.config = self.write("config.ocio", CONFIG)

    def environment(self):
        return {**super().environment(), "OCIO": str(self.config)}

    def render(self, *options, config=None):
        self.config = self.config if config is None else config
        return self.run_program("render", "scene.tessera", "--workers", "0", "--threads", "1",
                                "--quiet", "-o", "out.ppm", *options)

    def pixel(self, *options):
        result = self.render(*options)
        self.assertEqual(0, result.code, result.err)
        return tuple((self.folder / "out.ppm").read_bytes()[-3:])

    def test_views_and_spaces(self):
        self.assertEqual((102, 51, 26), self.pixel("--ocio-view", "default"))
        self.assertEqual((102, 51, 26), self.pixel("--ocio-view", "halved"))
        self.assertEqual((204, 102, 51), self.pixel("--ocio-view", "as is"))
        self.assertEqual((51, 26, 13), self.pixel("--ocio-display", "projector"))
        self.assertEqual((51, 26, 13), self.pixel("--ocio-space", "quarter"))

    def test_a_configuration_may_name_files_anywhere(self):
        """Those that convert colours may read them; those that decode textures may not."""
        elsewhere = self.folder / "elsewhere"
        elsewhere.mkdir()
        table = self.write("elsewhere/half.spi1d", "Version 1\nFrom 0 1\nLength 2\nComponents 1\n"
                           "{\n0\n.5\n}\n")
        config = CONFIG.replace("!<MatrixTransform> {matrix: [.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, "
                                "0, 0, 0, 1]}", f"!<FileTransform> {{src: {table}, "
                                "interpolation: linear}")
        self.assertIn(str(table), config)
        (self.folder / "configuration").mkdir()
        self.config = self.write("configuration/config.ocio", config)
        picture = self.write("a.ppm", b"P6\n1 1\n255\n\xcc\x66\x34")
        self.write("scene.tessera", SCENE.replace(
            "solid { r: .8 g: .4 b: .2 }", 'panorama { texture: "t" }')
            + f'textures {{ name: "t" image {{ file: "{picture.name}" encoding: ENCODING_LINEAR }} }}\n')
        self.assertEqual((102, 51, 26), self.pixel("--ocio-view", "halved"))

    def test_exposure_comes_first_and_the_input_can_be_named(self):
        self.assertEqual((204, 102, 51), self.pixel("--ocio-view", "halved", "--exposure", "1"))
        self.assertEqual((204, 102, 51), self.pixel("--ocio-view", "halved", "--ocio-input", "half"))

    @nightly
    def test_without_the_options_the_variable_changes_nothing(self):
        self.assertEqual(self.pixel(), self.pixel("--transfer", "srgb"))
        self.assertNotEqual(self.pixel(), self.pixel("--ocio-view", "as is"))

    def test_floats_stay_linear(self):
        result = self.render("-o", "out.pfm", "--ocio-view", "halved")
        self.assertEqual(0, result.code, result.err)
        values = struct.unpack("<3f", (self.folder / "out.pfm").read_bytes()[-12:])
        self.assertEqual(struct.pack("<3f", .8, .4, .2), struct.pack("<3f", *values))

    def check_refused(self, result, *words):
        self.assertEqual(2, result.code, result.err)
        for word in words:
            self.assertIn(word, result.err)
        self.assertFalse((self.folder / "out.ppm").exists())

    @nightly
    def test_wrong_names(self):
        self.check_refused(self.render("--ocio-view", "halvd"), "no view of screen 'halvd'",
                           "halved, as is", "did you mean 'halved'?")
        self.check_refused(self.render("--ocio-display", "scren"), "did you mean 'screen'?")
        self.check_refused(self.render("--ocio-space", "haf"), "did you mean 'half'?")
        self.check_refused(self.render("--ocio-view", "halved", "--ocio-input", "pain"),
                           "did you mean 'plain'?")
        self.check_refused(self.render("--ocio-view", "x" * 200), "too long")

    def test_wrong_configurations(self):
        self.check_refused(self.render("--ocio-view", "halved", config=""), "--ocio-view without $OCIO; expected")
        self.check_refused(self.render("--ocio-view", "halved", config=self.folder / "none.ocio"),
                           "none.ocio")
        broken = self.write("broken.ocio", "ocio_profile_version: 1\nroles: [")
        self.check_refused(self.render("--ocio-view", "halved", config=broken), "broken.ocio")

    def test_wrong_combinations(self):
        self.check_refused(self.render("--ocio-view", "halved", "--ocio-space", "half"), "--ocio-space")
        self.check_refused(self.render("--ocio-view", "halved", "--tone-map", "filmic"), "--tone-map")
        self.check_refused(self.render("--ocio-input", "half"), "--ocio-view")


if __name__ == "__main__":
    unittest.main()
