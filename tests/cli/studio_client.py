"""A studio that is started for a test, and a page of it without a browser."""
import base64
import json
import os
import re
import socket
import struct
import subprocess
import time
import zlib

from tessera_process import PATIENCE


class Studio:
    """`tessera studio` as a process; `with` ends it."""

    def __init__(self, program, path, *options, env=None, http="127.0.0.1:0"):
        self.process = subprocess.Popen(
            [program, "studio", str(path), "--http", http, "--no-open", *options], text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            env={**os.environ, **(env or {})})
        line = self.process.stdout.readline()
        found = re.fullmatch(r"studio at (http://([^/]+)/)(?:#token=(\w+))?\n", line)
        if not found:
            raise AssertionError(f"no address but {line!r}; {self.process.stderr.read()}")
        self.url, self.address, self.token = found.groups()

    def connect(self, **hello):
        page = Page(self.address)
        page.say("hello", token=hello.pop("token", self.token), **hello)
        return page

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        try:
            self.process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


class Closed(Exception):
    """The connection has ended; `code` is that of its closing frame, or None."""

    def __init__(self, code=None, reason=""):
        super().__init__(f"closed with {code} {reason}")
        self.code = code


class Page:
    """One WebSocket (RFC 6455), and what came over it: messages as (kind, fields), pixels as Pixels."""

    def __init__(self, address, origin=None, host=None, path="/studio", protocol="tessera-studio.1"):
        name, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((name.strip("[]"), int(port)), timeout=PATIENCE)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.buffer = b""
        self.waiting = []
        origin = f"http://{address}" if origin is None else origin
        lines = [f"GET {path} HTTP/1.1", f"Host: {host or address}", "Upgrade: websocket",
                 "Connection: Upgrade", f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}",
                 "Sec-WebSocket-Version: 13"]
        lines += [f"Origin: {origin}"] if origin else []
        lines += [f"Sec-WebSocket-Protocol: {protocol}"] if protocol else []
        self.socket.sendall("\r\n".join(lines + ["", ""]).encode())
        while b"\r\n\r\n" not in self.buffer:
            self._more()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        self.status = int(head.split()[1])

    def _more(self):
        data = self.socket.recv(1 << 16)
        if not data:
            raise Closed()
        self.buffer += data

    def _take(self, count):
        while len(self.buffer) < count:
            self._more()
        data, self.buffer = self.buffer[:count], self.buffer[count:]
        return data

    def send_frame(self, opcode, payload):
        mask = os.urandom(4)
        head = bytes([0x80 | opcode])
        if len(payload) < 126:
            head += bytes([0x80 | len(payload)])
        elif len(payload) < 1 << 16:
            head += bytes([0x80 | 126]) + struct.pack(">H", len(payload))
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", len(payload))
        whole = (mask * (len(payload) // 4 + 1))[:len(payload)]
        masked = (int.from_bytes(payload, "big") ^ int.from_bytes(whole, "big")).to_bytes(len(payload), "big")
        self.socket.sendall(head + mask + masked)

    def say(self, kind, **fields):
        self.send_frame(1, json.dumps({kind: fields}).encode())

    def _receive(self, end):
        """The next message of the program, by that time."""
        while True:
            left = end - time.monotonic()
            if left <= 0:
                raise TimeoutError
            self.socket.settimeout(left)
            first, second = self._take(2)
            size = second & 127
            if size == 126:
                size = struct.unpack(">H", self._take(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self._take(8))[0]
            payload = self._take(size)
            opcode = first & 15
            if opcode == 8:
                raise Closed(struct.unpack(">H", payload[:2])[0], payload[2:].decode())
            if opcode == 9:
                self.send_frame(10, payload)
            elif opcode == 1:
                (kind, fields), = json.loads(payload).items()
                return kind, fields
            elif opcode == 2:
                return "pixels", Pixels(payload)

    def receive(self, *kinds, timeout=PATIENCE, where=lambda fields: True):
        """The fields of the next message of one of these kinds; others are kept for later."""
        for index, (kind, fields) in enumerate(self.waiting):
            if kind in kinds and where(fields):
                del self.waiting[index]
                return fields
        end = time.monotonic() + timeout
        while True:
            try:
                kind, fields = self._receive(end)
            except TimeoutError:
                raise AssertionError(f"none of {kinds} came, but {[k for k, _ in self.waiting]}") from None
            if kind in kinds and where(fields):
                return fields
            self.waiting.append((kind, fields))

    def forget(self):
        self.waiting.clear()

    def picture(self, pane=0, where=lambda pixels: True):
        """The first whole picture from here on whose last piece is like that: (last piece, rows of
        RGBA bytes)."""
        pieces = {}
        while True:
            piece = self.receive("pixels", where=lambda pixels: pixels.pane == pane)
            pieces.setdefault(piece.serial, []).append(piece)
            if not piece.flags & 1 or not where(piece):
                continue
            canvas = bytearray(piece.picture[0] * piece.picture[1] * 4)
            for each in pieces[piece.serial]:
                each.paint(canvas)
            return piece, bytes(canvas)

    def close(self):
        self.socket.close()


class Pixels:
    def __init__(self, data):
        (magic, self.kind, encoding, self.pane, self.scale, self.serial, self.x, self.y, self.width,
         self.height, picture_width, picture_height, self.version, self.samples,
         self.flags) = struct.unpack("<4sBBBBIHHHHHHIHH", data[:32])
        assert magic == b"TSPX"
        self.picture = (picture_width, picture_height)
        body = self.body = data[32:]
        if self.kind == 3:  # of a file
            return
        self.rgba = zlib.decompress(body, -15) if encoding == 1 else body
        assert len(self.rgba) == 4 * self.width * self.height

    def paint(self, canvas):
        row = 4 * self.width
        for y in range(self.height):
            at = 4 * ((self.y + y) * self.picture[0] + self.x)
            canvas[at:at + row] = self.rgba[y * row:(y + 1) * row]


