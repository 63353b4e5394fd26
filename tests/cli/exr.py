"""Reads what `tessera render -o x.exr` writes: scanlines of floats, packed by ZIP or not at all."""
import array
import struct
import zlib


def text_at(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def header_of(data):
    """The attributes, as bytes by name, and where they end."""
    assert data[:4] == b"\x76\x2f\x31\x01", "no OpenEXR file"
    attributes, at = {}, 8
    while data[at]:
        name, at = text_at(data, at)
        _, at = text_at(data, at)
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def unpacked(data, size):
    if len(data) == size:
        return data
    code = bytearray(zlib.decompress(data))
    for i in range(1, size):
        code[i] = (code[i - 1] + code[i] - 128) & 255
    half = (size + 1) // 2
    result = bytearray(size)
    result[0::2], result[1::2] = code[:half], code[half:]
    return bytes(result)


def read_exr(path):
    """(attributes as texts, {channel: floats in rows from the top})."""
    data = path.read_bytes()
    attributes, at = header_of(data)
    names, place, listed = [], 0, attributes["channels"]
    while listed[place]:
        name, place = text_at(listed, place)
        assert struct.unpack_from("<i", listed, place) == (2,), f"{name} is no float"
        place += 16
        names.append(name)
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    rows = {0: 1, 2: 1, 3: 16}[attributes["compression"][0]]
    channels = {name: array.array("f", bytes(4 * width * height)) for name in names}
    for chunk in range((height + rows - 1) // rows):
        offset, = struct.unpack_from("<q", data, at + 8 * chunk)
        first, size = struct.unpack_from("<ii", data, offset)
        first -= y0
        count = min(rows, height - first)
        block = unpacked(data[offset + 8:offset + 8 + size], 4 * width * count * len(names))
        values = array.array("f", block)
        for row in range(count):
            for i, name in enumerate(names):
                begin = (row * len(names) + i) * width
                to = (first + row) * width
                channels[name][to:to + width] = values[begin:begin + width]
    texts = {name: value.decode(errors="replace") for name, value in attributes.items()}
    return texts, channels
