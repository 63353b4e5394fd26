"""Small picture files of every kind of sample, byte by byte: no library in between changes them."""
import struct
import zlib


def codes(values, bits):
    return [round(value * (2 ** bits - 1)) for value in values]


def packed(samples, bits, order=">"):
    """A row of integers as PNG and TIFF pack them, the highest bit first."""
    if bits in (8, 16):
        return struct.pack(f"{order}{len(samples)}{'B' if bits == 8 else 'H'}", *samples)
    text = "".join(f"{sample:0{bits}b}" for sample in samples)
    text += "0" * (-len(text) % 8)
    return int(text, 2).to_bytes(len(text) // 8, "big")


def chunk(kind, data):
    """Of a PNG."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(pixel, bits, size=2):
    """All pixels alike; one to four channels."""
    color = {1: 0, 2: 4, 3: 2, 4: 6}[len(pixel)]
    row = b"\0" + packed(codes(pixel, bits) * size, bits)
    return (b"\x89PNG\r\n\x1a\n"
            + chunk(b"IHDR", struct.pack(">2I5B", size, size, bits, color, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(row * size)) + chunk(b"IEND", b""))


def tiff(pixel, kind, *extra, photometric=None, palette=None, size=2):
    """`kind`: bits of an integer, "half" or "float". `extra`: what TIFF 6.0 calls ExtraSamples, of the
    last channels: 0 anything, 1 associated alpha, 2 unassociated alpha. `palette`: the colours, each of
    three numbers; the first channel holds indices into them."""
    bits = {"half": 16, "float": 32}.get(kind, kind)
    letter = {"half": "e", "float": "f"}.get(kind)
    if letter:
        row = struct.pack(f"<{len(pixel) * size}{letter}", *(list(pixel) * size))
    else:
        row = packed(codes(pixel, bits) * size, bits, "<")
    data = row * size
    channels = len(pixel)
    if photometric is None:
        photometric = 3 if palette else 2 if channels - len(extra) == 3 else 1
    entries = [(256, 3, [size]), (257, 3, [size]), (258, 3, [bits] * channels), (259, 3, [1]),
               (262, 3, [photometric]), (273, 4, [8]), (277, 3, [channels]),
               (278, 3, [size]), (279, 4, [len(data)]), (284, 3, [1])]
    if palette:
        colors = [list(color) for color in palette] + [[0] * 3] * (2 ** bits - len(palette))
        entries.append((320, 3, codes([color[i] for i in range(3) for color in colors], 16)))
    if extra:
        entries.append((338, 3, list(extra)))
    entries.append((339, 3, [3 if letter else 1] * channels))
    at = 8 + len(data) + len(data) % 2
    more = at + 2 + 12 * len(entries) + 4
    table, values = b"", b""
    for tag, type_, numbers in entries:
        body = struct.pack(f"<{len(numbers)}{'H' if type_ == 3 else 'I'}", *numbers)
        if len(body) > 4:
            place, values = more + len(values), values + body
            body = struct.pack("<I", place)
        table += struct.pack("<HHI", tag, type_, len(numbers)) + body.ljust(4, b"\0")
    return (b"II*\0" + struct.pack("<I", at) + data + b"\0" * (len(data) % 2)
            + struct.pack("<H", len(entries)) + table + bytes(4) + values)


def exr(channels, kind="half", data=(0, 0, 1, 1), display=None, every=None):
    """`channels`: the value of each by its name, or a function of x and y. The windows are x0, y0, x1,
    y1, the last pixel inside. `every`: by name, each how many pixels and rows a channel has a sample."""
    return exr_parts({None: channels}, kind, data, display, every)


def exr_parts(parts, kind="half", data=(0, 0, 1, 1), display=None, every=None):
    """`parts`: by name, the channels of each, as exr() takes them; one that is called None is all."""
    def step(name):
        return (every or {}).get(name, 1)

    def attribute(name, type_, body):
        return name.encode() + b"\0" + type_.encode() + b"\0" + struct.pack("<I", len(body)) + body
    number, letter = (1, "e") if kind == "half" else (2, "f")
    height = data[3] - data[1] + 1
    is_single = None in parts

    def header(part, channels):
        listed = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", number, 0, step(name), step(name))
                          for name in sorted(channels)) + b"\0"  # in the order that the format wants
        of_part = b"" if is_single else (attribute("name", "string", part.encode())
                                         + attribute("type", "string", b"scanlineimage")
                                         + attribute("chunkCount", "int", struct.pack("<i", height)))
        return (attribute("channels", "chlist", listed)
                + attribute("compression", "compression", b"\0")
                + attribute("dataWindow", "box2i", struct.pack("<4i", *data))
                + attribute("displayWindow", "box2i", struct.pack("<4i", *(display or data)))
                + attribute("lineOrder", "lineOrder", b"\0")
                + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
                + attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
                + attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + of_part + b"\0")

    def line(index, channels, y):
        def value(name, x):
            given = channels[name]
            return given(x, y) if callable(given) else given
        body = b"".join(struct.pack(f"<{letter}", value(name, x)) for name in sorted(channels) if y % step(name) == 0
                        for x in range(data[0], data[2] + 1) if x % step(name) == 0)
        of_part = b"" if is_single else struct.pack("<i", index)
        return of_part + struct.pack("<ii", y, len(body)) + body
    head = (b"\x76\x2f\x31\x01" + struct.pack("<I", 2 if is_single else 2 | 0x1000)
            + b"".join(header(*part) for part in parts.items()) + (b"" if is_single else b"\0"))
    lines = [line(index, channels, y) for index, channels in enumerate(parts.values())
             for y in range(data[1], data[3] + 1)]
    offset, table = len(head) + 8 * len(lines), b""
    for each in lines:
        table += struct.pack("<Q", offset)
        offset += len(each)
    return head + table + b"".join(lines)


def pnm(pixel, most, is_text=False, size=2):
    """P1 to P6; `most` is the largest value, 1 that of a bitmap, where 1 is black."""
    samples = [round(value * most) for value in pixel] * size * size
    number = 4 if most == 1 else 5 if len(pixel) == 1 else 6
    if most == 1:
        samples = [1 - sample for sample in samples]
    head = f"P{number - 3 if is_text else number}\n{size} {size}\n" + (f"{most}\n" if most > 1 else "")
    if is_text:
        return (head + " ".join(map(str, samples)) + "\n").encode()
    if most == 1:
        return head.encode() + packed(samples[:size], 1) * size
    return head.encode() + packed(samples, 8 if most < 256 else 16)


def pfm(pixel, size=2):
    head = f"{'PF' if len(pixel) == 3 else 'Pf'}\n{size} {size}\n-1.0\n".encode()
    return head + struct.pack(f"<{len(pixel) * size * size}f", *(list(pixel) * size * size))


def targa(pixel, attributes=3, size=2):
    """`attributes`: the type that the extension of version 2.0 tells, which a file of version 1 lacks: 0
    no alpha, 1 and 2 what is to be ignored, 3 alpha, 4 associated alpha; None: version 1."""
    stored = codes(pixel, 8)
    stored = stored[:1] if len(stored) == 1 else [stored[2], stored[1], stored[0], *stored[3:]]
    alpha_bits = 8 if len(pixel) == 4 else 0
    head = struct.pack("<3B5x4H2B", 0, 0, 3 if len(pixel) == 1 else 2, 0, 0, size, size,
                       8 * len(stored), 0x20 | alpha_bits)
    body = head + bytes(stored) * size * size
    if not alpha_bits or attributes is None:
        return body
    extension = bytearray(495)
    struct.pack_into("<H", extension, 0, 495)
    extension[494] = attributes
    return body + bytes(extension) + struct.pack("<II", len(body), 0) + b"TRUEVISION-XFILE.\0"


def sgi(pixel, bits, size=2):
    """Uncompressed, one plane after the other."""
    head = struct.pack(">HBBHHHHII", 474, 0, bits // 8, 3, size, size, len(pixel), 0, 2 ** bits - 1)
    return head.ljust(512, b"\0") + b"".join(packed([code] * size * size, bits)
                                             for code in codes(pixel, bits))


def bmp(pixel, masks=None, size=2):
    """32 bits. `masks`: the bits of red, green, blue and alpha, as version 4 of the header tells them;
    without, the fourth byte has no meaning."""
    red, green, blue, alpha = codes(pixel, 8)
    body = bytes((blue, green, red, alpha)) * size * size
    head = struct.pack("<IiiHHIIiiII", 108 if masks else 40, size, size, 1, 32, 3 if masks else 0,
                       len(body), 2835, 2835, 0, 0)
    if masks:
        head = (head + struct.pack("<4I", *masks) + b"BGRs").ljust(108, b"\0")
    at = 14 + len(head)
    return b"BM" + struct.pack("<I4xI", at + len(body), at) + head + body
