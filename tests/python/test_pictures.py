"""Pictures as arrays and files."""
import json
import pathlib
import pickle
import struct
import zlib

import numpy as np
import pytest

import tessera as ts

KNOT = str(pathlib.Path(__file__).parents[2] / "scenes" / "samples" / "knot.tessera")


@pytest.fixture(scope="module")
def image():
    return ts.render(KNOT, workers=0, size=(70, 50), crop=(5, 4, 65, 44), spp=4, aovs="all")


def decoded_png(data):
    """The pixels of an RGB PNG of 8 bits whose rows are filtered in any way."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", body[:10])
            assert (bits, colour) == (8, 2)
        if kind == b"IDAT":
            packed += body
        at += length + 12
    raw = zlib.decompress(packed)
    out = np.zeros((height, width * 3), np.int64)
    above = np.zeros(width * 3, np.int64)
    for y in range(height):
        start = y * (1 + width * 3)
        kind, line = raw[start], np.frombuffer(raw, np.uint8, width * 3, start + 1).astype(np.int64)
        row = np.zeros(width * 3, np.int64)
        for x in range(width * 3):
            a, b, c = (row[x - 3], above[x], above[x - 3]) if x >= 3 else (0, above[x], 0)
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[x] = line[x] + (0, a, b, (a + b) // 2, paeth)[kind] & 255
        out[y] = above = row
    return out.reshape(height, width, 3).astype(np.uint8)


def test_shapes_and_types(image):
    assert image.linear.shape == (40, 60, 3) and image.linear.dtype == np.float32
    assert not image.linear.flags.writeable
    for name in ("albedo", "normal", "position", "variance"):
        assert image.aov(name).shape == (40, 60, 3) and image.aov(name).dtype == np.float32
    for name in ("depth", "samples"):
        assert image.aov(name).shape == (40, 60) and image.aov(name).dtype == np.float32
    assert image.aov("id").shape == (40, 60) and image.aov("id").dtype == np.uint32
    assert (image.aov("samples") == 4).all()
    with pytest.raises(ts.UsageError, match="no 'dept'"):
        image.aov("dept")


def test_light_without_aovs_is_a_view_of_the_film():
    plain = ts.render(KNOT, workers=0, size=(20, 10))
    first, second = plain._picture.channels("light"), plain._picture.channels("light")
    assert np.shares_memory(np.asarray(first), np.asarray(second))
    kept = plain.linear.copy()
    array = plain.linear
    del plain, first, second
    assert (array == kept).all()


def test_the_bytes_of_the_png(image, tmp_path):
    image.save(tmp_path / "x.png", tmp_path / "bright.png", exposure=1.5, tone_map="filmic")
    again = image.to_srgb(exposure=1.5, tone_map="filmic")
    assert (decoded_png((tmp_path / "x.png").read_bytes()) == again).all()
    assert (decoded_png(image._repr_png_()) == image.to_srgb()).all()
    assert image.to_srgb().dtype == np.uint8 and (again != image.to_srgb()).any()
    with pytest.raises(ts.UsageError, match="exposur: no option .* did you mean 'exposure'"):
        image.to_srgb(exposur=1)
    with pytest.raises(ts.UsageError, match="nowhere"):
        image.save(tmp_path / "nowhere" / "x.png")


def test_a_large_picture_is_shown_smaller():
    wide = ts.Image.from_array(np.ones((2, 5000, 3)))
    assert decoded_png(wide._repr_png_()).shape == (1, 1667, 3)


def test_aovs_are_the_channels_of_the_exr(image, tmp_path):
    image.save(tmp_path / "x.exr")
    names, values = ts._core.read_picture(str(tmp_path / "x.exr"))
    values = np.asarray(values)
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
    with pytest.raises(TypeError, match="numbers of type"):
        ts.Image.from_array(np.zeros((2, 2, 3), complex))


def test_pictures_are_compared():
    a = ts.Image.from_array(np.full((8, 8, 3), .5))
    b = ts.Image.from_array(np.full((8, 8, 3), .25))
    same = ts.compare(a, a)
    assert same == (0, 0, 0, 0, 0)
    metrics = ts.compare(a, b)
    assert metrics.max == metrics.mean == metrics.rmse == .25
    assert metrics.rel_mse == pytest.approx(.0625 / (.0625 + .01)) and metrics.flip > 0
    with pytest.raises(ts.UsageError, match="size 1x1; expected 8x8"):
        ts.compare(a, ts.Image.from_array(np.zeros((1, 1, 3))))


def test_pictures_pickle():
    made = ts.Image.from_array(np.arange(27.).reshape(3, 3, 3))
    for protocol in range(2, 6):
        assert pickle.loads(pickle.dumps(made, protocol)) == made


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
