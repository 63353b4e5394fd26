"""Ray queries in hard places: edges and vertices, threads, strides, wrong arguments, pickles."""
import concurrent.futures
import itertools
import pickle
import warnings

import cloudpickle
import numpy as np
import pytest
import tessera as ts
from rays_scenes import cube, rays_about, soup, tracer_of_mesh
from tessera.rays import tracer_from_scene


@pytest.fixture(scope="module")
def closed():
    """A cube, and all its vertices and middles of edges as seen from its centre."""
    points, rows = cube()
    corners = points.astype(float)[rows]
    targets = np.concatenate([points, (corners + np.roll(corners, 1, 1)).reshape(-1, 3) / 2])
    return tracer_of_mesh(points, rows), np.full(3, 10.0), targets


def test_no_ray_slips_through_vertices_and_edges(closed):
    tracer, center, targets = closed
    assert len(targets) >= 10_000
    assert tracer.intersect(center, targets - center).hit.all()
    assert tracer.occluded(center, targets - center).all()
    assert np.all(tracer.crossings(center, targets - center) == -1)


def test_lines_leave_a_closed_mesh_as_often_as_they_enter(closed):
    tracer, center, targets = closed
    assert not tracer.crossings(3 * targets - 2 * center, center - targets).any()
    for direction in itertools.product((-1, 0, 1), repeat=3):
        if any(direction):
            assert not tracer.crossings(targets - 50 * np.array(direction), direction).any()


def voxels(filled):
    """The faces of cells of a grid that have an empty neighbour, with shared vertices; edges may have
    four of them."""
    points, rows = [], []
    for cell in np.argwhere(filled):
        for axis, side in itertools.product(range(3), (0, 1)):
            beside = cell.copy()
            beside[axis] += 2 * side - 1
            if (beside >= 0).all() and (beside < filled.shape).all() and filled[tuple(beside)]:
                continue
            corners = []
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = cell.copy()
                corner[axis] += side
                corner[(axis + 1) % 3] += u
                corner[(axis + 2) % 3] += v
                corners.append(corner)
            first = len(points)
            points += corners if side else corners[::-1]
            rows += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    shared, numbers = np.unique(points, axis=0, return_inverse=True)
    return shared.astype("f4"), numbers.reshape(-1)[np.array(rows)]


@pytest.mark.parametrize("seed", range(3))
def test_models_of_voxels_are_full_where_their_cells_are(seed):
    filled = np.random.default_rng(seed).random((6, 6, 6)) < .5
    tracer = tracer_of_mesh(*voxels(filled))
    centers = np.argwhere(np.ones_like(filled)) + .5
    assert (tracer.contains(centers) == filled.reshape(-1)).all()
    corners = np.stack(np.meshgrid(*[np.arange(7.0)] * 3), -1).reshape(-1, 3)
    assert (tracer.contains(corners) == tracer.contains(corners)).all()
    # Through vertices and along edges, a line leaves as often as it enters.
    for direction in itertools.product((-1, 0, 1), repeat=3):
        if any(direction):
            assert not tracer.crossings(corners - 20 * np.array(direction), direction).any()


def test_instances_in_instances_and_solids_are_met_where_they_are():
    inner = ts.Node(shape=ts.Sphere(radius=.5))
    for level in range(8):
        inner = ts.Node(instance_of=ts.Object(name=f"level {level}", nodes=[inner]),
                        transform=ts.translate(1, 0, 0) @ ts.scale(.5))
    # x = 1 + 1/2 + ... + 1/128 and a radius of 1/512.
    center, radius = 2 - 2 ** -7, 2 ** -9
    hollow = ts.Box((2, -1, -1), (4, 1, 1)) - ts.Sphere((3, 0, 1), .5)
    tracer = ts.Scene(nodes=[inner, hollow]).tracer()
    hits = tracer.intersect([(center, 0, 5), (center + .9 * radius, 0, 5), (3, 0, 5), (3.9, .9, 5)], (0, 0, -1))
    expected = [5 - radius, 5 - radius * np.sqrt(1 - .81), 4.5, 4]
    assert np.abs(hits.t - expected).max() < 1e-14


def test_points_on_edges_of_the_grid_are_inside_or_not(closed):
    tracer, _, _ = closed
    grid = np.stack(np.meshgrid(*[np.arange(-1.0, 22)] * 3, indexing="ij"), -1)
    inside = tracer.contains(grid)
    assert inside.shape == (23, 23, 23)
    assert inside[2:21, 2:21, 2:21].all() and inside.sum() <= 21**3
    assert not inside[0].any() and not inside[-1].any() and not inside[:, :, 0].any()
    assert np.array_equal(inside, tracer.contains(grid))
    halves = tracer.contains(grid + 0.5)
    assert halves[1:21, 1:21, 1:21].all() and halves.sum() == 20**3


@pytest.mark.parametrize("accel", ["bvh", "octree", "linear"])
def test_occluded_says_what_intersect_finds(accel):
    random = np.random.default_rng(1)
    points, rows = soup(random, 300, size=0.3)
    tracer = tracer_of_mesh(points, rows, accel=accel)
    o, d = rays_about(random, 20_000)
    t_max = random.uniform(0, 2, len(o))
    for cull in ("none", "back", "front"):
        hits = tracer.intersect(o, d, t_max=t_max, cull=cull)
        assert 0 < hits.hit.sum() < len(o)
        assert np.array_equal(tracer.occluded(o, d, t_max=t_max, cull=cull), np.isfinite(hits.t))
        assert np.array_equal(hits.hit, np.isfinite(hits.t))
        assert np.all(hits.t[hits.hit] < t_max[hits.hit])


def test_threads_and_callers_change_no_bit():
    random = np.random.default_rng(2)
    tracer = tracer_of_mesh(*soup(random, 2000, size=0.2))
    o, d = rays_about(random, 50_000)
    expected, all_expected = tracer.intersect(o, d, threads=1), tracer.intersect_all(o, d, threads=1)

    def same(threads):
        hits = tracer.intersect(o, d, threads=threads)
        every = tracer.intersect_all(o, d, threads=threads)
        return (all(np.array_equal(getattr(hits, f), getattr(expected, f))
                    for f in ("t", "instance", "primitive", "uv"))
                and all(np.array_equal(getattr(every, f), getattr(all_expected, f))
                        for f in ("offsets", "t", "instance", "primitive", "uv")))

    assert same(2) and same(7)
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        assert all(pool.map(same, [1] * 8))
    parts = [tracer.intersect(o[i:i + 777], d[i:i + 777]).t for i in range(0, len(o), 777)]
    assert np.array_equal(np.concatenate(parts), expected.t)


def test_all_shapes_strides_and_types_are_taken():
    random = np.random.default_rng(3)
    tracer = tracer_of_mesh(*soup(random, 300))
    o, d = (a.reshape(6, 50, 3) for a in rays_about(random, 300))
    o, d = o.astype(np.float32), d.astype(np.float32)  # held exactly by all types below
    expected = tracer.intersect(o.astype(float), d.astype(float))
    assert expected.t.shape == expected.hit.shape == (6, 50) and expected.uv.shape == (6, 50, 2)
    assert expected.point.shape == (6, 50, 3)
    wide = np.zeros((6, 100, 6))
    wide[:, ::2, ::2] = d
    for directions in (d, d.tolist(), np.asfortranarray(d), wide[:, ::2, ::2], d.astype(">f8"),
                       d[::-1][::-1], memoryview(d.astype(float))):
        assert np.array_equal(tracer.intersect(o, directions).t, expected.t)
    flipped = tracer.intersect(o[::-1, ::-1], d[::-1, ::-1])
    assert np.array_equal(flipped.t, expected.t[::-1, ::-1])
    one = tracer.intersect(o[2, 3], d[2, 3])
    assert one.t.shape == () and one.t == expected.t[2, 3]
    grid = tracer.intersect(o[:, :1], d[2:3], t_max=np.full((6, 1), np.inf))
    for i, j in ((0, 0), (4, 7), (5, 49)):
        assert grid.t[i, j] == tracer.intersect(o[i, 0], d[2, j]).t
    assert np.array_equal(tracer.intersect([0, 0, -9], [0, 0, 1]).t,
                          tracer.intersect([0.0, 0, -9], [0, 0, 1.0]).t)


@pytest.mark.parametrize("kind", ["f4", "f8", ">f4", ">f8", "f2", "i2", ">i8"])
def test_arrays_at_odd_addresses_are_taken_by_every_query(closed, kind):
    tracer = closed[0]
    origins, directions = np.full((7, 3), 10, kind), np.arange(21).reshape(7, 3).astype(kind) - 9
    ends = np.arange(7).astype(kind)

    def packed(array):
        rows = np.zeros(len(array), [("tag", "u1"), ("numbers", array.dtype, array.shape[1:])])
        rows["numbers"] = array
        return rows["numbers"]

    def shifted(array):
        return np.frombuffer(b"x" + array.tobytes(), "u1")[1:].view(array.dtype).reshape(array.shape)

    def asked(o, d, t):
        hits = tracer.intersect(o, d, t_min=t)
        every = tracer.intersect_all(o, d, t_max=t)
        return [hits.t, hits.point, tracer.occluded(o, d, t_min=t), every.t, every.normal, tracer.crossings(o, d),
                tracer.contains(o), tracer.spawn(hits, d)]

    expected = asked(origins, directions, ends)
    for moved in (packed, shifted):
        assert kind == "f2" or not moved(directions).flags.aligned
        for got, right in zip(asked(*map(moved, (origins, directions, ends))), expected):
            assert np.array_equal(got, right, equal_nan=got.dtype.kind == "f")


@pytest.mark.parametrize("harm", ["missing", "doubled", "flipped"])
def test_one_bad_triangle_is_told_of_and_costs_the_inside_no_more_than_its_place(harm):
    points, rows = cube()
    whole = tracer_of_mesh(points, rows)
    rng = np.random.default_rng(7)
    bad = {"missing": rows[1:], "doubled": np.concatenate([rows, rows[:1]]),
           "flipped": np.concatenate([rows[1:], rows[:1, ::-1]])}[harm]
    mesh = ts.Mesh(points, bad, name="part")
    assert not mesh.is_closed and ts.Mesh(points, rows).is_closed and not ts.Mesh().is_closed
    assert len(mesh.open_edges()) == (6 if harm == "flipped" else 3) and mesh.open_edges().shape[1] == 2
    assert set(mesh.open_edges().reshape(-1)) == set(rows[0])
    scene = ts.Scene()
    scene.add(mesh)
    tracer = scene.tracer()
    at = rng.uniform(-2, 22, (20_000, 3))
    for _ in range(2):  # what is refused is not taken for told
        with warnings.catch_warnings(), pytest.raises(ts.SceneWarning, match="'part' is not closed at"):
            warnings.simplefilter("error")
            tracer.contains(at)
    with pytest.warns(ts.SceneWarning, match=r"contains: the mesh 'part' is not closed at [36] edges, as that "
                                             r"between vertices \d+ and \d+, so that nothing is inside"):
        assert not tracer.contains(at).any()
    with pytest.raises(ts.UsageError, match="^contains: the mesh 0 is not closed at"):
        ts.Mesh(points, bad).tracer().contains(at, closed="error")
    with pytest.raises(ts.UsageError, match="'part' is not closed at"):
        tracer.contains(at, closed="error")
    inside = tracer.contains(at, method="winding")
    far = np.linalg.norm(at[:, None] - points[rows[0]], axis=-1).min(-1) > 0.005 * 20 * 3 ** .5
    assert far.sum() > 19_000 and np.array_equal(inside[far], whole.contains(at)[far])
    for threads in (1, 3):
        assert np.array_equal(inside, tracer.contains(at, method="winding", threads=threads))
    assert np.array_equal(tracer.contains(at, 0, method="winding"), inside)
    moved = ts.Scene()
    moved.add(mesh, transform=ts.translate(5, 0, 0) @ ts.scale(-2))
    assert np.array_equal(moved.tracer().contains(at * -2 + (5, 0, 0), method="winding")[far], inside[far])


@pytest.mark.parametrize("method", ["parity", "winding"])
def test_a_solid_with_a_part_left_out_has_no_inside_and_that_is_told(method):
    told = "^contains: the solid 'pipe' is not closed, so that nothing is inside; expected a solid with no part left"
    scene = ts.Scene(nodes=[ts.Sphere(), ts.Cylinder(open_top=True, name="pipe")])
    tracer = scene.tracer()
    with pytest.warns(ts.SceneWarning, match=told):
        assert tracer.contains([(0, 0, 0), (0, .99, .5)], method=method).tolist() == [True, False]
    with pytest.raises(ts.UsageError, match=told):
        tracer.contains((0, 0, 0), method=method, closed="error")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        closed = ts.Scene(nodes=[ts.Cylinder(), ts.Rectangle((9, 9, 9), (1, 0, 0), (0, 1, 0))])
        assert closed.tracer().contains((0, .9, .5), method=method)


def test_closed_meshes_have_the_same_inside_by_both_methods():
    points, rows = cube()
    scene = ts.Scene()
    scene.add(ts.Mesh(points, rows), ts.Sphere((30, 0, 0), 3))
    at = np.concatenate([np.random.default_rng(1).uniform(-5, 35, (20_000, 3)), points])
    tracer = scene.tracer()
    assert np.array_equal(tracer.contains(at), tracer.contains(at, method="winding"))
    with pytest.raises(ts.UsageError, match="method: 'windings'; expected one of parity, winding"):
        tracer.contains(at, method="windings")


def test_merged_vertices_close_slits():
    points, rows = cube()
    apart = points[rows].reshape(-1, 3) + np.random.default_rng(2).uniform(-1e-4, 1e-4, (rows.size, 3))
    mesh = ts.Mesh(apart)
    merged = mesh.merge_vertices(1e-3)
    assert not mesh.is_closed and merged.is_closed
    assert np.array_equal(mesh.positions, apart.astype("f4")) and merged.positions.shape == mesh.positions.shape
    for distance in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ts.UsageError, match="distance: .*; expected a length in metres, above 0"):
            mesh.merge_vertices(distance)


def test_nothing_is_a_legal_number_of_rays_and_triangles():
    tracer = tracer_of_mesh(np.empty((0, 3)), np.empty((0, 3), int))
    assert not tracer.intersect(np.zeros((4, 3)), [0, 0, 1]).hit.any()
    assert not tracer.contains(np.zeros((4, 3))).any()
    full = tracer_of_mesh(*cube(2))
    for of in (tracer, full):
        hits = of.intersect(np.empty((0, 3)), np.empty((0, 3)))
        assert hits.t.shape == (0,) and hits.point.shape == (0, 3)
        every = of.intersect_all(np.empty((0, 3)), np.empty((0, 3)))
        assert len(every) == 0 and every.offsets.tolist() == [0] and every.point.shape == (0, 3)


def test_what_is_no_ray_hits_nothing(closed):
    tracer = closed[0]
    nan, inf = float("nan"), float("inf")
    for o, d in (([nan, 1, 1], [0, 0, 1]), ([1, 1, 1], [0, nan, 1]), ([1, 1, 1], [0, 0, 0]),
                 ([1, inf, 1], [0, 0, 1]), ([1, 1, 1], [inf, 0, 0])):
        assert not tracer.intersect(o, d).hit and not tracer.occluded(o, d)
        assert len(tracer.intersect_all(o, d)) == 0 and tracer.crossings(o, d) == 0
    assert not tracer.contains([nan, 1, 1])
    assert np.isnan(tracer.intersect([1, 1, 1], [0, 0, 0]).point).all()


@pytest.mark.parametrize("shape", ["sphere { }", "cylinder { }", "cone { }", "torus { }", "box { }"])
@pytest.mark.parametrize("exponent", [-1020, -600, -400, -201, 201, 400, 600, 1000, 1010])
def test_directions_of_any_length_meet_the_same(shape, exponent):
    tracer = tracer_from_scene("nodes { shape { %s } }" % shape)
    random = np.random.default_rng(7)
    # Few bits, so that those of the shortest directions are numbers too.
    d = np.round(random.normal(size=(200, 3)) * 1024) / 1024
    o = -3 * d + np.round(random.uniform(-1, 1, d.shape) * 512) / 512
    long = np.ldexp(d, exponent)
    near, far = tracer.intersect(o, d), tracer.intersect(o, long)
    assert near.hit.sum() > 20
    for field in ("hit", "instance", "primitive", "uv", "point", "normal"):
        np.testing.assert_array_equal(getattr(near, field), getattr(far, field), field)
    assert (far.t == np.ldexp(near.t, -exponent)).all()
    assert (tracer.occluded(o, d) == tracer.occluded(o, long)).all()
    assert (tracer.crossings(o, d) == tracer.crossings(o, long)).all()
    every, all_of_long = tracer.intersect_all(o, d), tracer.intersect_all(o, long)
    assert (every.offsets == all_of_long.offsets).all()
    assert (all_of_long.t == np.ldexp(every.t, -exponent)).all()


def test_spawned_rays_do_not_meet_their_surface():
    tracer = tracer_from_scene("""
        nodes { shape { sphere { center { x: 1e3 } radius: .1 } } }
        nodes { shape { box { min { x: -7 y: 1e4 } max { x: -6 y: 10001 z: .1 } } } }""")
    random = np.random.default_rng(4)
    for middle, size in (([1e3, 0, 0], 0.1), ([-6.5, 1e4 + 0.5, 0.05], 0.04)):
        d = random.normal(size=(50_000, 3))
        hits = tracer.intersect(np.array(middle) - 5 * d, d + random.uniform(-size, size, d.shape) / 9)
        away = random.normal(size=d.shape)
        away *= np.sign(np.sum(away * hits.normal, 1))[:, None]
        kept = hits.hit
        assert kept.sum() > 10_000
        origins = tracer.spawn(hits, np.nan_to_num(away))
        assert np.isnan(origins[~kept]).all()
        assert not tracer.intersect(origins[kept], away[kept]).hit.any()


@pytest.mark.parametrize("shape", [
    ts.Rectangle.from_corners((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)), ts.Box((-1, -1, -1), (1, 1, 1)),
    ts.Plane.through((0, 0, 0), (1, 0, 0), (0, 1, 0)), ts.Disc((0, 0, 0), (0, 0, 1), radius=1.4),
    ts.Triangle((-3, -2, 0), (3, -2, 0), (0, 4, 0))], ids=lambda shape: type(shape).__name__)
def test_rays_spawned_on_planar_shapes_of_any_size_and_place_do_not_meet_them(shape):
    # As N10 of the numerics, 200,000 bounces a shape.
    random = np.random.default_rng(5)
    bounces = 0
    for scale, exponent in itertools.product(range(-4, 5), (.5, 2, 4, 6, 8)):
        place = 10 ** random.uniform(-exponent, exponent, 3) * random.choice((-1, 1), 3)
        moved = ts.translate(*place) @ ts.rotate(random.normal(size=3), 360 * random.random()) @ ts.scale(10.0 ** scale)
        tracer = ts.Scene(nodes=[ts.Node(shape=shape, transform=moved)]).tracer(threads=1)
        local = random.uniform(-1, 1, (9000, 3)) * (.9, .9, 1)
        if not isinstance(shape, ts.Box):
            local[:, 2] = 0
        linear = moved.array[:, :3]
        targets, directions = local @ linear.T + place, random.normal(size=local.shape) @ linear.T
        hits = tracer.intersect(targets - 3 * directions, directions)
        away = random.normal(size=local.shape)
        away *= np.sign(np.sum(away * hits.normal, 1))[:, None]
        kept = hits.hit
        origins = tracer.spawn(hits, np.nan_to_num(away))[kept]
        assert not tracer.intersect(origins, away[kept]).hit.any()
        assert not tracer.occluded(origins, away[kept]).any()
        bounces += kept.sum()
    assert bounces > 200_000


WRONG = [
    (dict(origins=np.zeros((4, 2))), "origins: shape (4, 2); expected (..., 3)"),
    (dict(directions=3.0), "directions: shape (); expected (..., 3)"),
    (dict(origins=np.zeros((4, 3)), directions=np.zeros((5, 3))), "origins (4,), directions (5,)"),
    (dict(t_max=[1, 2, 3], origins=np.zeros((2, 3))), "t_max (3,)"),
    (dict(t_min=-1), "t_min[0]: -1; expected 0 or more"),
    (dict(t_min="x"), "t_min: dtype"),
    (dict(origins=np.zeros((4, 3), complex)), "origins: dtype complex128; expected float64"),
    (dict(cull="bakc"), "cull: 'bakc'; expected one of none, back, front; did you mean 'back'?"),
    (dict(threads=0), "threads: 0; expected a whole number from 1 to 1024"),
    (dict(fields=("t", "primitve")), "did you mean 'primitive'?"),
]


@pytest.mark.parametrize("wrong, told", WRONG, ids=[told[:20] for _, told in WRONG])
def test_wrong_arguments_are_told(closed, wrong, told):
    with pytest.raises(ValueError) as raised:
        closed[0].intersect(**{"origins": [1, 1, 1], "directions": [0, 0, 1], **wrong})
    assert told in str(raised.value) and isinstance(raised.value, ts.UsageError)


@pytest.mark.parametrize("threads, error", [(-1, ts.UsageError), (0, ts.UsageError), (10**9, ts.UsageError),
                                            (1.5, TypeError), (True, TypeError), ("2", TypeError)])
def test_a_wrong_number_of_threads_is_told_when_a_tracer_is_made(threads, error):
    with pytest.raises(error, match=f"threads: {threads!r}; expected a whole number"):
        ts.Scene(nodes=[ts.Box()]).tracer(threads=threads)


@pytest.mark.parametrize("options", [{}, dict(frame_all=True)])
def test_rays_of_a_camera_for_another_size_are_those_of_a_scene_of_that_size(options):
    def made(width, height, camera=None):
        scene = ts.Scene(width=width, height=height, nodes=[ts.Sphere((3, 2, 1), 2)])
        scene.cameras = [ts.Camera(name="other"), ts.Camera(name="c", **options)]
        scene.cameras[1].perspective = ts.Perspective(field_of_view=31)
        return scene.tracer(threads=2, camera=camera)
    for got, expected in zip(made(64, 36).camera_rays((12, 20), "c"), made(12, 20, "c").camera_rays()):
        assert np.array_equal(got, expected) and got.shape == (20, 12, 3)
    assert not np.array_equal(made(12, 20).camera_rays(camera="c")[1], made(12, 20).camera_rays()[1])


def test_wrong_meshes_scenes_and_shapes_are_told(closed):
    with pytest.raises(ValueError, match="triangles: index 4294967297 in row 1; expected 0 to 2"):
        tracer_of_mesh(np.zeros((3, 3)), [[0, 1, 2], [0, 1, 2**32 + 1]])
    with pytest.raises(ValueError, match="triangles"):
        tracer_of_mesh(np.zeros((3, 3)), [[0, 1, -1]])
    with pytest.raises(ts.SceneError):
        tracer_from_scene("nodes { shape { sphere { radius: -1 } } }")
    with pytest.raises(ts.UsageError, match="accel: 'bhv'; expected one of .* did you mean 'bvh'"):
        tracer_from_scene("", accel="bhv")
    with pytest.raises(ts.UsageError, match="expected a name or a number below 1"):
        closed[0].contains([0, 0, 0], 1)
    open_mesh = tracer_of_mesh(cube(2)[0], cube(2)[1][1:])
    with pytest.raises(ts.UsageError, match="is not closed"):
        open_mesh.contains([0, 0, 0], 0)
    hits = closed[0].intersect([1, 1, 1], [0, 0, 1], fields="t")
    with pytest.raises(ts.UsageError, match="instance: not among the fields"):
        hits.instance
    with pytest.raises(ts.UsageError, match="^fields: t; expected all, as without fields=, for what lies at the hits"):
        hits.point


@pytest.mark.parametrize("wrong, told", [
    ({"accel": "bhv"}, "accel: 'bhv'; expected one of bvh, .* did you mean 'bvh'"), ({"accel": 3}, "accel: 3; expec"),
    ({"time": float("nan")}, "time: nan; expected a finite number"),
    ({"camera": "onne"}, "camera: 'onne' is not in the scene, which has 1 camera: one; did you mean 'one'")])
def test_what_a_tracer_is_made_with_is_refused_as_a_render_refuses_it(wrong, told):
    scene = ts.Scene(nodes=[ts.Sphere()], cameras=[ts.Camera(name="one")])
    for use in (scene.tracer, lambda **wrong: scene.render(size=(4, 4), workers=0, **wrong)):
        with pytest.raises(ts.UsageError, match=f"^{told}"):
            use(**wrong)
    if "camera" in wrong:
        with pytest.raises(ts.UsageError, match=f"^{told}"):
            scene.tracer().camera_rays(**wrong)
    with pytest.raises(TypeError, match="^camera: 1j; expected text"):
        scene.tracer().camera_rays(camera=1j)


def test_insides_of_one_name_or_number():
    scene = ts.Scene()
    scene.add(ts.Sphere(radius=.5), transform=ts.translate(-3, 0, 0), name="same")
    scene.add(ts.Torus(minor_radius=.2), ts.Sphere(radius=.5), name="same")
    scene.add(ts.Sphere(), name="other", transform=ts.translate(9, 0, 0))
    tracer = scene.tracer()
    points = [(-3, 0, 0), (0, 0, 0), (1, 0, 0), (9, 0, 0)]
    assert tracer.contains(points).all()
    assert tracer.contains(points, "same").tolist() == [True, True, True, False]
    assert tracer.contains(points, np.int64(0)).tolist() == [True, False, False, False]
    for wrong in (True, 1.5, ts.Scene(), scene.nodes[0]):
        with pytest.raises(TypeError, match="expected the name or number of an instance"):
            tracer.contains(points, wrong)


def test_hits_of_another_scene_do_no_harm(closed):
    hits = closed[0].intersect([1, 1, 1], [0, 0, 1])
    other = tracer_of_mesh(np.eye(3), [[0, 1, 2]])
    with pytest.raises(ts.UsageError, match=r"primitive\[0\]: .* expected a hit of this scene"):
        other.spawn(hits, [0, 0, 1])


@pytest.mark.parametrize("module", [pickle, cloudpickle])
def test_tracers_and_hits_pickle(module, closed):
    random = np.random.default_rng(5)
    o, d = rays_about(random, 500, 20)
    tracer = closed[0]
    again = module.loads(module.dumps(tracer))
    hits = tracer.intersect(o, d)
    assert np.array_equal(again.intersect(o, d).t, hits.t)
    for found in (hits, tracer.intersect_all(o, d)):
        copy = module.loads(module.dumps(found))
        assert np.array_equal(copy.t, found.t) and np.array_equal(copy.normal, found.normal,
                                                                  equal_nan=True)


def test_names_materials_and_attributes_are_those_of_the_scene():
    tracer = tracer_from_scene("""
        materials { name: 'glass' dielectric { } }
        objects { name: 'pair' nodes { shape { name: 'left' sphere { center { x: -2 } } } }
                               nodes { name: 'right' shape { materials: 'glass' sphere { center { x: 2 } } } } }
        nodes { instance_of: 'pair' }
        nodes { hidden: true shape { sphere { radius: 100 } } }""")
    assert tracer.instances == ["left", "right"] and tracer.materials == ["", "glass"]
    hits = tracer.intersect([[-2, 0, 9], [2, 0, 9], [9, 9, 9]], [0, 0, -1])
    assert [hits.name(i) for i in range(3)] == ["left", "right", None]
    assert hits.material.tolist() == [0, 1, 0xFFFFFFFF]
    assert hits.point[:2].tolist() == [[-2, 0, 1], [2, 0, 1]]
    assert hits.texcoord.shape == (3, 2) and np.array_equal(hits.shading_normal[:2], [[0, 0, 1]] * 2)
    assert not hits.t.flags.writeable and not hits.point.flags.writeable
    assert hits.point is hits.point
    bounds, exact = tracer.bounds, np.array([[-3, -1, -1], [3, 1, 1]])
    assert np.all(bounds[0] <= exact[0]) and np.all(bounds[1] >= exact[1])
    assert np.allclose(bounds, exact, rtol=1e-14)
    assert tracer.statistics["instances"] == 2


#: A query that would take minutes.
INTERRUPTED = """
import numpy as np, os, signal, threading, time
import tessera as ts
random = np.random.default_rng(0)
points = random.normal(size=(60_000, 3))
tracer = ts.Mesh(points, np.arange(60_000).reshape(-1, 3)).tracer(accel="linear")
o = random.normal(size=(3_000_000, 3))
threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    tracer.intersect(o, -o, threads=1)
    print("done")
except KeyboardInterrupt:
    print("interrupted", tracer.intersect(o[:9], -o[:9]).t.shape)
"""


def test_a_scene_gives_its_tracer():
    scene = ts.Scene()
    scene.add(ts.Sphere(radius=2.0), name="ball")
    hits = scene.tracer().intersect([[0, 0, 9], [0, 3, 9]], [0, 0, -1])
    assert hits.t.tolist() == [7, float("inf")] and hits.name(0) == "ball"
    with pytest.raises(ts.UsageError, match="geometry_only"):
        scene.tracer(geometry_only=False)


def test_memory_is_that_of_inputs_and_results(script):
    code = ("import resource, numpy as np\nfrom tessera.rays import tracer_from_scene\n"
            "t = tracer_from_scene('nodes { shape { sphere { } } }')\n"
            "o = np.ones((10_000_000, 3)); t.intersect(o[:9000], [0, 0, 1])\n"
            "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024\n"
            "before = peak(); hits = t.intersect(o, [0, 0, 1], fields=('t', 'primitive'))\n"
            "print(peak() - before - hits.t.nbytes - hits.primitive.nbytes)")
    assert int(script(code)) <= 32 * 2**20


def test_ctrl_c_ends_a_query(script):
    assert script(INTERRUPTED) == "interrupted (9,)"


def test_tracers_go_on_in_a_forked_child(script):
    code = ("import os\nfrom tessera.rays import tracer_from_scene\n"
            "t = tracer_from_scene('nodes { shape { sphere { } } }')\n"
            "import numpy as np\no = np.full((9000, 3), 9.); t.intersect(o, -o)\n"
            "pid = os.fork()\n"
            "if pid == 0: os._exit(0 if t.intersect(o, -o).hit.all() else 1)\n"
            "print(os.waitpid(pid, 0)[1])")
    assert script(code) == "0"


def test_an_open_mesh_is_told_by_contains():
    positions, triangles = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3)]
    tracer = ts.Scene(nodes=[ts.Mesh(positions, triangles, name="tent")]).tracer()
    with pytest.warns(ts.SceneWarning, match="contains: the mesh 'tent' is not closed at 3 edges"):
        assert not tracer.contains((.1, .1, .1))
    with pytest.raises(ts.UsageError, match="the mesh 'tent' is not closed at 3 edges"):
        tracer.contains((.1, .1, .1), "tent")
    closed = ts.Scene(nodes=[ts.Mesh(positions, [*triangles, (0, 3, 2)])]).tracer()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert closed.contains((.1, .1, .1))


def test_arrays_of_broadcast_arrays_are_taken_without_a_warning():
    tracer = ts.Sphere().tracer()
    origins, directions = np.broadcast_arrays(np.zeros((4, 3)), np.array([0., 0, 1]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hits = tracer.intersect(origins, directions)
        assert hits.t.tolist() == [1] * 4
        assert tracer.intersect_all(origins, directions).t.tolist() == [1] * 4


def test_hits_keep_the_rays_of_broadcast_arrays_that_are_written_to_later():
    start, direction = np.zeros((1, 3)), np.array([0., 0, 1])
    origins, directions = np.broadcast_arrays(np.broadcast_to(start, (4, 3)), direction)
    hits = ts.Sphere().tracer().intersect(origins, directions)
    start[:] = direction[:] = 7
    assert hits.point.tolist() == [[0, 0, 1]] * 4
