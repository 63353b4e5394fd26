"""Pictures as arrays and files."""
import copy
import functools
import importlib
import json
import os
import pathlib
import pickle
import re
import struct
import warnings
import zlib

import numpy as np
import pytest

import tessera as ts

KNOT = str(pathlib.Path(__file__).parents[2] / "scenes" / "samples" / "knot.tessera")


@pytest.fixture(scope="module")
def image():
    return ts.render(KNOT, workers=0, size=(70, 50), crop=(5, 4, 65, 44), spp=4, aovs="all")


def decoded_png(data):
    """The pixels of an RGB PNG whose rows are filtered in any way."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", body[:10])
            assert bits in (8, 16) and colour == 2
        if kind == b"IDAT":
            packed += body
        at += length + 12
    raw = zlib.decompress(packed)
    pixel = 3 * bits // 8
    length = width * pixel
    out = np.zeros((height, length), np.int64)
    above = np.zeros(length, np.int64)
    for y in range(height):
        start = y * (1 + length)
        kind, line = raw[start], np.frombuffer(raw, np.uint8, length, start + 1).astype(np.int64)
        row = np.zeros(length, np.int64)
        for x in range(length):
            a, b, c = (row[x - pixel], above[x], above[x - pixel]) if x >= pixel else (0, above[x], 0)
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[x] = line[x] + (0, a, b, (a + b) // 2, paeth)[kind] & 255
        out[y] = above = row
    if bits == 16:
        out = out[:, ::2] * 256 + out[:, 1::2]
    return out.reshape(height, width, 3).astype(f"u{bits // 8}")


def test_shapes_and_types(image):
    assert image.size == (60, 40) and image.shape == image.linear.shape
    assert image.linear.shape == (40, 60, 3) and image.linear.dtype == np.float32
    assert not image.linear.flags.writeable
    for name in ("albedo", "normal", "position", "variance"):
        assert image.aov(name).shape == (40, 60, 3) and image.aov(name).dtype == np.float32
    for name in ("depth", "samples"):
        assert image.aov(name).shape == (40, 60) and image.aov(name).dtype == np.float32
    assert image.aov("id").shape == (40, 60) and image.aov("id").dtype == np.uint32
    assert (image.aov("samples") == 4).all()
    with pytest.raises(ts.UsageError, match="aov: 'dept'; expected one of those that were rendered: albedo, .*did you mean 'depth'"):
        image.aov("dept")
    with pytest.raises(ts.UsageError, match="aov: 'depth'; expected none: this picture has no AOVs"):
        ts.Image.from_array([[.5]]).aov("depth")


@pytest.mark.parametrize("aovs", [(), ("depth", "normal", "id")])
def test_light_and_aovs_are_views_of_the_film(aovs):
    picture = ts.render(KNOT, workers=0, size=(20, 10), aovs=aovs)
    film = np.asarray(picture._picture.values)
    views = [picture.linear, *(picture.aov(name) for name in aovs if name != "id")]
    assert all(np.shares_memory(view, film) and not view.flags.writeable for view in views)
    copies = [np.asarray(picture._picture.light()), *(np.asarray(picture._picture.channels(name))
                                                      for name in aovs if name != "id")]
    assert all((view == copy).all() and view.shape == copy.shape for view, copy in zip(views, copies))
    del picture, film
    assert all((view == copy).all() for view, copy in zip(views, copies))


def test_the_bytes_of_the_png(image, tmp_path):
    image.save(tmp_path / "x.png", tmp_path / "bright.png", tmp_path / "x.exr", exposure=1.5, tone_map="filmic")
    again = image.to_srgb(exposure=1.5, tone_map="filmic")
    assert (decoded_png((tmp_path / "x.png").read_bytes()) == again).all()
    assert (decoded_png(image._repr_png_()) == image.to_srgb()).all()
    assert image.to_srgb().dtype == np.uint8 and (again != image.to_srgb()).any()
    with pytest.raises(ts.RenderError, match="nowhere"):
        image.save(tmp_path / "nowhere" / "x.png")


def test_exposure_by_the_picture():
    grey = ts.Image.from_array(np.full((4, 4, 3), .045, "f4"))
    assert grey.auto_exposure() == pytest.approx(2, abs=.011)
    assert (grey.to_srgb(exposure="auto") == grey.to_srgb(exposure=grey.auto_exposure())).all()
    assert (grey.to_srgb(exposure="auto") == 118).all()
    # Before a bright background the surface alone counts, where the picture tells it.
    scene = ts.Scene(width=8, height=8, background=20, ambient=1)
    scene.add(ts.Sphere(radius=.5, center=(0, 0, 5)), material=ts.Classic(emission=.09, diffuse=0))
    assert scene.render(workers=0, transparent_background=True).auto_exposure() == pytest.approx(1, abs=.011)
    assert scene.render(workers=0).auto_exposure() < 0


def test_a_large_picture_is_shown_smaller():
    wide = ts.Image.from_array(np.ones((2, 5000, 3)))
    assert decoded_png(wide._repr_png_()).shape == (1, 1667, 3)


def test_aovs_are_the_channels_of_the_exr(image, tmp_path):
    image.save(tmp_path / "x.exr")
    names, values, is_float = ts._core.read_picture(str(tmp_path / "x.exr"))
    values = np.asarray(values)
    assert is_float
    prefixes = {"normal": "N", "depth": "Z", "position": "P"}
    for name in image.aovs:
        prefix = prefixes.get(name, name)
        channels = sorted(n for n in names if n.split(".")[0] == prefix and n not in "RGB")
        if name in ("albedo", "variance"):
            channels = [f"{prefix}.{c}" for c in "RGB"]
        theirs = values[:, :, [names.index(n) for n in channels]]
        assert (image.aov(name).reshape(theirs.shape) == theirs).all(), name
    light = values[:, :, [names.index(c) for c in "RGB"]]
    assert (light == image.linear).all()


def test_statistics_are_those_of_the_command_line(image, tmp_path, tessera):
    tessera("render", KNOT, "--workers", "0", "--size", "70x50", "--crop", "5,4,65,44", "--spp", "4",
            "-o", tmp_path / "x.exr", "--aovs", "all", "--stats", tmp_path / "x.json")
    theirs = json.loads((tmp_path / "x.json").read_text())
    assert image.stats.keys() == theirs.keys()
    for name in theirs.keys() - {"seconds", "peak_memory_bytes"}:  # which differ from run to run
        assert image.stats[name] == theirs[name], name
    image.stats.clear()  # what a caller does to it
    assert image.stats["pixels_sha256"] == theirs["pixels_sha256"] == image.sha256
    assert image.stats["scene"] == theirs["scene"]
    assert image.stats["rays"] == theirs["rays"]
    assert image.holes == []


def test_pictures_from_arrays(tmp_path):
    values = np.linspace(0, 4, 2 * 3 * 3).reshape(2, 3, 3).astype(np.float32)
    made = ts.Image.from_array(values)
    assert (made.linear == values).all()
    made.save(tmp_path / "x.pfm")
    assert (ts.read_image(tmp_path / "x.pfm").linear == values).all()
    assert (made.apply(np.sqrt).linear == np.sqrt(values)).all()
    grey = np.arange(256, dtype=np.uint8)[None]
    assert (ts.Image.from_array(grey, linear=False).to_srgb()[:, :, 1] == grey).all()
    assert np.asarray(made) is made.linear
    for wrong in (np.zeros((2, 2, 4)), np.zeros((0, 2, 3)), np.zeros(3)):
        with pytest.raises(ts.UsageError, match=r"expected \(h, w, 3\)"):
            ts.Image.from_array(wrong)
    with pytest.raises(ts.UsageError, match="no alpha: multiply it in, or leave it out by array"):
        ts.Image.from_array(np.zeros((2, 2, 4), np.uint8))
    for wrong in (complex, np.int64, np.int32, np.uint32, np.int8, bool, object):
        with pytest.raises(TypeError, match="array: numbers of type .*; expected floats, uint8 or uint16"):
            ts.Image.from_array(np.zeros((2, 2, 3), wrong))


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, ">u2"])
def test_whole_numbers_are_codes_in_srgb(kind):
    most = np.iinfo(kind).max
    codes = np.linspace(0, most, 256).astype(kind)[None]
    shown = ts.Image.from_array(codes)
    assert (shown.to_srgb()[:, :, 0] == np.arange(256)).all() and shown == ts.Image.from_array(codes, linear=False)
    assert (ts.Image.from_array(codes, linear=True).linear[:, :, 0] == (codes / most).astype("f4")).all()
    assert (ts.Image.from_array(codes / most).linear[:, :, 0] == (codes / most).astype("f4")).all()


def test_the_bytes_of_a_picture_make_it_again(image):
    codes = image.to_srgb()
    assert (ts.Image.from_array(codes).to_srgb() == codes).all()


def test_pictures_are_equal_that_have_the_same_beside_light(image):
    plain = ts.Image.from_array(image.linear)
    assert plain != image and plain == ts.Image.from_array(image.linear) and plain.sha256 == image.sha256
    less = ts.render(KNOT, workers=0, size=(70, 50), crop=(5, 4, 65, 44), spp=4, aovs=["depth"])
    assert less != image and less.sha256 == image.sha256
    assert len({image, plain, less}) == 3 and image != "picture"


def test_other_light_keeps_the_rest(image):
    half = image.apply(lambda light: light / 2)
    assert (half.linear == image.linear / 2).all() and half.aovs == image.aovs and half.stats == image.stats
    for name in image.aovs:
        assert np.array_equal(half.aov(name), image.aov(name)), name
    assert half != image and half.apply(lambda light: light * 2) == image
    asked = ts.Scene(width=4, height=4, exposure=2, background=(.3, .2, .1)).render(workers=0)
    assert (asked.apply(lambda light: light).to_srgb() == asked.to_srgb()).all()
    with pytest.raises(ts.UsageError, match=r"shape \(20, 60, 3\); expected \(40, 60, 3\)"):
        image.apply(lambda light: light[::2])


def test_all_files_are_written_that_can_be(image, tmp_path):
    with pytest.raises(ts.Error) as told:
        image.save(tmp_path / "no" / "a.png", tmp_path / "b.png", tmp_path / "c.what", tmp_path / "d.pfm")
    assert len(str(told.value).splitlines()) == 2 and "c.what" in str(told.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b.png", "d.pfm"]


def test_codes_are_the_same_light_when_they_are_read_again(tmp_path):
    image = ts.Image.from_array(np.arange(256, dtype="u1").reshape(16, 16))
    image.save(tmp_path / "codes.png")
    assert ts.read_image(tmp_path / "codes.png") == image


def test_what_a_file_holds_tells_whether_it_is_light(tmp_path):
    values = np.random.default_rng(4).uniform(0, 1, (4, 5, 3)).astype("f4")
    image = ts.Image.from_array(values)
    for name in ("a.exr", "a.pfm", "a.png"):
        image.save(tmp_path / name)
    (tmp_path / "a.exr").rename(tmp_path / "exr.png")
    (tmp_path / "a.png").rename(tmp_path / "png.exr")
    assert (ts.read_image(tmp_path / "exr.png").linear == values).all()
    assert (ts.read_image(tmp_path / "png.exr").to_srgb() == image.to_srgb()).all()
    assert ts.compare(tmp_path / "exr.png", tmp_path / "a.pfm").max == 0
    (tmp_path / "a.tiff").write_bytes(float_tiff(values))
    assert (ts.read_image(tmp_path / "a.tiff").linear == values).all()


def float_tiff(values):
    """A file of 32-bit floats in one strip."""
    height, width, _ = values.shape
    tags = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 3, 8), (259, 3, 1, 1), (262, 3, 1, 2),
            (273, 4, 1, 200), (277, 3, 1, 3), (278, 4, 1, height), (279, 4, 1, values.nbytes), (339, 3, 3, 14)]
    entries = b"".join(struct.pack("<HHII", *tag) for tag in tags)
    head = b"II*\0" + struct.pack("<I", 20) + struct.pack("<6H", 32, 32, 32, 3, 3, 3)
    return (head + struct.pack("<H", len(tags)) + entries + bytes(4)).ljust(200, b"\0") + values.tobytes()


@pytest.fixture
def stored_pictures(monkeypatch):
    """The writers of the tests of the command line."""
    monkeypatch.syspath_prepend(str(pathlib.Path(__file__).parents[1] / "cli"))
    return importlib.import_module("stored_pictures")


@pytest.fixture
def stored_rows(stored_pictures):  # which adds the folder
    """Files of every kind of sample, each with the colour and coverage that it holds."""
    rows = importlib.import_module("stored_samples_test")
    return [row for row in (*rows.integer_rows(), *rows.float_rows()) if not row.encoding]


def test_a_picture_is_its_light_before_black(tmp_path, stored_rows):
    assert len(stored_rows) > 100
    for row in stored_rows:
        (tmp_path / row.name).write_bytes(row.data)
        pixel = ts.read_image(tmp_path / row.name).linear[0, 0]
        assert pixel == pytest.approx(row.over(0), abs=row.near), row.name


def test_a_picture_has_the_pixels_of_its_display_window(tmp_path, stored_pictures):
    channels = dict.fromkeys("RGB", lambda x, y: 10 * y + x)
    for data, rows in (((1, 0, 2, 1), [[1, 2], [11, 12]]), ((-2, -1, 0, 9), [[0], [10]]),
                       ((2, 1, 5, 3), [[12]]), ((7, 0, 8, 0), [[7, 8]])):
        part = stored_pictures.exr(channels, data=data, display=(0, 0, 2, 1))
        (tmp_path / "part.exr").write_bytes(part)
        assert ts.read_image(tmp_path / "part.exr").linear[:, :, 0].tolist() == rows


def test_codes_of_any_depth_are_light(tmp_path, stored_pictures):
    color = (188 / 255, 128 / 255, 64 / 255)
    lit = [ts._core.srgb_to_linear(code) for code in color]
    for name, data in (("8.png", stored_pictures.png(color, 8)), ("16.png", stored_pictures.png(color, 16)),
                       ("16.tif", stored_pictures.tiff(color, 16))):
        (tmp_path / name).write_bytes(data)
        assert ts.read_image(tmp_path / name).linear[0, 0] == pytest.approx(lit, abs=1e-6), name
    texture = ts.ImageTexture(tmp_path / "16.png")
    assert np.asarray(texture.texels)[:3] == pytest.approx(lit, abs=1e-6)
    texture = ts.ImageTexture(tmp_path / "16.png", encoding="linear")
    assert np.asarray(texture.texels)[:3] == pytest.approx(color, abs=1e-6)
    codes = np.round(np.array([[(*color, 1)]]) * 65535).astype("u2")
    for array in (codes, codes.astype(">u2"), np.repeat(codes, 2, 1)[:, ::2]):
        texture = ts.ImageTexture(array)
        assert (texture.bits, texture.channels, texture.encoding) == (32, 4, "linear")
        assert np.asarray(texture.texels) == pytest.approx([*lit, 1], abs=1e-6)
        texture = ts.ImageTexture(array, encoding="linear")
        assert np.asarray(texture.texels) == pytest.approx([*color, 1], abs=1e-5)
    with pytest.raises(ValueError, match="sides of at most"):
        ts.ImageTexture(np.broadcast_to(np.uint16(0), (10**5, 10**5)))


def test_negative_light_is_none():
    texture = ts.ImageTexture(np.full((1, 1, 3), (-5, .5, -1), "f4"))
    sky = ts.Background(panorama=ts.BackgroundPanorama(texture))
    ball = ts.Sphere(material=ts.Unlit(color=texture))
    camera = ts.Camera.look_at(eye=(0, 0, 3), target=(0, 0, 0))
    for scene in (ts.Scene(background=sky, cameras=[camera]), ts.Scene(nodes=[ball], cameras=[camera])):
        image = ts.render(scene, workers=0, size=(3, 3))
        assert image.linear[1, 1].tolist() == [0, .5, 0]


def test_colour_and_coverage_by_name(tmp_path, stored_pictures):
    (tmp_path / "a.exr").write_bytes(stored_pictures.exr({"R": .25, "G": .5, "B": .75, "A": .5, "Z": 9}))
    assert ts.read_image(tmp_path / "a.exr").linear[0, 0].tolist() == [.25, .5, .75]
    texture = ts.ImageTexture(tmp_path / "a.exr")
    assert (texture.channels, texture.bits, texture.associated_alpha) == (4, 16, True)
    (tmp_path / "b.exr").write_bytes(stored_pictures.exr({"B": .25, "G": .5, "R": .75, "Z": 0}))
    texture = ts.ImageTexture(tmp_path / "b.exr")
    assert texture.channels == 3 and not texture.associated_alpha
    assert np.asarray(texture.texels)[:3].tolist() == [.75, .5, .25]


def test_floats_are_codes_where_they_are_said_to_be(tmp_path, stored_pictures):
    (tmp_path / "a.exr").write_bytes(stored_pictures.exr({"Y": .5}, "float"))
    lit = np.float32(ts._core.srgb_to_linear(.5))
    for picture in (tmp_path / "a.exr", np.full((2, 2), .5, "f4"), np.full((2, 2), .5, "f2")):
        assert np.asarray(ts.ImageTexture(picture).texels)[0] == .5
        assert np.asarray(ts.ImageTexture(picture, encoding="srgb").texels)[0] == lit
        assert np.asarray(ts.ImageTexture(picture, encoding="linear").texels)[0] == .5


def test_numbers_that_are_not_finite_are_read_as_they_are(tmp_path, stored_pictures):
    """Of a picture that is measured, unlike a texture."""
    channel = lambda x, y: [float("inf"), float("nan")][y] if x == 1 else 1
    (tmp_path / "a.exr").write_bytes(stored_pictures.exr({"Y": channel}))
    made = ts.read_image(tmp_path / "a.exr")
    assert np.array_equal(made.linear[:, :, 0], [[1, np.inf], [1, np.nan]], equal_nan=True)
    assert ts.compare(made, made).not_finite == 6


def test_the_part_that_has_colours_is_told(tmp_path, stored_pictures):
    parts = {"depth": {"Z": 9}, "beauty": dict.fromkeys("RGB", .25)}
    (tmp_path / "a.exr").write_bytes(stored_pictures.exr_parts(parts))
    with pytest.warns(ts.SceneWarning, match="a.exr: part 'beauty' is read, not the first"):
        made = ts.read_image(tmp_path / "a.exr")
    assert made.linear[0, 0].tolist() == [.25, .25, .25]
    with pytest.warns(ts.SceneWarning, match="a.exr: part 'beauty' is read"):
        assert ts.ImageTexture(tmp_path / "a.exr").channels == 3


def test_numbers_that_are_not_finite_are_told_with_their_place(tmp_path, stored_pictures):
    channel = lambda x, y: float("inf") if (x, y) == (1, 0) else 1
    (tmp_path / "a.exr").write_bytes(stored_pictures.exr({"Y": channel}))
    with pytest.warns(ts.SceneWarning, match="a.exr: pixel 1,0 has the number inf and is read as 65504"):
        texture = ts.ImageTexture(tmp_path / "a.exr", filter="nearest")
    assert np.asarray(texture.texels).ravel().tolist() == [1, 65504, 1, 1]
    array = np.ones((3, 4, 3), "f4")
    array[2, 1, 0] = np.nan
    scene = ts.Scene(background=ts.Background(panorama=ts.BackgroundPanorama(ts.ImageTexture(array))))
    with pytest.raises(ts.SceneError, match="image.texels is infinite or no number at pixel 1,2"):
        ts.render(scene, workers=0, size=(4, 4))


def test_a_picture_that_is_missing():
    for call in (ts.read_image, lambda path: ts.compare(path, path)):
        with pytest.raises(ts.MissingFile, match="^nope.png: there is no such file; expected a picture") as told:
            call("nope.png")
        assert told.value.filename == "nope.png"


def test_pictures_are_compared():
    a = ts.Image.from_array(np.full((8, 8, 3), .5))
    b = ts.Image.from_array(np.full((8, 8, 3), .25))
    same = ts.compare(a, a)
    assert same == (0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, (0, 0, 0), 0, None, None)
    metrics = ts.compare(a, b)
    assert metrics.max == metrics.mean == metrics.rmse == .25
    assert metrics.rel_mse == pytest.approx(.0625 / (.0625 + .01)) and metrics.flip > 0
    with pytest.raises(ts.UsageError, match="size 1x1; expected 8x8"):
        ts.compare(a, ts.Image.from_array(np.zeros((1, 1, 3))))


def test_a_comparison_has_what_the_command_line_tells(image, tmp_path, tessera):
    other = image.linear.copy()
    other[7:9, 20] += (.1, 0, 0)
    other[30, 11] = (0, .9, np.nan)
    paths = [tmp_path / "a.exr", tmp_path / "b.exr"]
    ts.Image.from_array(other).save(paths[0])
    ts.Image.from_array(image.linear).save(paths[1])
    told = tessera("compare", *paths, "--metrics", "--max-diff", "1e9", check=False)
    ours = ts.compare(*paths)
    assert ts.compare(ts.Image.from_array(other), image) == ours

    def numbers(label):
        text = re.search(rf"^{re.escape(label)} +(.*)$", told, re.M).group(1)
        return [float(number) for number in re.findall(r"inf|-?\d+\.?\d*(?:e-?\d+)?", text)]
    for label, value in {"max difference": ours.max, "mean difference": ours.mean, "rmse": ours.rmse,
                         "SMAPE": ours.smape, "FLIP": ours.flip, "SSIM": ours.ssim,
                         "99.9 % are within": ours.error_99_9, "mean ratio": ours.mean_ratio,
                         "not finite": ours.not_finite}.items():
        assert numbers(label) == [pytest.approx(value, rel=1e-8)], label
    assert numbers("relMSE") == pytest.approx([ours.rel_mse, ours.trimmed_rel_mse], rel=1e-8)
    assert numbers("differing pixels") == [ours.differing, 60 * 40] == [3, 60 * 40]
    assert numbers("all of them in") == list(ours.where) == [11, 7, 21, 31]
    assert numbers("the worst pixel")[:2] == list(ours.worst) == [11, 30]
    assert ours.max_of[2] == np.inf and ours.max_of[0] >= np.float32(.1) - 1e-6

    for path in (tmp_path / "a.png", tmp_path / "b.png"):
        ts.Image.from_array(image.linear if path.name == "b.png" else image.linear * .9).save(path)
    told = tessera("compare", tmp_path / "a.png", tmp_path / "b.png", "--metrics", check=False)
    ours = ts.compare(tmp_path / "a.png", tmp_path / "b.png")
    for label, value in {"linear rmse": ours.rmse, "SSIM": ours.ssim, "FLIP": ours.flip}.items():
        assert numbers(label) == [pytest.approx(value, rel=1e-8)], label


def ssim_of(a, b):
    """Wang et al. 2004, window by window."""
    def shown(light):
        grey = np.clip(light.astype("f8"), 0, 1) @ (.2126, .7152, .0722)
        return np.where(grey <= .0031308, 12.92 * grey, 1.055 * grey ** (1 / 2.4) - .055)
    a, b = shown(a), shown(b)
    line = np.exp(-np.arange(-5, 6) ** 2 / (2 * 1.5 ** 2))
    weights = np.outer(line, line) / line.sum() ** 2
    found = []
    for y in range(a.shape[0] - 10):
        for x in range(a.shape[1] - 10):
            p, q = a[y:y + 11, x:x + 11], b[y:y + 11, x:x + 11]
            mp, mq = (weights * p).sum(), (weights * q).sum()
            vp, vq, c = ((weights * d).sum() for d in ((p - mp) ** 2, (q - mq) ** 2, (p - mp) * (q - mq)))
            found.append((2 * mp * mq + 1e-4) * (2 * c + 9e-4) / ((mp ** 2 + mq ** 2 + 1e-4) * (vp + vq + 9e-4)))
    return np.mean(found)


@pytest.mark.parametrize("height, width", [(11, 11), (17, 23)])
def test_structural_similarity_is_that_of_the_paper(height, width):
    random = np.random.default_rng(height)
    a = random.uniform(-.1, 1.3, (height, width, 3)).astype("f4")
    b = (a + random.normal(0, .2, a.shape)).astype("f4")
    one, other = ts.Image.from_array(a), ts.Image.from_array(b)
    assert ts.compare(one, other).ssim == pytest.approx(ssim_of(a, b), rel=1e-12)
    assert ts.compare(other, one).ssim == ts.compare(one, other).ssim
    assert ts.compare(one, ts.Image.from_array(1 - a)).ssim < 0


def test_structural_similarity_of_small_pictures():
    dark, bright = (ts.Image.from_array([[value]]) for value in (0., 1.))
    assert ts.compare(dark, bright).ssim == pytest.approx(1e-4 / (1 + 1e-4))
    assert ts.compare(dark, dark).ssim == 1


def pickled(image, protocol):
    return pickle.loads(pickle.dumps(image, protocol))


def pickled_out_of_band(image):
    buffers = []
    data = pickle.dumps(image, 5, buffer_callback=buffers.append)
    assert sum(buffer.raw().nbytes for buffer in buffers) == 60 * 40 * 27 * 4 and len(data) < 10_000
    return pickle.loads(data, buffers=[bytes(buffer.raw()) for buffer in buffers])


@pytest.mark.parametrize("again_of", [copy.copy, copy.deepcopy, pickled_out_of_band,
                                      *(functools.partial(pickled, protocol=p) for p in (2, 3, 4, 5))])
def test_pictures_copy_and_pickle_with_all_that_they_know(image, again_of):
    again = again_of(image)
    assert again == image and again.sha256 == image.sha256 and again.aovs == image.aovs
    for name in image.aovs:
        assert np.array_equal(again.aov(name), image.aov(name)), name
    assert again.stats == image.stats and again.holes == image.holes
    assert again._picture.encode("x.exr", []) == image._picture.encode("x.exr", [])  # with what files tell


def test_a_picture_keeps_what_its_scene_asks_of_it():
    scene = ts.Scene(width=4, height=4, exposure=2, tone_map="filmic", background=(.3, .2, .1))
    image = scene.render(workers=0)
    again = pickle.loads(pickle.dumps(image))
    assert (again.to_srgb() == image.to_srgb()).all()
    assert (again.to_srgb() != ts.Image.from_array(image.linear).to_srgb()).any()


@pytest.mark.parametrize("at, wrong", [
    (0, ts.Array.from_bytes(b"", "f", [0, 4, 3])), (0, ts.Array.from_bytes(bytes(48), "f", [4, 3])),
    (0, ts.Array.from_bytes(bytes(96), "d", [2, 2, 3])), (1, 2**31 - 1), (2, -1), (3, 1), (3, 2**31), (4, b"?"),
])
def test_a_state_of_no_picture_is_refused(at, wrong):
    state = list(ts._core.picture_state(ts.Image.from_array(np.ones((2, 2, 3)))._picture))
    state[at] = wrong
    with pytest.raises(ts.UsageError, match="of no picture"):
        ts._core.picture_of_state(tuple(state))


def test_denoising_has_the_bits_of_the_command_line(tmp_path, tessera):
    tessera("render", KNOT, "--size", "60x40", "--spp", "4", "--denoise", "-o", tmp_path / "x.pfm")
    ours = ts.render(KNOT, workers=0, size=(60, 40), spp=4, denoise=True)
    assert (ts.read_image(tmp_path / "x.pfm").linear == ours.linear).all()
    with pytest.raises(ts.UsageError, match="denoise: one sample"):
        ts.render(KNOT, workers=0, spp=1, denoise=True)


def test_a_broken_file_is_told(tmp_path):
    (tmp_path / "x.png").write_bytes(b"nothing")
    with pytest.raises(ts.SceneError, match="x.png"):
        ts.read_image(tmp_path / "x.png")


def test_file_names_are_any_bytes_but_nul(tmp_path):
    image = ts.Image.from_array(np.full((2, 2, 3), .5, "f4"))
    for name in (os.fsdecode(b"caf\xe9"), "caf\u00e9"):
        picture, scene = tmp_path / f"{name}.exr", tmp_path / f"{name}.tessera"
        image.save(picture, os.fsencode(picture) + b".png")
        assert ts.read_image(picture) == image
        ts.Scene(width=3).save(scene)
        assert scene.read_bytes()
        assert ts.read_image(os.fsencode(picture)) == image
    unreadable = tmp_path / os.fsdecode(b"caf\xe9") / "a.png"
    with pytest.raises(ts.Error) as told:
        image.save(unreadable)
    assert str(unreadable) in str(told.value)
    (tmp_path / os.fsdecode(b"no\xe9.png")).write_bytes(b"no picture")
    with pytest.raises(ts.SceneError, match="no.*png"):
        ts.read_image(tmp_path / os.fsdecode(b"no\xe9.png"))


@pytest.mark.parametrize("name", ["zz\0.png", b"zz\0.png", "\ud800.png"])
def test_names_that_no_file_has(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    for save in (ts.Image.from_array(np.zeros((1, 1))).save, ts.Scene().save):
        with pytest.raises(ts.UsageError, match="^path: '.*; expected"):
            save(name)
    assert not [*tmp_path.iterdir()]


def test_names_in_scenes_and_options_are_utf_8(tmp_path):
    name = str(tmp_path / os.fsdecode(b"caf\xe9.tessera"))
    ts.Scene(width=2, height=2, spp=1).save(name)
    for call in (lambda: ts.load(name), lambda: ts.render(name), lambda: ts.ImageTexture(name),
                 lambda: ts.Farm(key=name), lambda: ts.render(ts.Scene(), camera="a\0b"),
                 lambda: ts.render(ts.Scene(), workers=0, resume=name)):
        with pytest.raises(ts.UsageError, match="^(scene|path|picture|key|camera|resume): '.*; expected text"):
            call()


CONFIG = """ocio_profile_version: 1
roles: {{scene_linear: plain, default: plain}}
displays:
  screen:
    - !<View> {{name: scaled, colorspace: scaled}}
colorspaces:
  - !<ColorSpace>
    name: plain
  - !<ColorSpace>
    name: scaled
    from_reference: !<MatrixTransform> {{matrix: [{0}, 0, 0, 0, 0, {0}, 0, 0, 0, 0, {0}, 0, 0, 0, 0, 1]}}
"""


def test_views_are_those_of_the_configuration_named_now(tmp_path, monkeypatch):
    picture = ts.Image.from_array(np.full((1, 2, 3), .8, "f4"))
    for name, scale in (("half", .5), ("quarter", .25)):
        (tmp_path / name).write_text(CONFIG.format(scale))
        monkeypatch.setenv("OCIO", str(tmp_path / name))
        assert (picture.to_srgb(ocio_view="scaled") == round(.8 * scale * 255)).all()
        monkeypatch.setenv("OCIO", str(tmp_path / "none"))
        with pytest.raises(ts.UsageError, match="none"):
            picture.to_srgb(ocio_view="scaled")
    monkeypatch.setenv("OCIO", str(tmp_path / "half"))
    (tmp_path / "half").write_text(CONFIG.format(.125) + "# edited\n")
    assert (picture.to_srgb(ocio_view="scaled") == round(.8 * .125 * 255)).all()
    os.mkfifo(tmp_path / "fifo")
    monkeypatch.setenv("OCIO", str(tmp_path / "fifo"))
    with pytest.raises(ts.UsageError, match="fifo': no regular file"):
        picture.to_srgb(ocio_view="scaled")


def test_sixteen_bits_keep_every_code(tmp_path):
    codes = np.arange(65536, dtype="u2").reshape(128, 512)
    image = ts.Image.from_array(codes)
    image.save(tmp_path / "a.png", tmp_path / "a.tif", bits=16)
    expected = np.repeat(codes[:, :, None], 3, axis=2)
    assert (decoded_png((tmp_path / "a.png").read_bytes()) == expected).all()
    for name in ("a.png", "a.tif"):
        assert np.abs(ts.read_image(tmp_path / name).linear - image.linear).max() < 2e-7


def test_sixteen_bits_are_shown_as_eight_are(image, tmp_path, tessera):
    image.save(tmp_path / "a.exr")
    image.save(tmp_path / "8.png", tmp_path / "c.exr", exposure=1, tone_map="filmic")
    image.save(tmp_path / "16.png", tmp_path / "b.exr", bits=16, exposure=1, tone_map="filmic")
    fine = decoded_png((tmp_path / "16.png").read_bytes())
    coarse = decoded_png((tmp_path / "8.png").read_bytes())
    assert fine.dtype == "u2" and len(np.unique(fine)) > 2 * len(np.unique(coarse))
    assert np.abs(fine / 257. - coarse).max() < .51
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()
    tessera("render", KNOT, "--size", "20x20", "--bits", "16", "-o", tmp_path / "cli.png", "--quiet")
    assert decoded_png((tmp_path / "cli.png").read_bytes()).dtype == "u2"


def test_bits_that_a_file_cannot_hold_are_refused(tmp_path):
    image = ts.Image.from_array(np.zeros((2, 2, 3)))
    with pytest.raises(ts.UsageError, match=r"bits 16: '.*a\.jpg' holds 8; expected one of \.png, "):
        image.save(tmp_path / "a.jpg", bits=16)
    with pytest.raises(ts.UsageError, match="^bits: '12'; expected one of 8, 16"):
        image.save(tmp_path / "a.png", bits=12)
    assert not list(tmp_path.iterdir())


def test_a_picture_of_uint16_is_not_rounded_unasked(tmp_path):
    for kind in ("u2", ">u2"):
        image = pickle.loads(pickle.dumps(ts.Image.from_array(np.full((2, 2), 300, kind))))
        for fine in (image, image.apply(lambda light: light / 2)):
            with pytest.raises(ts.UsageError, match="^bits: left out for '.*a.png', of a picture made of uint16"):
                fine.save(tmp_path / "b.exr", tmp_path / "a.png")
        assert not list(tmp_path.iterdir())
    image.save(tmp_path / "b.exr")
    image.save(tmp_path / "a.png", bits=8)
    assert decoded_png((tmp_path / "a.png").read_bytes()).max() == 1
    ts.Image.from_array(np.full((2, 2), 3, "u1")).save(tmp_path / "c.png")


def test_what_no_file_can_hold_is_told(image, tmp_path):
    with pytest.warns(ts.SceneWarning, match=r"^save: '.*a.png' cannot hold .*depth.*; expected an EXR") as told:
        image.save(tmp_path / "a.png", tmp_path / "a.hdr")
    assert [warning.filename for warning in told] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        image.save(tmp_path / "a.png", tmp_path / "a.exr")
        ts.Image.from_array(image.linear).save(tmp_path / "a.png")
