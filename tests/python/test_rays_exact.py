"""Ray queries against exact arithmetic and closed forms."""
from fractions import Fraction

import numpy as np
import pytest
from rays_scenes import rays_about, soup, tracer_of_mesh
from tessera.rays import tracer_from_scene

U = 2.0**-53


#: Coordinates are multiples of this, so that exact arithmetic is that of whole numbers.
STEP = 2.0**-40


def whole(vectors):
    """Rows as tuples of whole numbers of STEPs."""
    scaled = np.asarray(vectors, float) / STEP
    assert np.array_equal(scaled, np.rint(scaled))
    return [tuple(map(int, row)) for row in scaled.reshape(-1, 3).tolist()]


def minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def rounded(values, step):
    return np.rint(values / step) * step


@pytest.fixture(scope="module")
def triangles():
    """Compact ones, each far from the others, and 10^5 rays at their inner parts from two to six
    times their size away, none grazing: nearer or flatter ones lose more than a few bits of t."""
    random = np.random.default_rng(1)
    count, rays = 500, 100_000
    cells = np.stack(np.unravel_index(np.arange(count), (8, 8, 8)), 1) * 40.0 - 140
    turn = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    corner = np.array([[1, 0, 0], [-0.5, 0.8, 0], [-0.5, -0.8, 0]])
    corner = corner + random.uniform(-0.2, 0.2, (count, 3, 3))
    points = rounded(cells[:, None] + np.einsum("nij,nkj->nki", turn, corner), 2.0**-15)
    which = random.integers(0, count, rays)
    target = np.einsum("nk,nki->ni", random.dirichlet([3, 3, 3], rays), points[which])
    normal = np.cross(points[which, 1] - points[which, 0], points[which, 2] - points[which, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    lean = random.normal(size=(rays, 3))
    d = normal * random.choice([-1, 1], (rays, 1))
    d += 0.3 * lean / np.linalg.norm(lean, axis=1, keepdims=True)
    origins = target - d * random.uniform(4, 12, (rays, 1))
    return points, rounded(origins, STEP), rounded(d * random.uniform(0.1, 10, (rays, 1)), STEP)


def test_t_and_points_are_those_of_exact_arithmetic(triangles):
    points, origins, directions = triangles
    assert np.array_equal(points, points.astype(np.float32))
    tracer = tracer_of_mesh(points.reshape(-1, 3), np.arange(3 * len(points)).reshape(-1, 3))
    hits = tracer.intersect(origins, directions)
    assert hits.hit.all()
    a, b, c = (whole(points[:, k]) for k in range(3))
    e1, e2 = list(map(minus, b, a)), list(map(minus, c, a))
    normals = list(map(cross, e1, e2))
    worst = 0.0
    rays = zip(whole(origins), whole(directions), hits.t.tolist(), hits.primitive.tolist())
    for o, d, t, triangle in rays:
        along, from_a = dot(normals[triangle], d), minus(o, a[triangle])
        # That this triangle is the nearest is the test of all hits; here, that it is hit.
        q, sign = cross(from_a, d), 1 if along > 0 else -1
        u, v = -sign * dot(e2[triangle], q), sign * dot(e1[triangle], q)
        assert u >= 0 and v >= 0 and u + v <= abs(along)
        exact = Fraction(-dot(normals[triangle], from_a), along)
        worst = max(worst, float(abs(Fraction(t) / exact - 1)))
    assert worst <= 8 * U, worst / U
    point, error = hits.point, hits.point_error
    for i in range(0, len(origins), 10):
        triangle = hits.primitive[i]
        corner = [Fraction(x) for x in points[triangle, 0].tolist()]
        surface = minus([Fraction(x) for x in point[i].tolist()], corner)
        # The distance from the plane is within what the bounds on each axis add up to.
        reach = sum(abs(n) * Fraction(e) for n, e in zip(normals[triangle], error[i].tolist()))
        assert abs(dot(normals[triangle], surface)) <= reach


@pytest.mark.parametrize("lean", [1.0, 1e-4, 1e-8])
@pytest.mark.parametrize("distance", [10.0, 1e-3, 1e-7])
def test_the_surface_passes_within_the_error_of_points_that_graze_or_are_near(lean, distance):
    random = np.random.default_rng(11)
    points, rows = soup(random, 300)
    corners = points.astype(float)[rows]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = corners[:, 1] - corners[:, 0]
    directions = (flat / np.linalg.norm(flat, axis=1, keepdims=True)
                  + lean * normals / np.linalg.norm(normals, axis=1, keepdims=True))
    origins = corners.mean(1) - distance * directions
    hits = tracer_of_mesh(points, rows).intersect(origins, directions)
    assert hits.hit.sum() > 200
    for i in np.flatnonzero(hits.hit):
        a, b, c = ([Fraction(x) for x in corner.tolist()] for corner in corners[hits.primitive[i]])
        normal = cross(minus(b, a), minus(c, a))
        off = dot(normal, minus([Fraction(x) for x in hits.point[i].tolist()], a))
        assert abs(off) <= sum(abs(n) * Fraction(e) for n, e in zip(normal, hits.point_error[i].tolist()))


def test_all_hits_are_those_of_every_triangle():
    random = np.random.default_rng(2)
    points, rows = soup(random, 1000)
    rows = np.concatenate([rows, rows[::50], [[3, 3, 4]]])  # some twice, and one without an area
    origins, directions = rays_about(random, 10_000)
    hits = tracer_of_mesh(points, rows).intersect_all(origins, directions)
    solid = points.astype(float)[rows]
    a, e1, e2 = solid[:, 0], solid[:, 1] - solid[:, 0], solid[:, 2] - solid[:, 0]
    for ray in range(len(origins)):
        found = hits.primitive[hits.offsets[ray]:hits.offsets[ray + 1]].tolist()
        assert len(set(found)) == len(found)
        p = np.cross(directions[ray], e2)
        with np.errstate(all="ignore"):
            inverse = 1 / np.einsum("ni,ni->n", e1, p)
            u = np.einsum("ni,ni->n", origins[ray] - a, p) * inverse
            q = np.cross(origins[ray] - a, e1)
            v = q @ directions[ray] * inverse
            t = np.einsum("ni,ni->n", e2, q) * inverse
            inside = np.minimum(np.minimum(u, v), np.minimum(1 - u - v, t))
        for triangle in np.flatnonzero((inside > 1e-9) | np.isin(np.arange(len(rows)), found)):
            if abs(inside[triangle]) > 1e-9:
                assert (int(triangle) in found) == (inside[triangle] > 0)
        order = list(zip(hits.t[hits.offsets[ray]:hits.offsets[ray + 1]].tolist(), found))
        assert order == sorted(order)
    closest = tracer_of_mesh(points, rows).intersect(origins, directions)
    first = hits.offsets[:-1][hits.counts > 0]
    assert np.array_equal(closest.t[closest.hit], hits.t[first])
    assert np.array_equal(closest.primitive[closest.hit], hits.primitive[first])


def test_primitives_are_rows_of_the_triangles():
    """Also where triangles without an area stand before them."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    tracer = tracer_of_mesh(points, [[0, 0, 1], [1, 1, 1], [0, 1, 2]])
    hits = tracer.intersect([0.25, 0.5, 1], [0, 0, -1])
    assert hits.primitive == 2 and hits.uv.tolist() == [0.25, 0.5]
    assert hits.normal.tolist() == [0, 0, 1]


def test_solids_are_those_of_their_formulas():
    tracer = tracer_from_scene("""
        nodes { name: 'ball' shape { sphere { center { x: 3 } radius: 1 } } }
        nodes { name: 'ring' shape { torus { major_radius: 1 minor_radius: .25 } } }
        nodes { name: 'ground' shape { plane { offset: -2 } } }""")
    p = np.random.default_rng(3).uniform(-4, 4, (10_000, 3))
    ball = np.sum((p - [3, 0, 0])**2, 1) < 1
    ring = (np.hypot(p[:, 0], p[:, 2]) - 1)**2 + p[:, 1]**2 < 0.0625
    assert np.array_equal(tracer.contains(p, "ball"), ball)
    assert np.array_equal(tracer.contains(p, 1), ring)
    assert np.array_equal(tracer.contains(p), ball | ring | (p[:, 1] < -2))
    assert np.array_equal(tracer.crossings(p, [1, 2, 3], ) < 0,
                          tracer.contains(p, "ball") ^ tracer.contains(p, "ring")
                          | tracer.contains(p, "ground"))


def test_camera_rays_are_those_of_the_scene():
    tracer = tracer_from_scene("""
        settings { width: 8 height: 4 }
        cameras { name: 'a' world_from_camera { steps { translate { z: 4 } } }
                  perspective { field_of_view: 90 } }
        cameras { name: 'b' world_from_camera { steps { translate { x: 3 } } } }
        nodes { shape { sphere { radius: 1 } } }""")
    origins, directions = tracer.camera_rays()
    assert origins.shape == directions.shape == (4, 8, 3)
    assert np.all(origins == [0, 0, 4])
    y, x = np.mgrid[1.5:-2:-1, -3.5:4] / 2  # 90 degrees over the smaller side
    d = np.stack([x, y, np.full_like(x, -1)], -1)
    assert np.allclose(directions, d / np.linalg.norm(d, axis=-1, keepdims=True), rtol=0, atol=4e-16)
    assert np.all(tracer.camera_rays((2, 2), "b")[0] == [3, 0, 0])
