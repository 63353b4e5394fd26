#!/usr/bin/env python3
"""Closest hits through Python against the loop of `tessera bench rays` and against Embree.

    PYTHONPATH=BUILD/python python3 tests/bench/python_rays.py BUILD [--mesh FILE]... [--rounds N]

Builds nothing: make the targets tessera_python and ray_loop first. For each mesh and set of rays all
contestants trace the same rays by turns, and medians are compared. Embree is called by ctypes on
arrays of float32; filling and reading its ray structures counts.
"""
import argparse
import ctypes
import json
import math
import pathlib
import statistics
import time

import numpy as np
from tessera.rays import tracer_from_mesh

NONE = 0xFFFFFFFF


def subdivided_box(low, high, cells):
    """A closed box, each face in cells x cells pairs of triangles, its front outside."""
    points, triangles = [], []
    grid = np.linspace(0, 1, cells + 1)
    u, v = (a.ravel() for a in np.meshgrid(grid, grid, indexing="ij"))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij"))
    a = i * (cells + 1) + j
    b, c, d = a + cells + 1, a + cells + 2, a + 1
    for axis in range(3):
        for side in (0, 1):
            face = np.empty((len(u), 3))
            face[:, axis], face[:, (axis + 1) % 3], face[:, (axis + 2) % 3] = side, u, v
            order = ((a, b, c), (a, c, d)) if side else ((a, c, b), (a, d, c))
            base = sum(map(len, points))
            points.append(low + face * (np.asarray(high) - low))
            triangles += [base + np.stack(corners, 1) for corners in order]
    return np.concatenate(points), np.concatenate(triangles)


def room(random):
    """A room with forty boxes in it, seen from inside."""
    parts = [subdivided_box(np.zeros(3), np.array([8.0, 3.0, 6.0]), 40)]
    for _ in range(40):
        low = random.uniform([0.2, 0, 0.2], [7, 1.5, 5])
        parts.append(subdivided_box(low, low + random.uniform(0.1, 0.9, 3), 12))
    return join(parts)


def soup(random, count=1_000_000):
    points = random.uniform(-1, 1, (count, 1, 3)) + random.uniform(-0.01, 0.01, (count, 3, 3))
    return points.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def join(parts):
    starts = np.cumsum([0] + [len(points) for points, _ in parts])
    return (np.concatenate([points for points, _ in parts]),
            np.concatenate([rows + start for (_, rows), start in zip(parts, starts)]))


def primary(tracer, eye, target, side=1024):
    view = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(view, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, view)
    at = (np.arange(side) + 0.5) / side - 0.5
    # In tiles of 4 x 4, as a renderer would.
    x, y = np.meshgrid(at, -at)
    x, y = (a.reshape(side // 4, 4, side // 4, 4).swapaxes(1, 2).reshape(-1) for a in (x, y))
    d = view + x[:, None] * right + y[:, None] * up
    return np.broadcast_to(eye, d.shape).copy(), d / np.linalg.norm(d, axis=1, keepdims=True)


def scattered(tracer, origins, directions, random):
    """Rays from the hits of others, cosine-weighted about the normal; as many as those."""
    hits = tracer.intersect(origins, directions)
    kept = np.flatnonzero(hits.hit)
    kept = kept[np.sort(random.integers(0, len(kept), len(origins)))]
    normal = hits.normal[kept]
    normal = np.where(np.sum(normal * directions[kept], 1)[:, None] > 0, -normal, normal)
    ball = random.normal(size=normal.shape)
    d = normal + 0.999 * ball / np.linalg.norm(ball, axis=1, keepdims=True)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    size = np.linalg.norm(np.diff(tracer.bounds, axis=0))
    return hits.point[kept] + normal * (1e-5 * size), d


def ray_sets(tracer, eye, target, random):
    """Numbers that single precision holds, so that all trace the same rays."""
    sets = {"primary": primary(tracer, eye, target)}
    sets["diffuse"] = scattered(tracer, *sets["primary"], random)
    # Hemispheres of sixteen rays one after the other.
    few = [a[::16] for a in sets["primary"]]
    sets["ao"] = scattered(tracer, *(np.repeat(a, 16, axis=0) for a in few), random)
    order = random.permutation(len(sets["diffuse"][0]))
    sets["shuffled"] = tuple(a[order] for a in sets["diffuse"])
    return {name: tuple(a.astype(np.float32).astype(np.float64) for a in rays)
            for name, rays in sets.items()}


class Embree:
    """One mesh in Embree 3, quality and switches as they come."""

    RAY_HIT = np.dtype({"names": ["origin", "tnear", "direction", "time", "tfar", "mask", "id",
                                  "flags", "primitive", "geometry"],
                        "formats": ["3f4", "f4", "3f4", "f4", "f4", "u4", "u4", "u4", "u4", "u4"],
                        "offsets": [0, 12, 16, 28, 32, 36, 40, 44, 68, 72], "itemsize": 80})

    def __init__(self, points, triangles):
        self.lib = lib = ctypes.CDLL("libembree3.so.3")
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        for name, result, arguments in (
                ("rtcNewDevice", pointer, [ctypes.c_char_p]), ("rtcNewScene", pointer, [pointer]),
                ("rtcNewGeometry", pointer, [pointer, ctypes.c_int]),
                ("rtcSetNewGeometryBuffer", pointer,
                 [pointer, ctypes.c_int, ctypes.c_uint, ctypes.c_int, size, size]),
                ("rtcCommitGeometry", None, [pointer]),
                ("rtcAttachGeometry", ctypes.c_uint, [pointer, pointer]),
                ("rtcCommitScene", None, [pointer]),
                ("rtcIntersect1M", None, [pointer, pointer, pointer, ctypes.c_uint, size])):
            function = getattr(lib, name)
            function.restype, function.argtypes = result, arguments
        device = lib.rtcNewDevice(b"threads=1")
        self.scene = lib.rtcNewScene(device)
        geometry = lib.rtcNewGeometry(device, 0)
        for slot, form, array in ((1, 0x9003, points), (0, 0x5003, triangles)):
            to = lib.rtcSetNewGeometryBuffer(geometry, slot, 0, form, 12, len(array))
            ctypes.memmove(to, array.ctypes.data, array.nbytes)
        lib.rtcCommitGeometry(geometry)
        lib.rtcAttachGeometry(self.scene, geometry)
        lib.rtcCommitScene(self.scene)

    def trace(self, origins, directions):
        rays = np.zeros(len(origins), self.RAY_HIT)
        rays["origin"], rays["direction"] = origins, directions
        rays["tfar"], rays["mask"] = np.inf, NONE
        rays["geometry"] = rays["primitive"] = NONE
        # struct RTCIntersectContext: flags, filter, instance stack.
        context = (ctypes.c_uint64 * 4)(0, 0, NONE, 0)
        self.lib.rtcIntersect1M(self.scene, context, rays.ctypes.data, len(rays), 80)
        return rays["tfar"].copy(), rays["primitive"].copy()


class Loop:
    """The C++ loop over rays that lie ready."""

    def __init__(self, build, points, triangles):
        self.lib = lib = ctypes.CDLL(str(pathlib.Path(build) / "bin" / "ray_loop.so"))
        pointer, number = ctypes.c_void_p, ctypes.c_uint64
        lib.make_loop.restype, lib.make_loop.argtypes = pointer, [pointer, number, pointer, number]
        lib.make_rays.restype, lib.make_rays.argtypes = pointer, [pointer, pointer, number]
        lib.trace_loop.argtypes = [pointer] * 4
        self.loop = lib.make_loop(points.ctypes.data, len(points), triangles.ctypes.data,
                                  len(triangles))

    def prepare(self, origins, directions):
        self.count = len(origins)
        self.rays = self.lib.make_rays(origins.ctypes.data, directions.ctypes.data, self.count)

    def trace(self):
        t, primitive = np.empty(self.count), np.empty(self.count, np.uint32)
        self.lib.trace_loop(self.loop, self.rays, t.ctypes.data, primitive.ctypes.data)
        return t, primitive


def seconds(work, clock):
    start = clock()
    work()
    return clock() - start


def bench(name, points, triangles, eye, target, options):
    random = np.random.default_rng(1)
    points = np.ascontiguousarray(points, np.float32)
    triangles = np.ascontiguousarray(triangles, np.uint32)
    tracer = tracer_from_mesh(points, triangles, threads=1)
    embree, loop = Embree(points, triangles), Loop(options.build, points, triangles)
    rows = []
    for kind, (o, d) in ray_sets(tracer, eye, target, random).items():
        single = o.astype(np.float32), d.astype(np.float32)
        loop.prepare(o, d)
        hits = tracer.intersect(o, d)
        t, primitive = loop.trace()
        assert np.array_equal(hits.t, t) and np.array_equal(hits.primitive, primitive)
        unlike = np.mean((embree.trace(*single)[1] == NONE) != ~hits.hit)
        work = {"tessera": lambda: tracer.intersect(o, d),
                "tessera, 2 threads": lambda: tracer.intersect(o, d, threads=2),
                "loop": loop.trace, "embree": lambda: embree.trace(*single)}
        # Work of one thread by its processor time, since others use the machine too.
        work["tessera by the clock"] = work["tessera"]
        taken = {what: [] for what in work}
        for _ in range(options.rounds):
            for what, call in work.items():
                by_clock = what in ("tessera by the clock", "tessera, 2 threads")
                taken[what].append(seconds(call, time.perf_counter if by_clock
                                           else time.process_time))
        median = {what: statistics.median(of) for what, of in taken.items()}
        row = {"scene": name, "kind": kind, "rays": len(o),
               "mrays_per_second": len(o) * 1e-6 / median["tessera"],
               "ratio_to_loop": median["loop"] / median["tessera"],
               "ratio_to_embree": median["embree"] / median["tessera"],
               "ratio_of_two_threads": (median["tessera by the clock"]
                                        / median["tessera, 2 threads"]),
               "unlike_embree": float(unlike)}
        rows.append(row)
        print("{scene:10} {kind:9} {mrays_per_second:6.2f} Mrays/s, of the loop "
              "{ratio_to_loop:.3f}, of Embree {ratio_to_embree:.3f}, two threads "
              "{ratio_of_two_threads:.2f}".format(**row), flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", help="the build folder")
    parser.add_argument("--mesh", action="append", default=[], help="a file that meshio reads")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", action="append", help="of these meshes, by name")
    parser.add_argument("--json", help="write the rows there")
    options = parser.parse_args()
    random = np.random.default_rng(0)
    scenes = [("room", *room(random), np.array([7.2, 2.2, 5.2]), np.array([3.0, 1.0, 2.5])),
              ("soup", *soup(random), np.array([2.0, 1.5, 2.5]), np.zeros(3))]
    for file in options.mesh:
        import meshio
        read = meshio.read(file)
        points, triangles = read.points[:, :3], read.cells_dict["triangle"]
        low, high = points.min(0), points.max(0)
        middle = (low + high) / 2
        scenes.append((pathlib.Path(file).stem, points, triangles,
                       middle + np.array([0.5, 0.4, 0.9]) * np.linalg.norm(high - low), middle))
    rows = [row for scene in scenes if not options.only or scene[0] in options.only for row in bench(*scene, options)]
    for key in ("ratio_to_loop", "ratio_to_embree", "ratio_of_two_threads"):
        mean = math.exp(statistics.fmean(math.log(row[key]) for row in rows))
        print(f"{key}: geometric mean {mean:.3f}, least {min(row[key] for row in rows):.3f}")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"rows": rows}, indent=1))


if __name__ == "__main__":
    main()
