"""Reads the PNG files that the program writes: 8 bits, RGB or RGBA, not interlaced."""
import struct
import zlib


def chunks(data):
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    at = 8
    while at < len(data):
        size, = struct.unpack_from(">I", data, at)
        yield data[at + 4:at + 8], data[at + 8:at + 8 + size]
        at += size + 12


def unfiltered(rows, stride, step):
    """The bytes of all rows, of which each begins with the number of its filter."""
    before = bytearray(stride)
    out = bytearray()
    for start in range(0, len(rows), stride + 1):
        kind, row = rows[start], bytearray(rows[start + 1:start + 1 + stride])
        if kind:
            for i in range(stride):
                left = row[i - step] if i >= step else 0
                up = before[i]
                corner = before[i - step] if i >= step else 0
                if kind == 1:
                    guess = left
                elif kind == 2:
                    guess = up
                elif kind == 3:
                    guess = (left + up) // 2
                else:
                    estimate = left + up - corner
                    guess = min((left, up, corner), key=lambda each: abs(estimate - each))
                row[i] = (row[i] + guess) & 255
        out += row
        before = row
    return bytes(out)


def read_png(path):
    """Width, height and the RGB bytes of all rows from the top."""
    return decode_png(chunks(path.read_bytes()))


def decode_png(parts):
    """The same of pairs of a chunk's name and body."""
    packed = b""
    for name, body in parts:
        if name == b"IHDR":
            width, height, depth, kind, *_, interlaced = struct.unpack(">IIBBBBB", body)
            assert depth == 8 and kind in (2, 6) and not interlaced
        elif name == b"IDAT":
            packed += body
    step = 3 if kind == 2 else 4
    pixels = unfiltered(zlib.decompress(packed), width * step, step)
    if step == 4:
        pixels = without_alpha(pixels)
    return width, height, pixels


def without_alpha(rgba):
    rgb = bytearray(len(rgba) // 4 * 3)
    for channel in range(3):
        rgb[channel::3] = rgba[channel::4]
    return bytes(rgb)
