#!/usr/bin/env python3
"""Writes the sample models that no one writes by hand: vase.obj with its picture, nautilus.ply,
gear.stl and spheres.glb, and pictures: those of planets.tessera, cottage.x3dv and balloons.x3d. Run it in
this folder; the files have the same bytes every time."""
import json
import math
import random
import struct
import zlib

TAU = 2 * math.pi


def png(width, height, pixel, channels=3):
    """An RGB or RGBA picture; pixel(x, y) gives three or four numbers of 0 to 1."""
    rows = b"".join(b"\0" + bytes(round(255 * min(max(c, 0), 1)) for x in range(width)
                                  for c in pixel(x, y)) for y in range(height))

    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels],
                                                              0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def mix(a, b, t):
    return [x + (y - x) * t for x, y in zip(a, b)]


# ------------------------------------------------------------------------------------ vase.obj

def vase_pixel(x, y):
    u, v = x / 256, 1 - (y + .5) / 256
    glaze, clay, blue = (.93, .91, .84), (.62, .33, .2), (.1, .2, .45)
    petal = math.cos(8 * TAU * u) * .035
    leaf = abs(math.sin(8 * TAU * u)) ** 3
    if v < .12 + petal * .5:
        return clay
    if abs(v - .55) < .1 + petal:
        return mix(blue, glaze, leaf * .9)
    if abs(v - .3 - petal) < .012 or abs(v - .8 + petal) < .012:
        return blue
    return glaze if v < .93 else clay


def vase_height(x, y):
    u, v = x / 256, (y + .5) / 256
    return [.5 + .5 * math.sin(TAU * 24 * v) * (.6 + .4 * math.cos(TAU * 16 * u))] * 3


def write_vase():
    profile = [(.3, 0), (.34, .02), (.4, .1), (.52, .35), (.6, .62), (.58, .85), (.42, 1.1), (.27, 1.28),
               (.24, 1.38), (.3, 1.5), (.38, 1.56), (.34, 1.56), (.22, 1.4)]
    fine = []
    for i in range(len(profile) - 1):  # Catmull-Rom through the points
        p = [profile[max(i - 1, 0)], profile[i], profile[i + 1], profile[min(i + 2, len(profile) - 1)]]
        for k in range(5):
            t = k / 5
            fine.append([.5 * (2 * p[1][a] + (p[2][a] - p[0][a]) * t +
                               (2 * p[0][a] - 5 * p[1][a] + 4 * p[2][a] - p[3][a]) * t * t +
                               (3 * p[1][a] - p[0][a] - 3 * p[2][a] + p[3][a]) * t ** 3)
                         for a in range(2)])
    fine.append(profile[-1])
    around, rows = 48, len(fine)
    lines = ["# A vase with a painted glaze.", "mtllib vase.mtl", "o vase", "usemtl glaze", "s 1"]
    for r, h in fine:
        for j in range(around):
            lines.append(f"v {max(r, 0) * math.cos(TAU * j / around):.5f} {h:.5f} "
                         f"{max(r, 0) * math.sin(TAU * j / around):.5f}")
    for i in range(rows):
        for j in range(around + 1):
            lines.append(f"vt {j / around:.5f} {i / (rows - 1):.5f}")
    for i in range(rows - 1):
        for j in range(around):
            a, b = i * around + j + 1, i * around + (j + 1) % around + 1
            s = i * (around + 1) + j + 1
            lines.append(f"f {a}/{s} {a + around}/{s + around + 1} {b + around}/{s + around + 2} {b}/{s + 1}")
    n = rows * around
    lines += ["o table", "usemtl table", "s off"]
    for x, z in ((-1.2, -1.1), (-1.2, 1.1), (1.2, 1.1), (1.2, -1.1)):
        lines.append(f"v {x} 0 {z}")
    lines.append(f"f {n + 1} {n + 2} {n + 3} {n + 4}")
    open("vase.obj", "w").write("\n".join(lines) + "\n")
    open("vase.mtl", "w").write("""newmtl glaze
Ka .8 .8 .8
Kd 1 1 1
map_Kd vase.png
map_Pr -imfchan r -mm 0 .5 vase_relief.png
Pm 0
Pc .8
Pcr .03
map_Bump -bm .12 vase_relief.png

newmtl table
Ka .3 .24 .2
Kd .3 .22 .17
Ks .2 .2 .2
Ns 60
illum 3
""")
    open("vase.png", "wb").write(png(256, 256, vase_pixel))
    open("vase_relief.png", "wb").write(png(256, 256, vase_height))


# ------------------------------------------------------------------------------ planets.tessera

def write_moon():
    """Normals of a ball with craters, x along its rows and y up."""
    width, height, draw = 256, 128, random.Random(4)
    craters = []
    for i in range(110):
        y = draw.uniform(-.95, .95)
        size = .04 + .2 * draw.random() ** 4
        craters.append((TAU * draw.random(), y, size))

    def rise(u, v):
        lat, lon = math.pi * (v - .5), TAU * u
        sin, cos = math.sin(lat), math.cos(lat)
        h = 0
        for at, y, size in craters:
            d = sin * y + cos * math.sqrt(1 - y * y) * math.cos(lon - at)
            if d < .8 or (r := math.acos(min(d, 1)) / size) > 1.7:
                continue
            bowl = min(0, r * r - .85) if r < 1 else .15 * ((1.7 - r) / .7) ** 2
            h += size * .5 * max(bowl, -.55)
        return h

    def normal(x, y):
        u, v, e = (x + .5) / width, 1 - (y + .5) / height, 1 / width
        across = TAU * math.cos(math.pi * (v - .5))
        dx = (rise(u + e, v) - rise(u - e, v)) / (2 * e * max(across, .05))
        dy = (rise(u, v + e) - rise(u, v - e)) / (2 * e * math.pi)
        size = math.sqrt(dx * dx + dy * dy + 1)
        # Few steps make a small file.
        return [(128 + 4 * round(31 * c / size)) / 255 for c in (-dx, -dy, 1)]

    open("moon.png", "wb").write(png(width, height, normal))


# -------------------------------------------------------------------- cottage.x3dv, balloons.x3d

def write_cottage_pictures():
    draw = random.Random(2)
    shades = [draw.uniform(.75, 1) for _ in range(64)]

    def shingle(x, y):
        row, v = y // 16, y % 16 / 16
        at = (x + 8 * (row % 2)) % 64
        u = at % 16 / 16
        edge = .78 + .22 * (1 - (2 * u - 1) ** 2)  # rounded at its lower end
        shade = shades[(at // 16 + 5 * row) % 64] * (.72 + .35 * v)
        return [c * (shade if v < edge else .45) for c in (.68, .3, .2)]

    def brick(x, y):
        row = y // 16
        at = (x + 16 * (row % 2)) % 64
        if y % 16 < 2 or at % 32 < 2:
            return .78, .74, .68
        shade = shades[(at // 32 + 7 * row) % 64] * (.96 + .04 * draw.random())
        return [c * shade for c in (.8, .52, .4)]

    leaves = [(draw.gauss(0, .42), draw.gauss(0, .5), draw.uniform(.07, .16), draw.random()) for _ in range(420)]
    leaves = [(.5 + .38 * x, .46 - .36 * y, r * .55, c) for x, y, r, c in leaves if x * x + y * y < .95]

    def tree(x, y):
        u, v = (x + .5) / 128, (y + .5) / 128
        for lx, ly, r, c in reversed(leaves):
            d = (u - lx) ** 2 + (v - ly) ** 2
            if d < r * r:
                shade = (.6 + .4 * (ly - v + r) / (2 * r)) * (.75 + .25 * (1 - ly)) * (.8 + .2 * c)
                return *(round(16 * shade * k) / 16 for k in mix((.2, .46, .14), (.36, .56, .16), c)), 1
        trunk = abs(u - .5) < .03 + .02 * max(0, v - .85) / .15 and v > .5
        return (.32, .22, .14, 1) if trunk else (.25, .45, .15, 0)

    open("shingles.png", "wb").write(png(64, 64, shingle))
    open("bricks.png", "wb").write(png(64, 64, brick))
    open("tree.png", "wb").write(png(128, 128, tree, 4))


def write_balloon_picture():
    """Four patterns, one above the other: u goes round a balloon, v up."""
    red, gold, cream, blue, green = ((.78, .14, .1), (.96, .7, .16), (.97, .92, .8), (.12, .3, .62), (.12, .48, .42))

    def cloth(x, y):
        k, u, v = 3 - y // 64, x / 128, 1 - (y % 64 + .5) / 64
        gore = int(u * 16)
        if k == 0:
            return (red, gold, cream, gold)[gore % 4] if .18 < v < .9 else red
        if k == 1:
            wave = .5 + .09 * abs(math.sin(8 * math.pi * u))
            return blue if v > wave + .12 else cream if v > wave else gold if v > wave - .12 else blue
        if k == 2:
            return (green, cream)[(gore + int(v * 12)) % 2] if .25 < v < .8 else green
        return (red, (.93, .42, .12), gold, (.3, .6, .3), blue, (.4, .2, .5))[min(5, int(6 * (1 - v)))]

    open("balloons.png", "wb").write(png(128, 256, cloth))


# -------------------------------------------------------------------------------- nautilus.ply

def write_nautilus():
    around, along, turns = 26, 150, 2.6
    vertices, faces = [], []

    def point(i, j):
        t = i / (along - 1)
        grow = math.exp(1.75 * (t - 1) * turns * .62)
        a, b = TAU * turns * t, TAU * j / around
        rib = 1 + .035 * math.cos(TAU * 34 * t) * (1 - .3 * math.cos(b))
        r, tube = .5 * grow, .45 * grow * rib
        out = r + tube * math.cos(b)
        return [out * math.cos(a), out * math.sin(a), 1.1 * tube * math.sin(b)]

    for i in range(along):
        for j in range(around):
            p, e = point(i, j), 1e-4
            du = [x - y for x, y in zip(point(i + e, j), p)]
            dv = [x - y for x, y in zip(point(i, j + e), p)]
            n = [du[1] * dv[2] - du[2] * dv[1], du[2] * dv[0] - du[0] * dv[2], du[0] * dv[1] - du[1] * dv[0]]
            size = -math.sqrt(sum(c * c for c in n))
            t = i / (along - 1)
            flame = math.sin(TAU * 15 * t + 1.5 * math.cos(TAU * j / around))
            stripe = max(0, flame) ** .7 * (1 - t) ** .35 * (.5 + .5 * math.cos(TAU * j / around))
            color = mix((246, 236, 216), (158, 72, 28), min(1, 1.5 * stripe))
            vertices.append(struct.pack("<6f3B", *p, *(c / size for c in n), *(round(c) for c in color)))
    for i in range(along - 1):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            faces.append(struct.pack("<B4H", 4, a, b, b + around, a + around))
    head = "ply\nformat binary_little_endian 1.0\ncomment a shell\n"
    head += f"element vertex {len(vertices)}\n"
    head += "".join(f"property float {p}\n" for p in ("x", "y", "z", "nx", "ny", "nz"))
    head += "".join(f"property uchar {p}\n" for p in ("red", "green", "blue"))
    head += f"element face {len(faces)}\nproperty list uchar ushort vertex_indices\nend_header\n"
    open("nautilus.ply", "wb").write(head.encode() + b"".join(vertices) + b"".join(faces))


# ------------------------------------------------------------------------------------ gear.stl

def write_gear():
    teeth, steps = 18, 6
    ring = []
    for i in range(teeth * steps):
        phase = i % steps / steps
        wave = min(1, max(0, 1.6 * math.sin(TAU * phase) + .5))
        ring.append((TAU * i / (teeth * steps), .84 + .16 * wave))
    n, triangles = len(ring), []

    def level(scale, height):
        return [(scale * r * math.cos(a), scale * r * math.sin(a), height) for a, r in ring]

    def circle(radius, height):
        return [(radius * math.cos(a), radius * math.sin(a), height) for a, _ in ring]

    # Around the profile from the hub's bore over the rim and back; each pair makes a band.
    loops = [circle(.18, .24), circle(.34, .24), circle(.36, .22), circle(.36, .12), circle(.66, .12),
             circle(.7, .17), level(.975, .17), level(1, .145), level(1, -.145), level(.975, -.17),
             circle(.7, -.17), circle(.66, -.12), circle(.36, -.12), circle(.36, -.22),
             circle(.34, -.24), circle(.18, -.24), circle(.18, .24)]
    for upper, lower in zip(loops, loops[1:]):
        for i in range(n):
            j = (i + 1) % n
            triangles += [(upper[i], lower[i], lower[j]), (upper[i], lower[j], upper[j])]
    with open("gear.stl", "wb") as out:
        out.write(b"solid? no: a binary file of a gear".ljust(80) + struct.pack("<I", len(triangles)))
        for t in triangles:
            out.write(struct.pack("<12fH", 0, 0, 0, *t[0], *t[1], *t[2], 0))


# --------------------------------------------------------------------------------- spheres.glb

def write_spheres():
    binary, views, accessors = b"", [], []

    def view(data):
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data + b"\0" * (-len(data) % 4)
        return len(views) - 1

    def accessor(kind, component, values, fmt, **more):
        flat = [c for v in values for c in (v if isinstance(v, tuple) else (v,))]
        accessors.append({"bufferView": view(struct.pack(f"<{len(flat)}{fmt}", *flat)), "type": kind,
                          "componentType": component, "count": len(values), **more})
        return len(accessors) - 1

    rings, around = 24, 48
    points = [(math.sin(math.pi * i / rings) * math.cos(TAU * j / around), math.cos(math.pi * i / rings),
               math.sin(math.pi * i / rings) * math.sin(TAU * j / around))
              for i in range(rings + 1) for j in range(around + 1)]
    corners = []
    for i in range(rings):
        for a in range(i * (around + 1), i * (around + 1) + around):
            corners += [a, a + 1, a + around + 2] if i > 0 else []  # at the poles one will do
            corners += [a, a + around + 2, a + around + 1] if i < rings - 1 else []
    sphere = {"POSITION": accessor("VEC3", 5126, points, "f", min=[-1] * 3, max=[1] * 3),
              "NORMAL": accessor("VEC3", 5120, [tuple(round(127 * c) for c in p) + (0,) for p in points], "b",
                                 normalized=True)}
    # Rows of normals are aligned to four bytes.
    views[-1]["byteStride"] = 4
    index = accessor("SCALAR", 5123, corners, "H")
    floor = {"POSITION": accessor("VEC3", 5126, [(-9., 0., 9.), (9., 0., 9.), (9., 0., -9.), (-9., 0., -9.)],
                                  "f", min=[-9, 0, -9], max=[9, 0, 9]),
             "TEXCOORD_0": accessor("VEC2", 5126, [(0., 1.), (1., 1.), (1., 0.), (0., 0.)], "f")}

    def tile(x, y):
        edge = min(x % 32, y % 32)
        base = (.5, .46, .42) if (x // 32 + y // 32) % 2 else (.16, .2, .24)
        return mix((.05, .05, .05), base, min(1, edge / 1.5)) if edge < 2 else base

    image = view(png(64, 64, tile))
    colors = [(1, .77, .34), (.95, .64, .54), (.56, .57, .58)]
    materials = [{"name": "floor", "pbrMetallicRoughness": {
        "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [9, 9]}}},
        "metallicFactor": 0, "roughnessFactor": .35}}]
    nodes = [{"name": "floor", "mesh": 0}]
    meshes = [{"name": "floor", "primitives": [{"attributes": floor, "material": 0, "mode": 6}]}]

    def ball(name, x, y, z, radius, material):
        materials.append({"name": name, **material})
        meshes.append({"name": name, "primitives": [
            {"attributes": sphere, "indices": index, "material": len(materials) - 1}]})
        nodes.append({"name": name, "mesh": len(meshes) - 1, "translation": [x, y, z], "scale": [radius] * 3})
        return len(meshes) - 1

    for row, color in enumerate(colors):
        for column in range(4):
            ball(f"metal {row} {column}", -2.4 + 1.1 * column, .5, -1.1 * row, .5, {"pbrMetallicRoughness": {
                "baseColorFactor": [*color, 1], "metallicFactor": 1, "roughnessFactor": .08 + .24 * column}})
    ball("glass", 1.75, .8, .5, .8, {
        "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.5},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 1.2,
                                     "attenuationColor": [.55, .9, .8]}}})
    glow = ball("glow", -1.7, .16, 1.1, .16, {"emissiveFactor": [1, .5, .15], "extensions": {
        "KHR_materials_emissive_strength": {"emissiveStrength": 1.5}}})
    nodes += [{"mesh": glow, "translation": [-1 + .7 * i, .16, 1.15 + .12 * i], "scale": [.16] * 3}
              for i in range(3)]
    half = math.radians(-20) / 2
    nodes += [{"name": "eye", "camera": 0, "translation": [.1, 3.2, 6.6], "rotation": [math.sin(half), 0, 0, math.cos(half)]},
              {"name": "lamp", "translation": [-3, 5, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"name": "window", "translation": [4, 6, 1], "rotation": [-.6, .35, .2, .69],
               "extensions": {"KHR_lights_punctual": {"light": 1}}}]
    lights = [{"type": "point", "color": [1, .85, .7], "intensity": 90},
              {"type": "spot", "color": [.75, .85, 1], "intensity": 160,
               "spot": {"innerConeAngle": .3, "outerConeAngle": .75}}]
    document = {
        "asset": {"version": "2.0", "generator": "make_models.py"}, "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
        "materials": materials, "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 10497, "wrapT": 10497}],
        "images": [{"name": "tiles", "bufferView": image, "mimeType": "image/png"}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": .62, "znear": .1}}],
        "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_ior",
                           "KHR_materials_transmission", "KHR_materials_volume",
                           "KHR_materials_emissive_strength"],
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    open("spheres.glb", "wb").write(
        b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(binary)) + struct.pack("<I", len(text)) + b"JSON" +
        text + struct.pack("<I", len(binary)) + b"BIN\0" + binary)


if __name__ == "__main__":
    write_vase()
    write_moon()
    write_cottage_pictures()
    write_balloon_picture()
    write_nautilus()
    write_gear()
    write_spheres()
