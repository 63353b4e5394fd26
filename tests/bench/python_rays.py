#!/usr/bin/env python3
"""Closest hits through Python against the loop of `tessera bench rays`, Embree, Open3D and mathutils.

    PYTHONPATH=BUILD/python python3 tests/bench/python_rays.py BUILD [--mesh FILE]... [--check]

Builds nothing: make the targets tessera_python and ray_loop first. For each mesh and set of rays all
contestants trace the same rays by turns, and medians are compared. Embree is called by ctypes on
arrays of float32; filling and reading its ray structures counts. Open3D gets its rays ready made.
Contestants that are not installed are left out.
"""
import argparse
import ctypes
import math
import pathlib
import statistics
import time

import numpy as np
import tessera as ts
from bench_table import Table, add_options, seconds

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


def soup(random, count):
    points = random.uniform(-1, 1, (count, 1, 3)) + random.uniform(-0.01, 0.01, (count, 3, 3))
    return points.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def join(parts):
    starts = np.cumsum([0] + [len(points) for points, _ in parts])
    return (np.concatenate([points for points, _ in parts]),
            np.concatenate([rows + start for (_, rows), start in zip(parts, starts)]))


def primary(eye, target, side):
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


def ray_sets(tracer, eye, target, random, side):
    """Numbers that single precision holds, so that all trace the same rays."""
    sets = {"primary": primary(eye, target, side)}
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


class Open3D:
    """The same mesh in Open3D's scene for rays, which are rows of six numbers there.

    Open3D 0.16 leaves the mask of its rays 0. Where Embree was built with ray masks, as Debian's is,
    no ray hits anything, and how long that takes means nothing.
    """

    def __init__(self, points, triangles):
        import open3d
        self.tensor = open3d.core.Tensor
        self.scene = open3d.t.geometry.RaycastingScene()
        self.scene.add_triangles(self.tensor(points), self.tensor(triangles))
        corners = points[triangles[:100]]
        middles = corners.mean(axis=1)
        directions = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.prepare(middles - directions, 2 * directions)
        if not np.isfinite(self.trace(1)[0]).any():
            raise ImportError("its cast_rays misses every triangle that it is aimed at")

    def prepare(self, origins, directions):
        self.rays = self.tensor(np.concatenate([origins, directions], axis=1).astype(np.float32))

    def trace(self, threads):
        hits = self.scene.cast_rays(self.rays, threads)
        return hits["t_hit"].numpy(), hits["primitive_ids"].numpy()


class Mathutils:
    """The same mesh in Blender's tree, asked ray by ray. Only Blender's own Python has it: without it
    the specification's figure is what is compared with."""

    SPECIFIED = .28e6  # rays a second

    def __init__(self, points, triangles):
        from mathutils.bvhtree import BVHTree
        self.tree = BVHTree.FromPolygons(points.tolist(), triangles.tolist())

    def rays_per_second(self, origins, directions):
        rays = list(zip(origins[:20_000].tolist(), directions[:20_000].tolist()))
        return len(rays) / seconds(lambda: [self.tree.ray_cast(o, d) for o, d in rays])


def contestants(points, triangles):
    """Those that are installed, by name."""
    made = {}
    for what in (Embree, Open3D, Mathutils):
        try:
            made[what.__name__] = what(points, triangles)
        except (ImportError, OSError) as error:
            if what not in _told_of:
                instead = (f"; {what.SPECIFIED:.3g} rays/s, the specification's figure, in its place"
                           if what is Mathutils else "")
                print(f"without {what.__name__}: {error}{instead}", flush=True)
            _told_of.add(what)
    return made


_told_of = set()


class Contest:
    """One mesh in every contestant that there is."""

    def __init__(self, build, points, triangles):
        points = np.ascontiguousarray(points, np.float32)
        triangles = np.ascontiguousarray(triangles, np.uint32)
        self.tracer = ts.Mesh(points, triangles).tracer(threads=1)
        self.loop = Loop(build, points, triangles)
        others = contestants(points, triangles)
        self.embree, self.open3d, self.mathutils = map(others.get, ("Embree", "Open3D", "Mathutils"))

    def works(self, origins, directions):
        """What is measured, and by which clock: work of one thread by its processor time, since
        others use the machine too."""
        single = origins.astype(np.float32), directions.astype(np.float32)
        self.loop.prepare(origins, directions)
        alone, wall = time.process_time, time.perf_counter
        plain = ("t", "primitive")  # what the loop and Embree give
        works = {"tessera": (lambda: self.tracer.intersect(origins, directions), alone),
                 "tessera, t and primitive": (
                     lambda: self.tracer.intersect(origins, directions, fields=plain), alone),
                 "tessera by the clock": (lambda: self.tracer.intersect(origins, directions), wall),
                 "tessera, 2": (lambda: self.tracer.intersect(origins, directions, threads=2), wall),
                 "loop": (self.loop.trace, alone)}
        if self.embree:
            works["embree"] = lambda: self.embree.trace(*single), alone
        if self.open3d:
            self.open3d.prepare(*single)
            works["open3d"] = lambda: self.open3d.trace(1), alone
            works["open3d, 2"] = lambda: self.open3d.trace(2), wall
        return works

    def check(self, origins, directions):
        """The loop has the same bits; the share of rays where others meet something else or nothing."""
        hits = self.tracer.intersect(origins, directions)
        t, primitive = self.loop.trace()
        assert np.array_equal(hits.t, t) and np.array_equal(hits.primitive, primitive)
        others = [contestant.trace(*arguments)[1] for contestant, *arguments in
                  ((self.embree, origins.astype(np.float32), directions.astype(np.float32)),
                   (self.open3d, 1)) if contestant]
        return max((float(np.mean((other == NONE) != ~hits.hit)) for other in others), default=0.0)


def trace_all(table, name, contest, sets, rounds):
    """A row for each set of rays, which only tells; returns all ratios."""
    ratios = []
    for kind, (origins, directions) in sets.items():
        works = contest.works(origins, directions)
        unlike = contest.check(origins, directions)
        taken = {what: [] for what in works}
        for _ in range(rounds):
            for what, (work, clock) in works.items():
                taken[what].append(seconds(work, clock))
        median = {what: statistics.median(of) for what, of in taken.items()}
        rate = len(origins) / median["tessera"]
        of_blender = (contest.mathutils.rays_per_second(origins, directions)
                      if contest.mathutils else Mathutils.SPECIFIED)
        of = {"loop": median["loop"] / median["tessera, t and primitive"],
              "loop, by all fields": median["loop"] / median["tessera"],
              "two threads": median["tessera by the clock"] / median["tessera, 2"],
              "mathutils": rate / of_blender}
        for other, ours in (("embree", "tessera"), ("open3d", "tessera"), ("open3d, 2", "tessera, 2")):
            if other in median:
                of[other] = median[other] / median[ours]
        ratios.append(of)
        told = ", ".join(f"{what} {ratio:.3f}" for what, ratio in of.items())
        table.add(f"P5 {name}, {kind}", rate * 1e-6, "Mrays/s", of=f"of {told}; unlike {unlike:.1e}")
    return ratios


def tell(table, ratios):
    """The limits: on the geometric mean of all rows, or on the least."""
    def least_and_mean(what):
        values = [of[what] for of in ratios if what in of]
        return values and (min(values), math.exp(statistics.fmean(map(math.log, values))))

    for what, name, of_least, of_mean in (
            ("loop", "the loop of tessera bench rays", .93, None),
            ("loop, by all fields", "the same loop, by all fields", None, None),
            ("embree", "Embree's rtcIntersect1M", .85, 1.0), ("two threads", "one thread, by two", None, 1.8),
            ("open3d", "Open3D's cast_rays, one thread", None, 1.0),
            ("open3d, 2", "Open3D's cast_rays, two threads", None, 1.0),
            ("mathutils", "mathutils.bvhtree", None, 20)):
        found = least_and_mean(what)
        if found:
            table.add(f"P5 of {name}: least", found[0], "", at_least=of_least)
            table.add(f"P5 of {name}: geometric mean", found[1], "", at_least=of_mean)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", help="the build folder")
    parser.add_argument("--mesh", action="append", default=[], help="a file that meshio reads")
    parser.add_argument("--only", action="append", help="of these meshes, by name")
    add_options(parser, 5)
    options = parser.parse_args()
    random = np.random.default_rng(0)
    count, side = (20_000, 64) if options.tiny else (1_000_000, 1024)
    scenes = [("room", *room(random), np.array([7.2, 2.2, 5.2]), np.array([3.0, 1.0, 2.5])),
              ("soup", *soup(random, count), np.array([2.0, 1.5, 2.5]), np.zeros(3))]
    for file in options.mesh:
        import meshio
        read = meshio.read(file)
        points, triangles = read.points[:, :3], read.cells_dict["triangle"]
        low, high = points.min(0), points.max(0)
        middle = (low + high) / 2
        scenes.append((pathlib.Path(file).stem, points, triangles,
                       middle + np.array([0.5, 0.4, 0.9]) * np.linalg.norm(high - low), middle))
    table, ratios = Table(), []
    for name, points, triangles, eye, target in scenes:
        if options.only and name not in options.only:
            continue
        contest = Contest(options.build, points, triangles)
        sets = ray_sets(contest.tracer, eye, target, np.random.default_rng(1), side)
        ratios += trace_all(table, name, contest, sets, options.rounds)
    tell(table, ratios)
    table.finish(options)


if __name__ == "__main__":
    main()
