#!/usr/bin/env python3
"""`contains` by winding number on meshes with holes, against parity on the same meshes filled.

    PYTHONPATH=BUILD/python python3 tests/bench/winding_holes.py FILE...

Tessera reads files of OBJ, PLY and STL, meshio all others. Vertices at the same place become one. Each
hole is filled by a fan of triangles from the mean of its vertices; a loop of open edges that touches
itself at a vertex is two holes. Random points in the bounds, enlarged by a tenth, that are further
than .5 % of the diagonal from all triangles of the mesh are then looked up in both: in the mesh with
holes by its winding number, in the filled one by parity. They may be near fans, which are guesses; the
column "clear of fans" is of those further than .5 % from them too. Times are medians of one thread's
processor time, by turns, since others use the machine too.

Meshes that fans do not mend are left out, each with its reason:
- no edge is open;
- at an open edge several triangles meet, so that more is wrong than a hole;
- the fans' area is more than a part (--most-filled) of that of all triangles: an open sheet or a shell,
  of which a fan only guesses the inside.
"""
import argparse
import collections
import pathlib
import statistics
import time
import warnings

import numpy as np
import tessera as ts
from bench_table import seconds

CLEARANCE = .005  # of the diagonal


class LeftOut(Exception):
    """Why a mesh is not measured."""


def read(file):
    """The vertices as the renderer has them, no two at one place, and the triangles that have three."""
    if pathlib.Path(file).suffix.lower() in (".obj", ".ply", ".stl"):
        meshes = [node.shape for node in ts.load(file).nodes if isinstance(node.shape, ts.Mesh)]
    else:
        import meshio
        meshes = [ts.Mesh.from_(meshio.read(file))]
    if not meshes:
        raise LeftOut("it has no triangles")
    firsts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    # Adding 0 turns -0 into 0.
    positions, same = np.unique(np.concatenate([mesh.positions for mesh in meshes]) + np.float32(0),
                                axis=0, return_inverse=True)
    triangles = same[np.concatenate([np.asarray(mesh.triangles, np.int64) + first
                                     for mesh, first in zip(meshes, firsts)])]
    return positions, triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def loops_of(edges):
    """The loops that fill the holes which these edges surround, in the opposite direction. Each vertex
    is in a loop once."""
    after = collections.defaultdict(list)
    for begin, end in edges.tolist():
        after[end].append(begin)
    loops = []
    for vertex in list(after):
        path, place = [], {}
        while path or after[vertex]:
            if vertex in place:
                loop = path[place[vertex]:]
                del path[place[vertex]:]
                for each in loop:
                    del place[each]
                loops.append(loop)
            else:
                place[vertex] = len(path)
                path.append(vertex)
                vertex = after[vertex].pop()
    return loops


def areas(positions, triangles):
    a, b, c = np.moveaxis(positions[triangles].astype(float), 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def filled(positions, triangles, most_filled):
    """The mesh without its holes, whose fans follow its triangles, and how many open edges and holes
    there were."""
    edges = ts.Mesh(positions, triangles).open_edges().astype(np.int64)
    if not len(edges):
        raise LeftOut("it is closed")
    sides = np.sort(np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    keys = np.sort(sides @ [len(positions), 1])
    open_keys = np.sort(edges, axis=1) @ [len(positions), 1]
    several = np.searchsorted(keys, open_keys, "right") - np.searchsorted(keys, open_keys) > 1
    if several.any():
        raise LeftOut(f"several triangles meet at {several.sum()} of {len(edges)} open edges")
    loops = loops_of(edges)
    middles = np.array([positions[loop].mean(axis=0) for loop in loops], np.float32)
    fans = np.array([(begin, end, len(positions) + i) for i, loop in enumerate(loops)
                     for begin, end in zip(loop, loop[1:] + loop[:1])])
    all_positions = np.concatenate([positions, middles])
    share = areas(all_positions, fans).sum() / areas(positions, triangles).sum()
    if share > most_filled:
        raise LeftOut(f"the fans' area is {share:.0%} of the triangles'")
    whole = ts.Mesh(all_positions, np.concatenate([triangles, fans]))
    if not whole.is_closed:
        raise LeftOut("fans do not close it")
    return whole, len(edges), len(loops)


def halved(corners, longest):
    """The triangles, (n, 3, 3), cut into parts whose edges are no longer."""
    done = []
    while len(corners):
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        is_long = edges.max(axis=1) > longest
        done.append(corners[~is_long])
        corners, first = corners[is_long], edges[is_long].argmax(axis=1)
        a, b, c = (corners[np.arange(len(corners)), (first + i) % 3] for i in range(3))
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
    return np.concatenate(done)


def distances(points, corners):
    """Of each point to its triangle: (n, 3) and (n, 3, 3)."""
    edges = np.roll(corners, -1, axis=1) - corners
    to = points[:, None] - corners
    squares = np.einsum("nij,nij->ni", edges, edges)
    along = np.einsum("nij,nij->ni", to, edges) / np.where(squares > 0, squares, 1)
    nearest = np.linalg.norm(to - np.clip(along, 0, 1)[..., None] * edges, axis=2).min(axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    size = np.linalg.norm(normal, axis=1)
    is_above = (np.einsum("nij,nij->ni", np.cross(normal[:, None], edges), to) > 0).all(axis=1)
    height = np.abs(np.einsum("nj,nj->n", normal, to[:, 0])) / np.where(size > 0, size, 1)
    return np.where(is_above, height, nearest)


class Surface:
    """Triangles in a grid of cubes: each in all that it may come near to."""

    def __init__(self, corners, reach):
        self.reach, self.cell = reach, 4 * reach
        self.corners = halved(corners.astype(float), self.cell)
        self.origin = self.corners.min(axis=(0, 1)) - self.cell
        self.shape = self.cells(self.corners.max(axis=(0, 1)) + self.cell) + 1
        low = self.cells(self.corners.min(axis=1) - reach)
        high = self.cells(self.corners.max(axis=1) + reach)
        keys, owners = [], []
        for offset in np.ndindex(*(high - low).max(axis=0) + 1):
            owner = np.flatnonzero((low + offset <= high).all(axis=1))
            keys.append(self.keys(low[owner] + offset))
            owners.append(owner)
        keys, owners = np.concatenate(keys), np.concatenate(owners)
        order = np.argsort(keys, kind="stable")
        self.sorted_keys, self.owners = keys[order], owners[order]

    def cells(self, points):
        return np.floor((points - self.origin) / self.cell).astype(np.int64)

    def keys(self, cells):
        return np.ravel_multi_index(np.moveaxis(cells, -1, 0), self.shape, mode="clip")

    def is_far(self, points):
        """Which of the points are further than `reach` from all triangles."""
        keys = self.keys(self.cells(points))
        begin = np.searchsorted(self.sorted_keys, keys)
        count = np.searchsorted(self.sorted_keys, keys, "right") - begin
        which = np.repeat(np.arange(len(points)), count)
        pairs = np.arange(len(which)) + np.repeat(begin - (np.cumsum(count) - count), count)
        is_near = np.zeros(len(points), bool)
        for some in np.array_split(np.arange(len(which)), len(which) // 100_000 + 1):
            far = distances(points[which[some]], self.corners[self.owners[pairs[some]]]) > self.reach
            is_near[which[some][~far]] = True
        return ~is_near


def diagonal_of(points):
    return np.linalg.norm(np.ptp(points.reshape(-1, 3).astype(float), axis=0))


def far_points(corners, count, random):
    """Random points in the enlarged bounds that are far enough from the triangles."""
    surface = Surface(corners, CLEARANCE * diagonal_of(corners))
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    margin = (high - low) / 20
    found = np.empty((0, 3))
    while len(found) < count:
        points = random.uniform(low - margin, high + margin, (count, 3))
        found = np.concatenate([found, points[surface.is_far(points)]])
    return found[:count]


def measure(file, options):
    """The row of a mesh, without its name."""
    positions, triangles = read(file)
    whole, edges, holes = filled(positions, triangles, options.most_filled)
    points = far_points(positions[triangles], options.points, np.random.default_rng(0))
    tracers = [ts.Mesh(positions, triangles).tracer(threads=1), whole.tracer(threads=1)]

    def by_winding():
        return tracers[0].contains(points, method="winding")

    def by_parity():
        return tracers[1].contains(points)

    is_equal = by_winding() == by_parity()
    fans = whole.positions[whole.triangles[len(triangles):]]
    is_clear = Surface(fans, CLEARANCE * diagonal_of(positions)).is_far(points)
    taken = [[seconds(work, time.process_time) for work in (by_winding, by_parity)]
             for _ in range(options.rounds)]
    of_winding, of_parity = map(statistics.median, zip(*taken))
    return (len(triangles), edges, holes, is_equal.mean(), is_equal[is_clear].mean(),
            of_winding / of_parity)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--most-filled", type=float, default=.25, help="share of the area")
    options = parser.parse_args()
    warnings.simplefilter("ignore")  # of materials, views and rounding, which both meshes share
    rows, left_out = [], []
    print("| mesh | triangles | open edges | holes | agree | clear of fans | times parity |")
    print("| --- |" + " --- |" * 6)
    for file in options.files:
        name = pathlib.Path(file).stem
        try:
            row = measure(file, options)
        except (LeftOut, ts.Error) as reason:
            left_out.append(f"{name}: {reason}")
            continue
        rows.append(row)
        print("| {} | {:,} | {:,} | {:,} | {:.3%} | {:.3%} | {:.2f} |".format(name, *row), flush=True)
    agree, clear, times = zip(*(row[3:] for row in rows)) if rows else ((), (), ())
    print(f"of {len(rows)} meshes {sum(share >= .999 for share in agree)} agree at 99.9 % of the points, "
          f"{sum(share >= .999 for share in clear)} at 99.9 % of those clear of fans; "
          f"{sum(ratio <= 3 for ratio in times)} take at most 3 times as long as parity")
    for each in left_out:
        print("left out", each)


if __name__ == "__main__":
    main()
