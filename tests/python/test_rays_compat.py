"""`tessera.compat` against what trimesh's ray queries take and give."""
import inspect

import numpy as np
import pytest
from rays_scenes import cube
from tessera.compat import MeshIntersector

import tessera as ts

#: The arguments of trimesh 4's RayMeshIntersector, with their defaults.
SIGNATURES = {
    "intersects_id": [("ray_origins",), ("ray_directions",), ("return_locations", False),
                      ("multiple_hits", True)],
    "intersects_location": [("ray_origins",), ("ray_directions",), ("multiple_hits", True)],
    "intersects_first": [("ray_origins",), ("ray_directions",)],
    "intersects_any": [("ray_origins",), ("ray_directions",)],
    "contains_points": [("points",)],
}


@pytest.mark.parametrize("name", SIGNATURES)
def test_signatures(name):
    found = [(p.name,) if p.default is p.empty else (p.name, p.default)
             for p in inspect.signature(getattr(MeshIntersector, name)).parameters.values()
             if p.name != "self" and p.kind != p.VAR_KEYWORD]
    assert found == SIGNATURES[name]


@pytest.fixture(scope="module")
def box():
    return MeshIntersector(*cube(1, 1.0))


#: Through both of the sides of z, from outside; from inside; and past it.
ORIGINS = np.array([[0.25, 0.5, 5], [0.25, 0.5, 0.5], [3, 3, 3]])
DIRECTIONS = np.array([[0, 0, -1], [0, 0, -1], [0, 0, -1.0]])


def test_intersects_location(box):
    points, rays, triangles = box.intersects_location(ORIGINS, DIRECTIONS)
    assert points.dtype == np.float64 and rays.dtype == triangles.dtype == np.int64
    assert rays.tolist() == [0, 0, 1]
    assert points.tolist() == [[0.25, 0.5, 1], [0.25, 0.5, 0], [0.25, 0.5, 0]]
    assert triangles[1] == triangles[2] != triangles[0]
    points, rays, triangles = box.intersects_location(ORIGINS, DIRECTIONS, multiple_hits=False)
    assert rays.tolist() == [0, 1] and points[:, 2].tolist() == [1, 0]


def test_intersects_id(box):
    found = box.intersects_id(ORIGINS, DIRECTIONS)
    assert len(found) == 2 and found[1].tolist() == [0, 0, 1]
    triangles, rays, points = box.intersects_id(ORIGINS, DIRECTIONS, return_locations=True,
                                                multiple_hits=False)
    assert triangles.dtype == rays.dtype == np.int64 and points.shape == (2, 3)


def test_intersects_first_and_any(box):
    first = box.intersects_first(ORIGINS, DIRECTIONS)
    triangles, rays = box.intersects_id(ORIGINS, DIRECTIONS, multiple_hits=False)
    assert first.dtype == np.int64 and first.tolist() == [*triangles.tolist(), -1]
    some = box.intersects_any(ORIGINS, DIRECTIONS)
    assert some.dtype == bool and some.tolist() == [True, True, False]


def test_nothing_hit_gives_empty_arrays(box):
    points, rays, triangles = box.intersects_location(ORIGINS[2:], DIRECTIONS[2:])
    assert points.shape == (0, 3) and rays.shape == triangles.shape == (0,)


def test_positions_that_lose_precision_are_told():
    vertices, faces = cube(1, 1.0)
    with pytest.warns(ts.PrecisionWarning, match="rounded by up to") as told:
        MeshIntersector(vertices.astype("f8") + 1e7 + .1, faces)
    assert [warning.filename for warning in told] == [__file__]


def test_contains_points(box):
    inside = box.contains_points([[0.5, 0.5, 0.5], [1.5, 0.5, 0.5], [0.999, 0.001, 0.5]])
    assert inside.dtype == bool and inside.tolist() == [True, False, True]
