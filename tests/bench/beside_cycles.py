#!/usr/bin/env python3
"""Time to the same error beside Cycles (Debian's package blender), scene by scene, in turns.

  tests/bench/beside_cycles.py TESSERA [KIND...] [--samples 16] [--turns 3] [--size 512]

A knotted tube of 69,600 triangles stands on a floor; KIND says of what it is made and what lights it
(all unless told). Both programs get the same model, texture and picture of a sky, and 64 bounces, a
box filter, nothing clamped, denoised or stopped early. Times are of processors over four threads,
medians of the turns: of Cycles from the call of its renderer to the end, of ours the whole command,
loading and writing included. Errors are of each turn's
picture against the next one's, which has another seed. The last column
supposes that four times the samples halve the error. `means` is ours over that of Cycles.
"""
import argparse
import json
import math
import os
import re
import resource
import shutil
import statistics
import struct
import subprocess
import tempfile
import zlib

from timed_render import pixels

HERE = os.path.dirname(os.path.abspath(__file__))
THREADS = 4
FACTS = {
    "eye": [0, 2.6, 6.2], "target": [0, 1.25, 0], "width_over_distance": .8, "floor_half": 10,
    "lamp_side": 2, "lamp_height": 5, "lamp_radiance": 8,
    "under_lamp": ["lamp", "texture", "plastic", "metal", "glass", "tinted", "veil",
                   "frosted", "lens"],
    "sky": {"sky": 1, "lamp": .3, "texture": .3, "plastic": .3, "metal": .3, "glass": .3,
            "tinted": .3, "veil": .3, "frosted": .3, "lens": .3},
    "lens_radius": .15,
    "lamps": [[-6 + 1.2 * i, 4.5, -6 + 1.2 * j] for i in range(10) for j in range(10)],
    "small_lamp_side": .1, "small_lamp_radiance": 60,
    "balls": [[-1.6, .6, 1.5], [1.7, .5, 1.2], [0, 3.2, .4], [-1.2, 2.6, -1], [1.3, 2.9, .9]],
    "ball_radius": .05, "ball_radiance": 200, "mesh_radiance": 1,
    "absorption": [.5, 1.5, 4],
    "model": .6, "floor": .5, "glossy": [.8, .4, .2], "roughness": .3, "index": 1.5, "opacity": .5,
}
KINDS = {
    "sky": "under an even sky", "lamp": "under a lamp and that sky",
    "texture": "the floor with a texture", "plastic": "of glossy plastic",
    "metal": "of brushed metal", "glass": "of glass",
    "frosted": "of frosted glass", "tinted": "of tinted glass", "veil": "half of which is not there",
    "sun": "under a picture of a sky with a sun 5 degrees wide",
    "lights": "under a hundred small lamps", "lens": "under a lamp and that sky, through a lens",
    "balls": "with five small balls that shine", "mesh": "the model itself shines",
}


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    size = math.sqrt(sum(x * x for x in a))
    return tuple(x / size for x in a)


def tube(t, s):
    """A point of a trefoil's bumpy tube; t and s go around once."""
    def middle(t):
        return ((math.sin(t) + 2 * math.sin(2 * t)) * .42,
                (math.cos(t) - 2 * math.cos(2 * t)) * .42 + 1.4, -math.sin(3 * t) * .42)
    here, ahead = middle(t), middle(t + 1e-5)
    along = unit([b - a for a, b in zip(here, ahead)])
    side = unit(cross(along, (0, 0, 1)))
    up = cross(side, along)
    radius = .24 * (1 + .12 * math.sin(9 * s) * math.sin(40 * t))
    return tuple(m + radius * (math.cos(s) * a + math.sin(s) * b)
                 for m, a, b in zip(here, side, up))


def write_model(path, rings=348, sides=100):
    points = [[tube(2 * math.pi * i / rings, 2 * math.pi * j / sides) for j in range(sides)]
              for i in range(rings)]
    with open(path, "w", encoding="ascii") as file:
        for ring in points:
            for p in ring:
                file.write("v %.7f %.7f %.7f\n" % p)
        for i in range(rings):
            for j in range(sides):
                a, b = points[i][(j + 1) % sides], points[i][j - 1]
                c, d = points[(i + 1) % rings][j], points[i - 1][j]
                normal = unit(cross([x - y for x, y in zip(c, d)], [x - y for x, y in zip(a, b)]))
                file.write("vn %.6f %.6f %.6f\n" % normal)
        for i in range(rings):
            for j in range(sides):
                corners = [1 + (i + di) % rings * sides + (j + dj) % sides
                           for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
                for k in (0, 1, 2), (0, 2, 3):
                    file.write("f " + " ".join(f"{corners[n]}//{corners[n]}" for n in k) + "\n")


def write_floor(path, size=1024):
    rows = []
    for y in range(size):
        row = bytearray(b"\0")
        for x in range(size):
            light = (x // 32 + y // 32) % 2
            grain = (x * 73 ^ y * 151) % 32
            row += bytes((150 + 60 * light + grain, 120 + 80 * light, 90 + 90 * light))
        rows.append(bytes(row))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + \
            struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" +
                   chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(b"".join(rows))) + chunk(b"IEND", b""))


def write_sky(path, width=1024):
    """Radiance's format: blue above, brown below, and a sun."""
    def rgbe(r, g, b):
        fraction, exponent = math.frexp(max(r, g, b))
        scale = fraction * 256 / max(r, g, b)
        return bytes((int(r * scale), int(g * scale), int(b * scale), exponent + 128))
    sun = unit((.5, .7, .6))
    edge = math.cos(math.radians(2.5))
    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (width // 2, width))
        for y in range(width // 2):
            polar = math.pi * (y + .5) / (width // 2)
            for x in range(width):
                turn = 2 * math.pi * (x + .5) / width - math.pi
                way = (math.sin(polar) * math.sin(turn), math.cos(polar),
                       -math.sin(polar) * math.cos(turn))
                if sum(a * b for a, b in zip(way, sun)) > edge:
                    file.write(rgbe(900, 800, 600))
                elif way[1] > 0:
                    file.write(rgbe(.2 + .3 * way[1], .3 + .4 * way[1], .9))
                else:
                    file.write(rgbe(.2, .15, .1))


def vector(values):
    return " ".join(f"{axis}: {value}" for axis, value in zip("xyz", values))


def channels(values):
    return " ".join(f"{name}: {value}" for name, value in zip("rgb", values))


def colour(value):
    return channels([value] * 3)


def material_text(kind):
    f = FACTS
    rough = "roughness { value: %r }" % f["roughness"]
    base = "base_color { value { %s } } %s" % (channels(f["glossy"]), rough)
    index = "refractive_index: %r" % f["index"]
    return {
        "plastic": f"physical {{ {base} metallic {{ value: 0 }} }}",
        "metal": f"physical {{ {base} metallic {{ value: 1 }} }}",
        "glass": f"dielectric {{ {index} }}",
        "frosted": f"dielectric {{ {index} {rough} }}",
        "tinted": "dielectric { %s absorption { %s } }" % (index, channels(f["absorption"])),
        "veil": "classic { diffuse { value { %s } } } opacity { value: %r }"
                % (colour(f["model"]), f["opacity"]),
        "mesh": "classic { diffuse { value { } } emission { value { %s } } }"
                % colour(f["mesh_radiance"]),
    }.get(kind, "classic { diffuse { value { %s } } }" % colour(f["model"]))


def lamp_texts(middles, side, radiance):
    return ['materials { name: "lamp" sides: BACK_MATERIAL back: "black" classic { '
            "diffuse { value { } } emission { value { %s } } } }" % colour(radiance),
            'materials { name: "black" classic { diffuse { value { } } } }',
            *('nodes { shape { materials: "lamp" rectangle { corner { x: %r y: %r z: %r } '
              "edge_u { x: %r } edge_v { z: %r } } } }"
              % (x - side / 2, y, z - side / 2, side, side) for x, y, z in middles)]


def write_scene(path, kind):
    f = FACTS
    lens = "lens { radius_x: %r radius_y: %r focal_distance: %r samples: 1 }" % (
        f["lens_radius"], f["lens_radius"], math.dist(f["eye"], f["target"]))
    field = math.degrees(2 * math.atan(f["width_over_distance"] / 2))
    parts = [
        'settings { integrator { kind: "path" max_depth: 64 } sampling { filter: BOX } }',
        'cameras { name: "c" world_from_camera { steps { look_at { eye { %s } target { %s } } } } '
        "perspective { field_of_view: %r } %s }"
        % (vector(f["eye"]), vector(f["target"]), field, lens if kind == "lens" else ""),
        f'materials {{ name: "model" {material_text(kind)} }}',
        'includes { file: "model.obj" material: "model" geometry_only: true }',
    ]
    if kind == "sun":
        parts += ['textures { name: "sky" image { file: "sky.hdr" wrap_t: CLAMP } }',
                  'background { panorama { texture: "sky" } }']
    else:
        parts.append("background { solid { %s } }" % colour(f["sky"].get(kind, 0)))
    if kind == "texture":
        parts += ['textures { name: "floor" image { file: "floor.png" } }',
                  'materials { name: "floor" classic { diffuse { texture: "floor" '
                  "value { r: 1 g: 1 b: 1 } } } }"]
    else:
        parts.append('materials { name: "floor" classic { diffuse { value { %s } } } }'
                     % colour(f["floor"]))
    h = f["floor_half"]
    parts.append('nodes { shape { materials: "floor" rectangle { corner { x: %d z: %d } '
                 "edge_u { x: %d } edge_v { z: %d } } } }" % (-h, h, 2 * h, -2 * h))
    if kind in f["under_lamp"]:
        parts += lamp_texts([[0, f["lamp_height"], 0]], f["lamp_side"], f["lamp_radiance"])
    if kind == "lights":
        parts += lamp_texts(f["lamps"], f["small_lamp_side"], f["small_lamp_radiance"])
    if kind == "balls":
        parts.append('materials { name: "ball" classic { diffuse { value { } } '
                     "emission { value { %s } } } }" % colour(f["ball_radiance"]))
        parts += ['nodes { shape { materials: "ball" sphere { center { %s } radius: %r } } }'
                  % (vector(center), f["ball_radius"]) for center in f["balls"]]
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(parts) + "\n")


def difference(a, b):
    """Of one picture, from two of different seeds."""
    return math.sqrt(sum((x - y) ** 2 for x, y in zip(a, b)) / len(a) / 2)


class Ours:
    def __init__(self, program, folder, options):
        self.program, self.folder, self.options = program, folder, options

    def render(self, kind, seed):
        picture = os.path.join(self.folder, f"ours-{seed}.pfm")
        began = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([self.program, "render", os.path.join(self.folder, f"{kind}.tessera"),
                        "--workers", "0", "--threads", str(THREADS), "--quiet", "-o", picture,
                        "--seed", str(seed), "--spp", str(self.options.samples),
                        "--size", f"{self.options.size}x{self.options.size}"], check=True)
        now = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = now.ru_utime + now.ru_stime - began.ru_utime - began.ru_stime
        return pixels(picture), used / THREADS


class Cycles:
    def __init__(self, folder, options):
        self.folder, self.options = folder, options

    def render(self, kind, seed):
        picture = os.path.join(self.folder, f"cycles-{seed}.pfm")
        told = subprocess.run(
            ["blender", "--background", "--factory-startup", "--python-exit-code", "1",
             "--python", os.path.join(HERE, "cycles_model.py"), "--",
             os.path.join(self.folder, "cycles.exr"), self.folder, kind, "--pfm", picture,
             "--samples", str(self.options.samples), "--size", str(self.options.size),
             "--threads", str(THREADS), "--seed", str(seed), "--repeat", "1"],
            check=True, capture_output=True, text=True).stdout
        used = float(re.search(r"([\d.]+) s of processors", told)[1])
        return pixels(picture), used / THREADS


def measure(ours, cycles, kind, turns):
    times, pictures = {ours: [], cycles: []}, {ours: [], cycles: []}
    for turn in range(turns):
        for program in (cycles, ours):
            picture, used = program.render(kind, turn)
            times[program].append(used)
            pictures[program].append(picture)
    seconds = {p: statistics.median(t) for p, t in times.items()}
    error = {p: math.sqrt(statistics.mean(difference(a, b) ** 2 for a, b in zip(p_all, p_all[1:])))
             for p, p_all in pictures.items()}
    mean = {p: statistics.mean(sum(one) / len(one) for one in p_all)
            for p, p_all in pictures.items()}
    ratio = seconds[ours] / seconds[cycles] * (error[ours] / error[cycles]) ** 2
    print(f"| {KINDS[kind]} | {seconds[cycles]:.2f}, {error[cycles]:.4f} | {seconds[ours]:.2f}, "
          f"{error[ours]:.4f} | {ratio:.2f} | {mean[ours] / mean[cycles]:.4f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--size", type=int, default=512)
    options = parser.parse_args()
    if options.turns < 2:
        parser.error("--turns must be 2 or more: errors are told from two pictures")
    if options.samples < 1 or options.size < 16:
        parser.error("--samples must be 1 or more, --size 16 or more")
    for program in (options.program, "blender"):
        if not shutil.which(program):
            parser.error(f"there is no program '{program}'")
    for kind in options.kinds:
        if kind not in KINDS:
            parser.error(f"no scene '{kind}'; there are {', '.join(KINDS)}")
    with tempfile.TemporaryDirectory() as folder:
        write_model(os.path.join(folder, "model.obj"))
        write_floor(os.path.join(folder, "floor.png"))
        write_sky(os.path.join(folder, "sky.hdr"))
        with open(os.path.join(folder, "facts.json"), "w", encoding="ascii") as file:
            json.dump(FACTS, file)
        print("| scene | Cycles: seconds, error | ours: seconds, error | "
              "ours of Cycles' time to the same error | means |\n| --- | --- | --- | --- | --- |")
        for kind in options.kinds or KINDS:
            write_scene(os.path.join(folder, f"{kind}.tessera"), kind)
            measure(Ours(options.program, folder, options), Cycles(folder, options), kind,
                    options.turns)


if __name__ == "__main__":
    main()
