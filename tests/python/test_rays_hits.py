"""Hits as values: parts of them, their truth, what they keep, and how they pickle."""
import copy
import pickle

import numpy as np
import pytest
from tessera.compat import MeshIntersector

import tessera as ts

ATTRIBUTES = ("t", "instance", "primitive", "uv", "point", "point_error", "normal", "shading_normal",
              "texcoord", "material", "hit")


@pytest.fixture(scope="module")
def tracer():
    nodes = [ts.Node(shape=ts.Sphere((3 * i, 0, 0), material=ts.Classic(name=f"paint {i}")), name=f"ball {i}")
             for i in range(3)]
    return ts.Scene(nodes=nodes).tracer()


def rays():
    """Those of a (2, 3) field; the last of each row misses."""
    return np.array([[(0, .1, 5), (3, .2, 5), (9, 9, 5)], [(6, -.1, 5), (0, .5, 5), (9, 0, 5)]])


@pytest.mark.parametrize("key", [0, -1, (1, 2), slice(None, None, 2), (slice(None), 1), ..., [1, 0],
                                 np.array([[True, False, True], [False, True, False]]), None])
@pytest.mark.parametrize("is_known", [False, True])
def test_a_part_of_hits_has_the_same_of_each(tracer, key, is_known):
    hits = tracer.intersect(rays(), (0, 0, -1))
    if is_known:
        assert hits.point.shape == (2, 3, 3)
    some = hits[key]
    assert isinstance(some, ts.Hits) and some.shape == hits.t[key].shape
    whole = tracer.intersect(rays(), (0, 0, -1))
    for name in ATTRIBUTES:
        expected = getattr(whole, name)[key]
        assert np.array_equal(getattr(some, name), expected, equal_nan=expected.dtype.kind == "f"), name


def test_parts_are_those_of_arrays(tracer):
    hits = tracer.intersect(rays(), (0, 0, -1), fields=("t", "uv"))
    assert [one.shape for one in hits] == [(3,), (3,)] and hits[0, 1].uv.shape == (2,)
    assert hits[hits.hit].t.tolist() == hits.t[hits.hit].tolist()
    with pytest.raises(IndexError):
        hits[2]
    with pytest.raises(ts.UsageError, match="^fields: t.*; expected all"):
        hits[0].normal


def test_the_truth_of_hits_is_that_of_arrays(tracer):
    hits = tracer.intersect(rays(), (0, 0, -1))
    for several in (hits, hits[0], hits[:0]):
        with pytest.raises(ValueError, match=r"ambiguous; expected hits\.hit\.any\(\)"):
            bool(several)
    assert hits[0, 0] and not hits[0, 2] and len(hits) == 2
    with pytest.raises(TypeError, match="no length"):
        len(hits[0, 0])


def test_hits_without_what_tells_a_hit_are_shown(tracer):
    assert repr(tracer.intersect((0, 0, 5), (0, 0, -1), fields="uv")) == "<Hits ()>"


@pytest.mark.parametrize("make", [np.array, lambda a: np.array(a)[...], lambda a: np.asfortranarray(a),
                                  lambda a: np.array(a, np.float32)])
def test_hits_know_the_rays_that_were_asked(tracer, make):
    origins, directions = make(rays()), make(np.array((0, 0, -1.)))
    expected = tracer.intersect(origins.copy(), directions.copy()).normal
    hits = tracer.intersect(origins, directions)
    every = tracer.intersect_all(origins, directions)
    kept = tracer.intersect_all(origins.copy(), directions.copy()).normal
    origins += 7
    directions *= -1
    assert np.array_equal(hits.normal, expected, equal_nan=True) and np.array_equal(every.normal, kept)


def test_rays_that_nobody_can_change_are_not_copied(tracer):
    origins, directions = tracer.camera_rays(size=(8, 4))
    hits = tracer.intersect(origins, directions)
    assert np.shares_memory(hits._rays[0], origins) and np.shares_memory(hits._rays[1], directions)
    view = np.array(origins)[:]
    view.flags.writeable = False  # what it is a view of can be written to
    assert not np.shares_memory(tracer.intersect(view, directions)._rays[0], view)


def test_results_are_read_only(tracer):
    hits, every = tracer.intersect(rays(), (0, 0, -1)), tracer.intersect_all(rays(), (0, 0, -1))
    results = [getattr(hits, name) for name in ATTRIBUTES] + [getattr(hits[0], name) for name in ATTRIBUTES]
    results += [every.t, every.offsets, every.counts, every.ray, every.point]
    results += [tracer.occluded(rays(), (0, 0, -1)), tracer.crossings(rays(), (0, 0, -1)), tracer.bounds,
                tracer.contains(rays()), tracer.spawn(hits, (0, 0, 1)), *tracer.camera_rays(size=(2, 2))]
    for array in results:
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="cannot set WRITEABLE"):
            array.flags.writeable = True


def test_those_for_users_of_trimesh_can_be_written_to():
    mesh = MeshIntersector([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    ray = [(.2, .2, 1)], [(0, 0, -1)]
    results = [*mesh.intersects_location(*ray), *mesh.intersects_location(*ray, multiple_hits=False),
               mesh.intersects_first(*ray), mesh.intersects_any(*ray), mesh.contains_points(ray[0])]
    assert all(array.flags.writeable for array in results)


@pytest.mark.parametrize("key", [..., 0])
def test_pickled_hits_are_without_the_scene(key):
    large = ts.Scene(nodes=[ts.Mesh(np.random.default_rng(3).normal(size=(30_000, 3)), name="cloud")])
    tracer = large.tracer()
    hits = tracer.intersect(rays() * .1, (0, 0, -1))[key]
    data = pickle.dumps(hits)
    assert len(data) < 10_000 < len(pickle.dumps(large))
    again = pickle.loads(data)
    for name in ATTRIBUTES:
        assert np.array_equal(getattr(again, name), getattr(hits, name), equal_nan=True), name
        assert not getattr(again, name).flags.writeable
    assert again.hit.any() and again.name(np.unravel_index(again.hit.argmax(), again.shape)) == "cloud"
    assert np.array_equal(tracer.spawn(again, (0, 0, 1)), tracer.spawn(hits, (0, 0, 1)), equal_nan=True)
    assert np.array_equal(again[:1].normal, hits[:1].normal, equal_nan=True)


def test_other_hits_pickle_too(tracer):
    every = tracer.intersect_all(rays(), (0, 0, -1))
    again = pickle.loads(pickle.dumps(every))
    assert np.array_equal(again.offsets, every.offsets) and np.array_equal(again.normal, every.normal)
    assert again.ray_shape == (2, 3) and len(again) == len(every) > 0
    assert not again.offsets.flags.writeable
    nearest = pickle.loads(pickle.dumps(tracer.intersect(rays(), (0, 0, -1), fields="t")))
    assert nearest.t.shape == (2, 3)
    with pytest.raises(ts.UsageError, match="^fields: t.*; expected all"):
        nearest.point
    assert "rays" in tracer.intersect(rays(), (0, 0, -1), fields="uv")._repr_html_()
    assert copy.copy(every) is copy.deepcopy(every) is every


def test_a_line_along_a_cylinder_that_hardly_comes_nearer_misses_it():
    tracer = ts.Scene(nodes=[ts.Cylinder()]).tracer()
    for across in (0, 1e-300, 1e-200, 1e-160, 1e-150, 1e-100):
        assert not tracer.intersect((-1, 0, 2), (across, 1, 0)).hit
        assert tracer.intersect((-.5, -3, .5), (across, 1, 0)).t == 2
    # It does come there in the end.
    assert ts.Cylinder(1, 1e100).intersect((-3, 0, 0), (1e-200, 1e-205, 0)).t == pytest.approx(2e200)


@pytest.mark.parametrize("shape", [ts.Plane(), ts.Sphere(), ts.Box(), ts.Cylinder(), ts.Disc(normal=(0, 1, 0)),
                                   ts.Mesh([(-9, 0, -9), (9, 0, -9), (0, 0, 9)], [(0, 1, 2)])])
def test_what_is_farther_than_any_number_is_not_hit(shape):
    tracer = ts.Scene(nodes=[shape]).tracer()
    ray = (0, 1e10, 0), (0, -1e-300, 0)
    for fields in (None, "t", "instance"):
        assert not tracer.intersect(*ray, fields=fields).hit
    assert not tracer.occluded(*ray) and len(tracer.intersect_all(*ray)) == 0
    near = tracer.intersect((0, 10, 0), (0, -1e-300, 0))
    assert near.hit and np.isfinite(near.t)


def test_one_shape_answers_for_itself():
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    mesh = ts.Mesh(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], material="undefined", closed=True,
                   transform=ts.translate(5, 0, 0))
    assert mesh.contains([(5.1, .1, .1), (.1, .1, .1)]).tolist() == [True, False]
    tracer = mesh.tracer(accel="octree", threads=1)
    assert tracer.intersect([(5.1, .1, 9), (.1, .1, 9)], (0, 0, -1)).hit.tolist() == [True, False]
    assert ts.Node(shape=ts.Sphere()).contains((0, .5, 0)) and not ts.Sphere().contains((0, 1.5, 0))
