"""Whatever a script hands over, it gets a result or an exception of Python, never the end of it."""
import math
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import tessera as ts

EXAMPLES = int(os.environ.get("TESSERA_FUZZ_EXAMPLES", "200"))
FUZZ = settings(max_examples=EXAMPLES, deadline=None, derandomize=True,
                suppress_health_check=list(HealthCheck))
EXPECTED = (ValueError, TypeError, AttributeError, IndexError, OverflowError, MemoryError, ts.Error)

numbers = st.one_of(st.floats(), st.integers(-2**70, 2**70), st.sampled_from([0, 1, -1, 1e-300, 1e300]))
junk = st.one_of(st.none(), st.booleans(), numbers, st.text(max_size=8), st.binary(max_size=8),
                 st.lists(numbers, max_size=5))
vectors = st.one_of(st.lists(numbers, min_size=3, max_size=3), junk)
dtypes = st.sampled_from(["f4", "f8", ">f4", "f2", "i4", "u4", "i8", "u8", ">i8", "u1", "?", "c8", "O"])


@st.composite
def arrays(draw):
    """Arrays of any shape, type, byte order and stride."""
    shape = draw(st.lists(st.sampled_from([0, 1, 2, 3, 4, 7]), max_size=3))
    values = draw(st.lists(numbers, min_size=1, max_size=8))
    with np.errstate(all="ignore"):
        try:
            array = np.resize(np.array(values, dtype=float), shape).astype(draw(dtypes))
        except (OverflowError, ValueError):
            array = np.zeros(shape, draw(dtypes))
    if array.ndim and draw(st.booleans()):
        array = array[::-1]
    array = array.T if draw(st.booleans()) else array
    array.flags.writeable = draw(st.booleans())
    return array


@pytest.fixture(scope="module")
def farm():
    with ts.Threads(1) as threads:
        yield threads


def used(scene, farm):
    """Renders and traces a scene."""
    scene.render(size=(4, 3), spp=1, farm=farm)
    scene.tracer(threads=1).intersect([[0, 0, 5]], [[0, 0, -1]]).point


kinds = st.sampled_from([ts.Sphere, ts.Plane, ts.HalfPlane, ts.Disc, ts.Rectangle, ts.Polygon, ts.Box,
                         ts.Cylinder, ts.Cone, ts.Torus, ts.PointLight, ts.SpotLight, ts.Classic,
                         ts.DirectionalLight, ts.BeamLight, ts.Physical, ts.Conductor, ts.Dielectric])


@FUZZ
@given(kinds, st.data())
def test_values(farm, kind, data):
    names = [name for name in dir(kind) if not name.startswith("_")]
    fields = data.draw(st.dictionaries(st.sampled_from(names), st.one_of(vectors, junk), max_size=4))
    try:
        value = kind(**fields)
        repr(value)
        scene = ts.Scene()
        if isinstance(value, ts.Material):
            scene.add(ts.Sphere(), material=value)
        else:
            scene.add(value)
        used(scene, farm)
    except EXPECTED:
        pass


@FUZZ
@given(arrays(), st.dictionaries(st.sampled_from(["triangles", "normals", "uvs", "colors", "face_materials"]),
                                 arrays()), st.sampled_from([None, True, False, "x"]))
def test_meshes(farm, positions, beside, copy):
    try:
        scene = ts.Scene()
        scene.add(ts.Mesh(positions, **beside, copy=copy))
        used(scene, farm)
    except EXPECTED:
        pass


@pytest.fixture(scope="module")
def tracer():
    scene = ts.Scene()
    scene.add(ts.Sphere(), ts.Box(), ts.Mesh(np.eye(3, dtype="f4"), [[0, 1, 2]]), ts.Torus())
    return scene.tracer(threads=1)


@FUZZ
@given(arrays(), arrays(), numbers, numbers, junk)
def test_rays(tracer, origins, directions, t_min, t_max, cull):
    for query in (tracer.intersect, tracer.occluded, tracer.intersect_all, tracer.crossings):
        try:
            query(origins, directions, t_min=t_min, t_max=t_max)
            query(origins, directions, cull=cull)
        except EXPECTED:
            pass
    try:
        tracer.contains(origins)
    except EXPECTED:
        pass


@FUZZ
@given(st.dictionaries(st.sampled_from(
    ["size", "crop", "spp", "min_spp", "target_error", "filter", "pattern", "seed", "integrator",
     "accel", "aovs", "time", "frame", "tile", "camera", "pinhole", "denoise", "place"]),
    st.one_of(junk, st.tuples(numbers, numbers)), min_size=1, max_size=3))
def test_keywords(farm, keywords):
    scene = ts.Scene(width=4, height=3)
    scene.add(ts.Sphere())
    large = {"size", "spp", "min_spp", "target_error"} & keywords.keys()
    if any(isinstance(keywords[name], (int, float, tuple, list)) for name in large):
        keywords = {name: value for name, value in keywords.items() if name not in large}
    try:
        scene.render(farm=farm, **keywords)
    except EXPECTED:
        pass


@FUZZ
@given(st.recursive(st.one_of(st.none(), st.booleans(), numbers.filter(
    lambda x: not isinstance(x, float) or math.isfinite(x)), st.text(max_size=6)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.sampled_from(
        ["nodes", "shape", "sphere", "radius", "center", "x", "mesh", "positions", "materials", "name",
         "cameras", "keys", "light", "point", "children", "settings", "width"]), inner, max_size=3)),
    max_leaves=10))
def test_dicts(description):
    try:
        ts.load_dict(description).to_dict()
    except EXPECTED:
        pass


@FUZZ
@given(arrays())
def test_pictures(array):
    try:
        image = ts.Image.from_array(array)
        image.to_srgb()
        image._repr_png_()
    except EXPECTED:
        pass
    try:
        ts.ImageTexture(array)
    except EXPECTED:
        pass
