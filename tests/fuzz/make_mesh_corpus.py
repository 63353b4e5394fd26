#!/usr/bin/env python3
"""Writes the seed corpus of mesh_fuzz, whose source says what the bytes mean.
usage: make_mesh_corpus.py FOLDER"""
import pathlib
import random
import struct
import sys

MESH, SPHERE, BOX, CSG, POINT, SUN, INSTANCE = 0, 2, 3, 6, 7, 8, 9
OBJECT, MOVED = 0x40, 0x80  # added to the kind of a node
STRIP, GLOWING = 1, 2  # of a mesh
CAMERA, EMBREE = 1, 2  # of the whole

# As in Numbers::number().
EXTREMES = {1e38: 14, 2.5e38: 18, -2.5e38: 19, 1e39: 24, 1e100: 26, 1e154: 29, 1.7e308: 32, -1.7e308: 33,
            5e-324: 34, 1e-310: 35}


def number(x):
    """The bytes of `x`: of an extreme, of an eighth of a small number, or of a float's bits."""
    if x in EXTREMES:
        return bytes([EXTREMES[x]])
    if -4 <= x < 4 and (x * 8).is_integer():
        return bytes([0x60 + int(x * 8)])
    return b"\xff" + struct.pack("<f", x)


def numbers(*values):
    return b"".join(number(float(x)) for x in values)


def mesh(positions, kind=0, triangles=None):
    count = triangles or len(positions) // 9
    assert 1 <= count <= 256
    return bytes([kind, count - 1]) + numbers(*positions)


def soup(seed, triangles, *reach):
    """Corners anywhere within `reach` of the origin on each axis."""
    numbers_of = random.Random(seed)
    return [numbers_of.uniform(-r, r) for _ in range(3 * triangles) for r in reach]


def move(by, scale=(1, 1, 1), axis=(0, 1, 0), angle=0):
    return numbers(*by, *axis, angle, *scale)


def inputs():
    whole = bytes([EMBREE])
    from_near = bytes([EMBREE | CAMERA]) + numbers(0, 0, 3.5, 0, 0, 0)
    sun = bytes([SUN]) + numbers(-1, -1, -2)
    most = 3.4028234e38
    yield "huge", whole + bytes([MESH]) + mesh(soup(1, 100, *[2.5e38] * 3))
    yield "largest", whole + bytes([MESH]) + mesh(soup(2, 200, *[most] * 3))
    yield "one_axis", whole + bytes([MESH]) + mesh(soup(3, 100, 3.4e38, 1, 1))
    yield "huge_and_tiny", (whole + bytes([MESH]) + mesh(soup(4, 60, *[2.5e38] * 3) + soup(5, 60, 1, 1, 1) +
                                                         soup(6, 60, *[1e-40] * 3)))
    yield "denormal", whole + bytes([MESH]) + mesh(soup(7, 100, *[1e-42] * 3))
    yield "strip", whole + bytes([MESH]) + mesh(soup(8, 34, *[2.5e38] * 3), STRIP, 100)
    yield "glowing", whole + bytes([MESH]) + mesh(soup(9, 40, *[2.5e38] * 3), GLOWING)
    small = mesh(soup(11, 20, 1, 1, 1))
    yield "instances", (from_near + sun + bytes([MESH | OBJECT]) + small +
                        b"".join(bytes([INSTANCE | MOVED]) + move(by, scale) + b"\0"
                                 for by, scale in [((0, 0, 0), (1, 1, 1)), ((1e38, 0, 0), (1e38, 1, 1)),
                                                   ((1e39, 0, 1), (1, 1, 1)), ((0, 1.7e308, 0), (1, 1, 1)),
                                                   ((1, 0, 1), (1e-310, 1, 1)), ((0, 1e154, 0), (1e100, 1e100, 1e100))]))
    yield "round", (from_near + sun + bytes([SPHERE]) + numbers(0, -2.5e38, 0, 2.5e38) + bytes([SPHERE]) + numbers(1, 1, 1, 5e-324) +
                    bytes([BOX]) + numbers(-2.5e38, -1, -1, 2.5e38, 1, 1) + bytes([CSG, 1]) +
                    numbers(-1, -1, -1, 1, 1, 1) + b"\0" + numbers(0, 0, 0, 0.5))
    lights = b"".join(bytes([POINT | MOVED]) + move((by, 0, 0), (s, s, s)) + numbers(by, 1, 1)
                      for by, s in [(1.7e308, 1), (1, 1), (-1.7e308, 1), (1e154, 1e154), (1e39, 1), (1.7e308, 1e100)])
    yield "lights", from_near + bytes([SPHERE]) + numbers(0, 0, 0, 1) + bytes([SUN]) + numbers(1, -1.7e308, 1) + lights


folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
for name, data in inputs():
    (folder / name).write_bytes(data)
