"""Everything that the classic toolbox of Python objects had, against its formulas."""
import math
from decimal import Decimal, getcontext

import numpy as np
import pytest

import tessera as ts

getcontext().prec = 50


def brute_spheres(centers, radii, o, d):
    """The least t > 0 at which the ray o + t d meets each sphere; infinity where it does not."""
    v = o - centers
    a, b, c = d @ d, 2 * v @ d, (v * v).sum(1) - radii * radii
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
        t = np.stack([(-b - root) / (2 * a), (-b + root) / (2 * a)])
    return np.where(t > 0, t, np.inf).min(0)


def in_ulp(found, expected):
    """How many units in the last place numbers are apart."""
    return np.abs(found - expected) / np.spacing(np.abs(expected))


# ------------------------------------------------------------------------------ vectors and numbers

def test_vectors():
    rng = np.random.default_rng(1)
    pairs = rng.normal(size=(10_000, 2, 3)) * 10 ** rng.uniform(-9, 9, (10_000, 2, 1))
    for a, b in pairs:
        p, q, s = ts.Vec(*a), ts.Vec(b), float(b[0])
        assert tuple(p + q) == tuple(a + b) and tuple(p - q) == tuple(a - b)
        assert tuple(p * s) == tuple(s * p) == tuple(a * s)
        assert tuple(p.cross(q)) == tuple(np.cross(a, b))
        assert p.dot(q) == a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
        assert in_ulp(p.length, math.sqrt(sum(x * x for x in a))) <= 2
        assert in_ulp(p.normalized().length, 1) <= 2
    assert np.asarray(ts.Vec(1, 2, 3)).dtype == np.float64
    assert tuple(ts.Vec(1, 2, 3) + np.arange(3)) == (1, 3, 5)
    with pytest.raises(AttributeError):
        p.x = 1
    with pytest.raises(ValueError, match="length 0"):
        ts.Vec(0, 0, 0).normalized()


def true_roots(a, b, c):
    a, b, c = map(Decimal, (a, b, c))
    rest = b * b - 4 * a * c
    if rest < 0:
        return []
    q = -(b + rest.sqrt().copy_sign(b)) / 2
    return sorted({q / a, c / q}) if q else [Decimal(0)]


def quadratics():
    rng = np.random.default_rng(2)
    for case in range(10_000):
        a, b, c = rng.normal(size=3) * 10 ** rng.uniform(-5, 5, 3)
        if case % 3 == 1:  # b^2 is next to 4 a c
            c = b * b / (4 * a) * (1 + rng.integers(-3, 4) * 2.0 ** -52)
        if case % 3 == 2:  # numbers whose squares leave the range, and roots far apart
            a, b, c = rng.normal(size=3) * 10 ** rng.uniform(-140, 140, 3)
        yield float(a), float(b), float(c)


def test_quadratic_equations():
    for a, b, c in quadratics():
        expected = [float(root) for root in true_roots(a, b, c)]
        expected = sorted({root for root in expected if math.isfinite(root)})
        found = ts.solve_quadratic(a, b, c)
        if len(found) == 1 and len(expected) == 2:  # two roots that round to one
            assert in_ulp(expected[0], expected[1]) <= 4
            found *= 2
        assert len(found) == len(expected), (a, b, c)
        assert list(found) == sorted(found)
        assert all(in_ulp(f, e) <= 4 for f, e in zip(found, expected)), (a, b, c, found, expected)


def test_quadratic_equations_at_the_limits():
    assert ts.solve_quadratic(1, -3, 2) == (1, 2)
    assert ts.solve_quadratic(1e200, -3e200, 2e200) == (1, 2)
    assert ts.solve_quadratic(1e-200, -3e-200, 2e-200) == pytest.approx((1, 2), rel=1e-15)
    assert ts.solve_quadratic(1, 2, 1) == (-1,)
    assert ts.solve_quadratic(1, 0, 0) == (0,) and ts.solve_quadratic(1, 1, 0) == (-1, 0)
    assert ts.solve_quadratic(0, 2, -4) == (2,)
    assert ts.solve_quadratic(1, 0, 1) == ts.solve_quadratic(0, 0, 1) == ()
    assert ts.solve_quadratic(1e-300, 1e300, 1) == (-1e-300,)  # the other is -1e600
    with pytest.raises(ValueError, match="b: inf; expected a finite number"):
        ts.solve_quadratic(1, math.inf, 0)


def test_reflected_directions():
    rng = np.random.default_rng(3)
    for v, n in rng.normal(size=(1000, 2, 3)):
        expected = v - 2 * (v @ n) / (n @ n) * n
        assert np.asarray(ts.reflect(v, n)) == pytest.approx(expected, rel=1e-12, abs=1e-14)


# ------------------------------------------------------------------------------------------- shapes

def test_intersections_of_spheres_and_planes():
    rng = np.random.default_rng(4)
    for m, o, d, a, b, c in rng.normal(size=(200, 6, 3)):
        hits = ts.Sphere(m, .8).intersect(o, d)
        expected = brute_spheres(m[None], np.array([.8]), o, d)[0]
        assert hits.t == pytest.approx(expected, rel=1e-9)
        if hits.hit:
            point = o + expected * d
            assert hits.point == pytest.approx(point, abs=1e-9)
            assert hits.normal == pytest.approx((point - m) / .8, abs=1e-8)
        plane, n = ts.Plane.through(a, b, c), np.cross(b - a, c - a)
        t = n @ (a - o) / (n @ d)
        assert plane.intersect(o, d).t == pytest.approx(t if t > 0 else np.inf, rel=1e-9)
        assert plane.normal.dot(n) == pytest.approx(math.sqrt(n @ n), rel=1e-12)
    with pytest.raises(ts.SceneError, match="through: points on one line; expected three"):
        ts.Plane.through((0, 0, 0), (1, 1, 1), (3, 3, 3))


def test_t_counts_lengths_of_the_direction():
    assert ts.Sphere().intersect((0, 0, 5), (0, 0, -2)).t == 2
    assert ts.Sphere((0, 0, 0), 1, material="of a scene").intersect((0, 0, 5), (0, 0, -.5)).t == 8
    many = ts.Sphere().intersect([(0, 0, 5), (3, 0, 5)], (0, 0, -1), t_max=10)
    assert many.t.tolist() == [4, math.inf]


def test_edges_and_corners_belong_to_triangles():
    """For rays whose slopes are binary fractions, so that they go exactly through those points."""
    rng = np.random.default_rng(5)
    for corners in rng.integers(-8, 9, (300, 3, 3)):
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        d = rng.permutation([*rng.integers(-4, 5, 2), 4 * rng.choice([-1, 1])])
        if normal @ d == 0:
            continue
        middle = corners.mean(0)
        edges = [(corners[i] + corners[i - 1]) / 2 for i in range(3)]
        inside = np.array([*corners, *edges, middle])
        outside = np.array([p + 1e-6 * (p - middle) for p in (*corners, *edges)])
        triangle = ts.Triangle(*corners)
        hits = triangle.intersect(inside - 16 * d, d)
        assert hits.hit.all() and hits.t == pytest.approx(16)
        assert not triangle.intersect(outside - 16 * d, d).hit.any()
        assert (hits.normal @ normal > 0).all()


def test_rectangles_from_corners():
    a, b, c, d = (0, 0, 0), (2, 0, 0), (3, 1, 0), (1, 1, 0)
    parallelogram = ts.Rectangle.from_corners(a, b, c, d, name="floor", flip_normals=True)
    assert isinstance(parallelogram, ts.Rectangle) and parallelogram.name == "floor"
    assert tuple(parallelogram.edge_u) == (2, 0, 0) and tuple(parallelogram.edge_v) == (1, 1, 0)
    quad = ts.Rectangle.from_corners(a, b, (3, 2, 0), d)
    assert isinstance(quad, ts.Polygon)
    for shape, normal in ((parallelogram, -1), (quad, 1)):
        hits = shape.intersect([(1.5, .5, 1), (2.1, .3, 1), (.2, .5, 1), (2.6, 1.6, 1)], (0, 0, -1))
        assert hits.hit.tolist() == [True, True, False, shape is quad]
        assert hits.normal[0].tolist() == [0, 0, normal]
    with pytest.raises(ts.SceneError, match=r"corners: 0.\d+ m off their plane; expected four in one"):
        ts.Rectangle.from_corners(a, b, (3, 2, 1), d)
    with pytest.raises(ts.SceneError, match=r"a point of a polygon that is 0.\d+ m off its plane; expected 3 or more"):
        ts.Scene(nodes=[ts.Polygon([a, b, (3, 2, 1), d])]).check()
    with pytest.raises(ts.SceneError, match="no area"):
        ts.Rectangle.from_corners(a, b, b, a[:2] + (0,)).intersect(a, b)


CUBE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
                 (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], float)


def test_boxes_from_corners():
    cube = ts.Box.from_corners(CUBE * 2 - 1)
    assert isinstance(cube, ts.Box) and cube == ts.Box((-1, -1, -1), (1, 1, 1))
    shear = np.array([(1, .5, 0), (0, 2, .25), (.125, 0, 1)])
    for matrix in (shear, shear[[1, 0, 2]]):  # the second is left-handed
        sheared = ts.Box.from_corners(CUBE @ matrix + (1, 2, 3))
        assert isinstance(sheared, ts.Box)
        check_solid(sheared, CUBE @ matrix + (1, 2, 3))
    twisted = CUBE.copy()
    twisted[4:, :2] = (twisted[4:, :2] - .5) @ [(.8, .6), (-.6, .8)] + .5
    for corners in (twisted, twisted[:, [1, 0, 2]]):
        mesh = ts.Box.from_corners(corners, material="wood")
        assert isinstance(mesh, ts.Mesh) and mesh.closed and mesh.material == "wood"
        check_solid(mesh, corners)
    moved = ts.Box.from_corners(CUBE @ shear, transform=ts.translate(5, 0, 0))
    check_solid(moved, CUBE @ shear + (5, 0, 0))
    with pytest.raises(ts.SceneError, match="corners: 7; expected 8"):
        ts.Box.from_corners(CUBE[:7])
    with pytest.raises(ts.SceneError, match="no volume"):
        ts.Box.from_corners(CUBE * (1, 1, 0))


def check_solid(shape, corners):
    """From its middle every ray meets the inside of its surface, and its corners are its bounds."""
    middle = corners.mean(0)
    directions = np.random.default_rng(6).normal(size=(500, 3))
    hits = shape.intersect(middle, directions)
    assert hits.hit.all() and ((hits.normal * directions).sum(1) > 0).all()
    scene = ts.Scene(materials=[ts.Classic(name="wood")])
    scene.add(shape)
    bounds = np.array([corners.min(0), corners.max(0)])
    assert scene.tracer().bounds == pytest.approx(bounds, abs=1e-6)
    assert scene.tracer().contains([middle, corners[0] * 1.01 - middle * .01]).tolist() == [True, False]


def test_combined_shapes():
    ball, box = ts.Sphere((0, 0, 0), 1), ts.Box((0, 0, 0), (2, 2, 2))
    rays = [(.5, .5, 5), (-.5, 0, 5), (1.5, 1.5, 5)], (0, 0, -1)
    top, lower = 5 - math.sqrt(.5), 5 - math.sqrt(.75)
    for solid, expected in ((ball | box, (3, lower, 3)), (ball & box, (top, math.inf, math.inf)),
                            (ball - box, (5, lower, math.inf)),
                            (ball - ts.Node(shape=box), (5, lower, math.inf))):
        assert solid.intersect(*rays).t == pytest.approx(expected, rel=1e-14)
    with pytest.raises(TypeError):
        ball | 3


# ---------------------------------------------------------------------------------- shapes are moved

def some_shapes(move=lambda p: np.asarray(p, float)):
    """Shapes whose coordinates went through `move`, which keeps lengths."""
    corners = [(0, 0, .25), (2, 0, .5), (2, 1, .5), (0, 1, .25)]
    points = [move(p) for p in corners]
    return [ts.Sphere(move((.5, .25, 0)), 1.5), ts.Triangle(*points[:3]),
            ts.Rectangle.from_corners(*points), ts.Polygon(points),
            ts.Mesh(np.array(points, np.float32), [(0, 1, 2), (0, 2, 3)]),
            ts.Node(shape=ts.Sphere(move((1, 0, 0)), 1)),
            ts.Node(children=[ts.Polygon(points), ts.Sphere(move((3, 3, 3)), .5)])]


SHEARED = [(0, 1, 0, 0), (1, 3, 0, 0), (.5, -2, 1, 0)]  # takes the planes y = c to x = c
MOVES = [  # what it does to points, and what is called
    (lambda p: np.add(p, (4, -2, 1)), lambda shape: shape.shift((4, -2, 1))),
    (lambda p: np.subtract((2, 4, -6), p), lambda shape: shape.reflect((1, 2, -3))),
    (lambda p: np.asarray(p, float)[[1, 0, 2]], lambda shape: shape.mirror(ts.Plane((1, -1, 0)))),
    (lambda p: np.array((2 * 1.5 - p[0], p[1], p[2])), lambda shape: shape.mirror(
        ts.Plane((0, 2, 0), .5, transform=ts.translate(1, 7, 7) @ ts.matrix(SHEARED)))),
    (lambda p: np.subtract((-2, 6, -7), p), lambda shape: shape.shift((4, -2, 1)).reflect((1, 2, -3))),
]


@pytest.mark.parametrize("move, call", MOVES)
def test_moved_shapes(move, call):
    rng = np.random.default_rng(7)
    origins, targets = rng.normal(size=(400, 3)) * 9, rng.uniform(0, 2, (400, 3))
    origins, targets = (np.array([move(p) for p in points]) for points in (origins, targets))
    for found, expected in zip(some_shapes(), some_shapes(move)):
        assert call(found) is found
        a, b = (shape.intersect(origins, targets - origins) for shape in (found, expected))
        assert (a.hit == b.hit).all() and a.hit.sum() > 20, found
        assert in_ulp(a.t[a.hit], b.t[b.hit]).max() <= 64, found


def test_keys_are_moved():
    node = ts.Node(shape=ts.Sphere(), keys=ts.keys([(0, ts.translate(0, 0, 0)),
                                                    (1, ts.translate(2, 0, 0))])).shift((0, 5, 0))
    scene = ts.Scene(nodes=[node])
    for time in (0, 1):
        expected = np.array([(2 * time - 1, 4, -1), (2 * time + 1, 6, 1)])
        assert scene.tracer(time=time).bounds == pytest.approx(expected, abs=1e-12)


def test_copies():
    mesh = ts.Mesh(np.random.default_rng(8).normal(size=(300, 3)).astype(np.float32))
    alone, twice = ts.Scene(), ts.Scene()
    alone.add(mesh)
    twice.add(mesh, *(mesh.copy((5 * i, 0, 0)) for i in range(1, 4)))
    group = twice.nodes[0]
    twice.add(group.copy((0, 9, 0)), group.copy((0, 18, 0)))
    assert len(twice.to_dict()["blobs"]) == len(alone.to_dict()["blobs"]) > 0
    tracer = twice.tracer()
    assert len(tracer.instances) == 12 and len(twice.to_dict()["objects"]) == 1
    one = mesh.intersect((0, 0, 9), (0, 0, -1))
    found = tracer.intersect([(5 * i, 9 * j, 9) for i in range(4) for j in range(3)], (0, 0, -1))
    assert in_ulp(found.t, one.t).max() <= 64
    assert mesh.transform is None and group.transform is None  # copies are apart
    copy = group.copy().shift((1, 0, 0)).flip()
    assert group.transform is None and not group.children[0].shape.flip_normals
    assert copy.intersect((1, 0, 9), (0, 0, -1)).t == pytest.approx(one.t, rel=1e-14)


def test_turned_normals():
    ray = (1.2, .3, 9), (-.03, .01, -1)
    for shape in some_shapes() + [ts.Sphere((1, .5, 0)) - ts.Box((5, 5, 5), (6, 6, 6)),
                                  ts.Node(instance_of=ts.Object(nodes=[ts.Sphere((1, .5, 0))])),
                                  ts.Node(children=[ts.Instances(ts.Sphere((1, .5, 0)),
                                                                 [ts.scale(1)])])]:
        before = shape.intersect(*ray)
        shared = shape.copy()
        assert before.hit and shape.flip() is shape
        after = shape.intersect(*ray)
        assert (after.normal == -before.normal).all() and after.t == before.t
        assert (shared.intersect(*ray).normal == before.normal).all()
        assert (shape.flip().intersect(*ray).normal == before.normal).all()
    with pytest.raises(ValueError, match="flip: an instance of 'tree'; expected one of an Object"):
        ts.Node(instance_of="tree").flip()


# ------------------------------------------------------------------------- shadows and closest objects

def random_spheres(seed):
    rng = np.random.default_rng(seed)
    return rng, rng.uniform(-5, 5, (40, 3)), rng.uniform(.2, 1.2, 40)


def test_shadows_by_brute_force():
    for seed in range(5):
        rng, centers, radii = random_spheres(seed)
        scene = ts.Scene()
        scene.add([ts.Sphere(c, r) for c, r in zip(centers, radii)])
        light, points = np.array((1, 9, 2)), rng.uniform(-5, 5, (500, 3))
        expected = [brute_spheres(centers, radii, p, light - p).min() < 1 for p in points]
        found = scene.tracer().occluded(points, light - points, t_max=1)
        assert (found == expected).all() and 50 < found.sum() < 450


def test_the_closest_object_by_brute_force():
    rng, centers, radii = random_spheres(11)
    for order in (range(40), range(39, -1, -1)):
        scene = ts.Scene()
        for i in order:
            scene.add(ts.Sphere(centers[i], radii[i]), name=f"sphere {i}")
        tracer = scene.tracer()
        for o, d in rng.normal(size=(300, 2, 3)) * (9, 1)[0]:
            t = brute_spheres(centers, radii, o, d)
            hits = tracer.intersect(o, d)
            assert hits.name(()) == (f"sphere {t.argmin()}" if t.min() < np.inf else None)
            assert hits.t == pytest.approx(t.min(), rel=1e-9)


def test_of_coinciding_objects_the_earlier_is_hit():
    for names in (("first", "second"), ("second", "first")):
        scene = ts.Scene()
        for name in names:
            scene.add(ts.Sphere(), name=name)
        assert scene.tracer().intersect((0, 0, 5), (0, 0, -1)).name() == names[0]


def test_a_combination_s_material_is_that_of_its_parts_without_one():
    def seen(own=None):
        box = ts.Box(min=(-1, -1, -1), max=(1, 1, 1), material=own)
        scene = ts.Scene()
        scene.add((box & ts.Sphere(radius=1.2)) - ts.Sphere(center=(5, 0, 0)),
                  material=ts.Unlit(color=(1, 0, 0)))
        return scene.render(size=(3, 3), view="front", spp=1).linear[1, 1].tolist()

    assert seen() == [1, 0, 0]
    assert seen(ts.Unlit(color=(0, 1, 0))) == [0, 1, 0]
