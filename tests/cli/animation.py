"""Reads the animations that the program writes: PNG and GIF of whole frames, shown for ever."""
import base64
import struct

from png import chunks, decode_png


def read_apng(path):
    """Its frames as read_png() gives them, and for how long each is shown: seconds as two whole numbers."""
    header, frames, delays, numbers = b"", [], [], []
    for name, body in chunks(path.read_bytes()):
        if name == b"IHDR":
            header = body
        elif name == b"acTL":
            count, plays = struct.unpack(">II", body)
            assert plays == 0
        elif name == b"fcTL":
            number, width, height, x, y, *delay, dispose, blend = struct.unpack(">IIIIIHHBB", body)
            assert (width, height, x, y, dispose, blend) == (*struct.unpack_from(">II", header), 0, 0, 0, 0)
            numbers.append(number)
            delays.append(tuple(delay))
            frames.append(b"")
        elif name == b"IDAT":
            assert len(frames) == 1
            frames[-1] += body
        elif name == b"fdAT":
            numbers.append(struct.unpack_from(">I", body)[0])
            frames[-1] += body[4:]
    assert numbers == list(range(2 * len(frames) - 1)) and count == len(frames)
    return [decode_png([(b"IHDR", header), (b"IDAT", each)]) for each in frames], delays


def unpacked(data, least):
    """The bytes of GIF's variant of LZW."""
    clear, end = 1 << least, (1 << least) + 1
    bits = have = 0
    out, table, width, before = bytearray(), [], least + 1, None
    for byte in data:
        bits |= byte << have
        have += 8
        while have >= width:
            code, bits, have = bits & ((1 << width) - 1), bits >> width, have - width
            if code == clear:
                table, width, before = [bytes([each]) for each in range(clear)] + [b"", b""], least + 1, None
                continue
            if code == end:
                return bytes(out)
            entry = table[code] if code < len(table) else before + before[:1]
            if before is not None and len(table) < 4096:
                table.append(before + entry[:1])
            if len(table) == 1 << width and width < 12:
                width += 1
            out += entry
            before = entry
    raise AssertionError("the picture has no end")


def read_gif(path):
    """The same of a GIF whose frames are whole; the times are hundredths of a second."""
    data = path.read_bytes()
    assert data[:6] == b"GIF89a" and b"NETSCAPE2.0\x03\x01\0\0\0" in data
    width, height, packed = struct.unpack_from("<HHB", data, 6)
    assert packed & 0x80 == 0
    at, frames, delays = 13, [], []

    def sub_blocks(at):
        body = b""
        while data[at]:
            body += data[at + 1:at + 1 + data[at]]
            at += 1 + data[at]
        return body, at + 1
    while data[at:at + 1] != b";":
        if data[at] == 0x21:
            kind = data[at + 1]
            body, at = sub_blocks(at + 2)
            if kind == 0xf9:
                assert body[0] == 4
                delays.append(struct.unpack_from("<H", body, 1)[0])
            continue
        assert data[at] == 0x2c and struct.unpack_from("<HHHH", data, at + 1) == (0, 0, width, height)
        colors = 2 << (data[at + 9] & 7)
        table = data[at + 10:at + 10 + 3 * colors]
        at += 10 + 3 * colors
        body, end = sub_blocks(at + 1)
        indices = unpacked(body, data[at])
        assert len(indices) == width * height
        frames.append((width, height, b"".join(table[3 * i:3 * i + 3] for i in indices)))
        at = end
    assert at + 1 == len(data)
    return frames, delays


def decoded_by_browser(page, path, kind):
    """The frames as a browser decodes them, and for how many microseconds it shows each."""
    data = base64.b64encode(path.read_bytes()).decode()
    page.call("Page.navigate", url=path.as_uri())  # a secure context, which decoders need
    frames = page.evaluate(f"""(async () => {{
        const data = Uint8Array.from(atob("{data}"), (each) => each.charCodeAt(0));
        const decoder = new ImageDecoder({{data, type: "{kind}", colorSpaceConversion: "none"}});
        await decoder.tracks.ready;
        await decoder.completed;
        const frames = [];
        for (let i = 0; i < decoder.tracks.selectedTrack.frameCount; ++i) {{
          const {{image}} = await decoder.decode({{frameIndex: i}});
          const {{displayWidth: width, displayHeight: height}} = image;
          const pixels = new Uint8Array(4 * width * height);
          await image.copyTo(pixels, {{format: "RGBA"}});
          let text = "";
          for (let at = 0; at < pixels.length; at += 4)
            text += String.fromCharCode(pixels[at], pixels[at + 1], pixels[at + 2]);
          frames.push([width, height, btoa(text), image.duration]);
        }}
        return frames;
      }})()""")
    return ([(width, height, base64.b64decode(text)) for width, height, text, _ in frames],
            [each[3] for each in frames])
