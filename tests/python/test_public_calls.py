"""What holds for every public call of the package. What large inputs are needed for is in
test_large_inputs.py."""
import contextlib
import functools
import inspect
import re

import numpy as np
import pytest
import tessera as ts
from public_calls import LARGE, SMALL, UNIT, is_special, public_calls
from tessera import _core, compat

CALLS = public_calls()


def function_of(call):
    """What Python runs: of a property that reads."""
    return call.fget if isinstance(call, property) else call.func if isinstance(
        call, functools.cached_property) else call


def parameters_of(call):
    """The annotations by name; none of what is written in C++."""
    try:
        parameters = inspect.signature(function_of(call)).parameters.values()
    except (TypeError, ValueError):
        return {}
    return {each.name: str(each.annotation) for each in parameters if each.name not in ("self", "cls", "unknown")}


def test_each_call_is_in_one_table():
    small = [name for names in SMALL.values() for name in names.split()]
    assert len(small) == len(set(small))
    assert set(small) & set(LARGE) == set()
    assert set(small) | set(LARGE) == set(CALLS)


# Words: units, ranges, shapes and errors.

NUMBER = re.compile(r"\b(float|int)\b")
ARRAY = re.compile(r"ArrayLike|VectorLike|TransformsLike|NDArray|Doubles|Floats|Numbers|Bools|Integers|Rows")
SHAPE = re.compile(r"\((\.\.\.|[a-z0-9]+)(, [^()]*)?,?\)|\b(shape|vectors?|points?)\b")
ERROR = re.compile(r"Raises|Error|Warning|refuse")


def owner_of(name):
    owner = name.rpartition(".")[0]
    return vars(ts).get(owner) or getattr(compat, owner, None)


def own_words(name, call):
    """The docstring of a call; that of the class of a constructor."""
    return inspect.getdoc(owner_of(name) if name.endswith(".__init__") else function_of(call)) or ""


WORDS = {name: own_words(name, call) for name, call in CALLS.items()}


def words_of(name):
    """The words of a call, and of calls that it refers to."""
    referred = re.findall(r"`(\w+(?:\.\w+)?)`", WORDS[name])
    return "\n".join([WORDS[name], *(WORDS.get(each, WORDS.get(f"{each}.__init__", "")) for each in referred)])


def is_field(made, name):
    """Whether a class has words for the field of that name: a line, or those of an attribute."""
    held = inspect.getattr_static(made, name, None)
    return bool(re.search(rf"^    {name}: \S", inspect.getdoc(made), re.M) or held is not None and held.__doc__)


def missing_words(name, call):
    words, parameters = words_of(name), parameters_of(call)
    returned = str(getattr(function_of(call), "__annotations__", {}).get("return", ""))
    kinds = "; ".join((returned, *parameters.values()))
    told = {parameter for parameter in parameters if re.search(rf"\b{parameter}\b", words)}
    if re.search("`tessera (render|submit)`|options [^.]*those of `render`", WORDS[name]):  # whose help tells them
        told |= set(function_of(call).__kwdefaults__ or ())
    if name.endswith(".__init__") or inspect.ismethod(call):  # of the class, which makes one by its fields
        told |= {parameter for parameter in parameters if is_field(owner_of(name), parameter)}
    for parameter in parameters.keys() - told:
        if NUMBER.search(parameters[parameter]) and not ARRAY.search(parameters[parameter]):
            yield f"what {parameter} is"
    if ARRAY.search(kinds) and not SHAPE.search(words):
        yield "a shape"
    if NUMBER.search(kinds) and not UNIT.search(words):
        yield "a unit or range"
    if parameters and not ERROR.search(words):
        yield "an error"


@pytest.mark.parametrize("name", [name for name in CALLS if not is_special(name)])
def test_the_words_tell_units_ranges_shapes_and_errors(name):
    assert WORDS[name]
    assert list(missing_words(name, CALLS[name])) == []


def test_missing_words_are_found(monkeypatch):
    class Cup(ts.Value):
        """A number of things, by default few. Raises UsageError.

        Attributes:
            high: metres
        """

        _FIELDS = ("high", "wide")
        wide = None

        def __init__(self, high: "float", wide: "float", made: "float" = 1):
            """Makes one."""

        def moved(self, points: "ArrayLike", far: "float", *, spp: "int" = 1) -> "Doubles":  # noqa: F821
            """Somewhere else, a number of things from above, by default on, of full length."""

    monkeypatch.setattr(ts, "Cup", Cup, raising=False)

    def missing(name, words=None):
        call = getattr(Cup, name)
        monkeypatch.setitem(WORDS, f"Cup.{name}", words or own_words(f"Cup.{name}", call))
        return set(missing_words(f"Cup.{name}", call))

    assert missing("__init__") == {"what wide is", "what made is"}
    assert missing("moved") == {"what far is", "what spp is", "a shape", "a unit or range", "an error"}
    assert missing("moved", "As `tessera render` does with points, so many metres far. Raises UsageError.") == set()
    assert missing("moved", "As `tessera render` does with points, in metres. Raises UsageError.") == {"what far is"}
    assert missing("moved", "As `tessera.rays` does with points (n, 3), so many metres far. Raises UsageError.") == {
        "what spp is"}


# Arrays: subclasses of numpy's.

CORNERS = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
TRIANGLE, ROWS = CORNERS[:3], np.array([(0, 1, 2)])
ORIGINS, DIRECTIONS, ENDS = CORNERS[:4] + (0, 0, 5), np.array([(0., 0, -1)] * 4), np.array([.5, .5, 9, 9])
MATRIX, COLORS = np.eye(4)[:3], np.array([(.5, .5, .5)] * 3)
VECTOR = np.array((1., 2, 3))
SPHERE, TRACER = ts.Sphere(), ts.Sphere().tracer()
INSIDE = compat.MeshIntersector(CORNERS, [(0, 1, 2), (4, 5, 6)])
HITS = TRACER.intersect(ORIGINS, DIRECTIONS)


def rays_of(call, result):
    """The four arguments of a query."""
    found = lambda *rays, **ends: getattr(call(*rays, **ends), result) if result else call(*rays, **ends)  # noqa: E731
    first, second = ("origin", "direction") if call == SPHERE.intersect else ("origins", "directions")
    return {first: (ORIGINS, lambda a: found(a, DIRECTIONS)), second: (DIRECTIONS, lambda a: found(ORIGINS, a)),
            "t_min": (ENDS, lambda a: found(ORIGINS, DIRECTIONS, t_min=a)),
            "t_max": (ENDS, lambda a: found(ORIGINS, DIRECTIONS, t_max=a))}


def of_mesh(made):
    fields = {"normals": TRIANGLE + 1, "uvs": TRIANGLE[:, :2], "second_uvs": TRIANGLE[:, 1:],
              "colors": COLORS, "face_materials": np.array([0]),
              "tangents": np.ones((3, 4))}
    return {field: (array, lambda a, field=field: made(**{field: a})) for field, array in fields.items()}


def meshlike():
    class Source:
        vertices, faces = TRIANGLE, ROWS
    return Source


def posed(rows):
    camera = ts.Camera()
    camera.pose = rows
    return camera


def transformed(array):
    instances = ts.Instances("ball", [MATRIX])
    instances.transforms = array
    return instances


def vectors(call, *names, good=CORNERS):
    """One vector after the other as the array, the others as they are."""
    rows = list(good[:len(names)])
    return {name: (rows[i], lambda a, i=i: call(*rows[:i], a, *rows[i + 1:])) for i, name in enumerate(names)}


#: By call and parameter: an array that is taken, and the call with it.
ARRAYS = {
    "Box.from_corners": {"corners": (CORNERS, ts.Box.from_corners)},
    "Camera.look_at": vectors(ts.Camera.look_at, "eye", "target", "up", good=CORNERS[1:]),
    "Camera.pose": {"rows": (MATRIX, posed)},
    "Camera.screen": vectors(lambda eye, centre: ts.Camera.screen(eye, centre, 1), "eye", "centre"),
    "Image.apply": {"f": (np.ones((2, 2, 3)), lambda a: ts.Image.from_array(np.zeros((2, 2, 3))).apply(lambda _: a))},
    "Image.from_array": {"array": (np.ones((2, 2, 3)), ts.Image.from_array)},
    "ImageTexture.__init__": {
        "picture": (np.ones((2, 2, 3), "f4"), ts.ImageTexture),
        "texels": (np.ones((12,), "f4"), lambda a: ts.ImageTexture(texels=a, width=2, height=2, channels=3, bits=32))},
    "Instances.__init__": {"transforms": (MATRIX[None], lambda a: ts.Instances("ball", a))},
    "Instances.transforms": {"given": (MATRIX[None], transformed)},
    "Mesh.__init__": {"positions": (TRIANGLE, ts.Mesh), "triangles": (ROWS, lambda a: ts.Mesh(TRIANGLE, a)),
                      **of_mesh(functools.partial(ts.Mesh, TRIANGLE, ROWS))},
    "Mesh.from_": of_mesh(functools.partial(ts.Mesh.from_, meshlike())),
    "MeshIntersector.__init__": {
        "vertices": (CORNERS, lambda a: compat.MeshIntersector(a, ROWS).intersects_first(ORIGINS, DIRECTIONS)),
        "faces": (ROWS, lambda a: compat.MeshIntersector(CORNERS, a).intersects_first(ORIGINS, DIRECTIONS))},
    "MeshIntersector.contains_points": {"points": (ORIGINS, INSIDE.contains_points)},
    **{f"MeshIntersector.{name}": {
        "ray_origins": (ORIGINS, lambda a, call=getattr(INSIDE, name): call(a, DIRECTIONS)),
        "ray_directions": (DIRECTIONS, lambda a, call=getattr(INSIDE, name): call(ORIGINS, a))}
       for name in ("intersects_id", "intersects_location", "intersects_first", "intersects_any")},
    "Placed.contains": {"points": (ORIGINS, SPHERE.contains)},
    "Placed.copy": {"v": (VECTOR, lambda a: ts.Sphere().copy(a))},
    "Placed.intersect": rays_of(SPHERE.intersect, "t"),
    "Placed.reflect": {"point": (VECTOR, lambda a: ts.Sphere().reflect(a))},
    "Placed.shift": {"v": (VECTOR, lambda a: ts.Sphere().shift(a))},
    "Plane.through": vectors(ts.Plane.through, "a", "b", "c"),
    "Rectangle.from_corners": vectors(ts.Rectangle.from_corners, "a", "b", "c", "d"),
    "Scene.instances": {"transforms": (MATRIX[None], lambda a: ts.Scene().instances(SPHERE, a))},
    "Tracer.contains": {"points": (ORIGINS, TRACER.contains)},
    "Tracer.crossings": rays_of(TRACER.crossings, None),
    "Tracer.intersect": rays_of(TRACER.intersect, "t"),
    "Tracer.intersect_all": rays_of(TRACER.intersect_all, "t"),
    "Tracer.occluded": rays_of(TRACER.occluded, None),
    "Tracer.spawn": {"directions": (DIRECTIONS, lambda a: TRACER.spawn(HITS, a))},
    "Triangle": vectors(ts.Triangle, "a", "b", "c"),
    "color": {"given": (VECTOR, ts.color)},
    "look_at": vectors(ts.look_at, "eye", "target", "up", good=CORNERS[1:]),
    "matrix": {"rows": (MATRIX, ts.matrix)},
    "reflect": vectors(ts.reflect, "v", "n", good=CORNERS[1:]),
    "rotate": {"axis": (VECTOR, lambda a: ts.rotate(a, 90))},
}
#: What they take as colours or pictures is read as `color` and `ImageTexture` read it.
COLOR_LIKE = {"Classic.toolbox": {"colour", "emission", "absorption"}, "Scene.__init__": {"ambient", "background"}}


class Tagged(np.ndarray):
    """A subclass that carries what is no part of its numbers."""

    tag = "metres"


def plain(result):
    """What was made, such that equal things are equal: values by what describes them."""
    if isinstance(result, ts.Value):
        return _core.describe(ts.Scene(nodes=[result])) if isinstance(result, ts.Instances) else _core.describe(result)
    return tuple(map(plain, result)) if type(result) is tuple else result


def are_equal(a, b):
    if type(a) is tuple:
        return all(map(are_equal, a, b))
    return np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b


def arrays_in(result):
    return [each for part in result for each in arrays_in(part)] if type(result) is tuple else [result] * isinstance(
        result, np.ndarray)


def test_each_call_that_takes_arrays_is_known():
    taking = {}
    for name, call in CALLS.items():
        parameters = parameters_of(call.fset if isinstance(call, property) and call.fset else call)
        found = {parameter for parameter, kind in parameters.items()
                 if re.search("ArrayLike|VectorLike|TransformsLike|ColorLike|ColorInputLike|Doubles", kind)}
        if found - COLOR_LIKE.get(name, set()):
            taking[name] = found
    assert {name: set(parameters) for name, parameters in ARRAYS.items()} == taking


@pytest.mark.parametrize("name, parameter", [(name, each) for name, known in ARRAYS.items() for each in known])
def test_subclasses_of_arrays_are_taken_or_refused(name, parameter):
    array, call = ARRAYS[name][parameter]
    wanted = plain(call(array))
    for same in (array.view(Tagged), np.ma.array(array)):
        result = plain(call(same))
        assert are_equal(result, wanted)
        assert all(type(each) is np.ndarray for each in arrays_in(result))
    if array.ndim == 2:
        with contextlib.suppress(TypeError):  # where rows are looked at one by one, which are matrices too
            assert are_equal(plain(call(np.asmatrix(array))), wanted)
    masked = np.ma.array(array, mask=np.arange(array.size).reshape(array.shape) == 0)
    with pytest.raises(ValueError, match="masked values; expected none|a MaskedConstant; expected a finite number"):
        plain(call(masked))


# Errors: ours, that tell what was found and what was expected, and of scenes the script's line.

IMAGE, SCENE = ts.Image.from_array(np.zeros((2, 2, 3))), ts.Scene(nodes=[SPHERE])
MESH = ts.Mesh(TRIANGLE, ROWS)


def farm():
    return ts.Farm("ipc:///nobody", timeout=.1)


def job():
    return ts.Job(farm(), 1)


def task():
    return SCENE.render(size=(2, 2), spp=1, workers=0, wait=False)


#: By call, one that is wrong.
WRONG = {
    "Array.__getitem__": lambda: _core.take_array([(0, 0, 0)], "positions")["x"],
    "Array.from_bytes": lambda: ts.Array.from_bytes(b"123", "d", [1]),
    "Array.of": lambda: ts.Array.of(["x"], "d", [1]),
    "Box.from_corners": lambda: ts.Box.from_corners(CORNERS[:3]),
    "Camera.from_intrinsics": lambda: ts.Camera.from_intrinsics(0, 1, 2, 3, 4, 5),
    "Camera.look_at": lambda: ts.Camera.look_at(TRIANGLE[0], TRIANGLE[1], fow=40),
    "Camera.screen": lambda: ts.Camera.screen((0, 0), (0, 0, 1), 1),
    "Classic.toolbox": lambda: ts.Classic.toolbox(colour="rot"),
    "Farm.__init__": lambda: ts.Farm(timeout=-1),
    "Farm.job": lambda: farm().job(None),
    "Farm.submit": lambda: farm().submit(SCENE, priority=10**6),
    "Hits.__getitem__": lambda: HITS["x"],
    "Image.__array__": lambda: IMAGE.__array__("x"),
    "Image.aov": lambda: IMAGE.aov("depht"),
    "Image.apply": lambda: IMAGE.apply(lambda light: light[0]),
    "Image.from_array": lambda: ts.Image.from_array([1]),
    "Image.save": lambda: IMAGE.save("x.nothing"),
    "Image.to_srgb": lambda: IMAGE.to_srgb(tone_map="x"),
    "ImageTexture.__init__": lambda: ts.ImageTexture("nowhere.png"),
    "Instances.__init__": lambda: ts.Instances("ball", TRIANGLE),
    "Job.fetch": lambda: job().fetch(denoise="x"),
    "Job.resume": lambda: job().resume(10**6),
    "Job.snapshot": lambda: job().snapshot(1.5),
    "Job.wait": lambda: job().wait("x"),
    "Job.watch": lambda: job().watch(-1),
    "Lens.__init__": lambda: ts.Lens(raduis=1),
    "LocalFarm.__init__": lambda: ts.LocalFarm(0),
    "Located.name": lambda: HITS.name("x"),
    "Mesh.__init__": lambda: ts.Mesh(TRIANGLE, ROWS + 1),
    "Mesh.from_": lambda: ts.Mesh.from_(3),
    "Mesh.merge_vertices": lambda: MESH.merge_vertices(-1),
    "MeshIntersector.__init__": lambda: compat.MeshIntersector(TRIANGLE, ROWS + 1),
    "MeshIntersector.contains_points": lambda: INSIDE.contains_points([1]),
    "MeshIntersector.intersects_any": lambda: INSIDE.intersects_any([1], [2]),
    "MeshIntersector.intersects_first": lambda: INSIDE.intersects_first([1], [2]),
    "MeshIntersector.intersects_id": lambda: INSIDE.intersects_id([1], [2]),
    "MeshIntersector.intersects_location": lambda: INSIDE.intersects_location([1], [2]),
    "Placed.contains": lambda: SPHERE.contains([1]),
    "Placed.copy": lambda: ts.Sphere().copy("x").tracer(),
    "Placed.intersect": lambda: SPHERE.intersect([1], [2]),
    "Placed.mirror": lambda: ts.Sphere().mirror(3),
    "Placed.reflect": lambda: ts.Sphere().reflect(3),
    "Placed.shift": lambda: ts.Sphere().shift("x").tracer(),
    "Placed.tracer": lambda: ts.Sphere().tracer(accel="x"),
    "Plane.through": lambda: ts.Plane.through((0, 0, 0), (1, 0, 0), (2, 0, 0)),
    "Rectangle.from_corners": lambda: ts.Rectangle.from_corners((0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 0)),
    "Scene.__init__": lambda: ts.Scene(widht=3),
    "Scene.add": lambda: ts.Scene().add(3),
    "Scene.check": lambda: SCENE.check(assets=3),
    "Scene.find": lambda: SCENE.find("nothing"),
    "Scene.frames": lambda: SCENE.frames(),
    "Scene.info": lambda: SCENE.info(assets=3),
    "Scene.instances": lambda: ts.Scene().instances(SPHERE, TRIANGLE),
    "Scene.render": lambda: SCENE.render(spp=-1),
    "Scene.save": lambda: SCENE.save("x.nothing"),
    "Scene.tracer": lambda: SCENE.tracer(accel="x"),
    "Task.result": lambda: task().result("x"),
    "Threads.__init__": lambda: ts.Threads(0),
    "Tracer.camera_rays": lambda: TRACER.camera_rays((0, 1)),
    "Tracer.contains": lambda: TRACER.contains([1]),
    "Tracer.crossings": lambda: TRACER.crossings([1], [2]),
    "Tracer.intersect": lambda: TRACER.intersect([1], [2]),
    "Tracer.intersect_all": lambda: TRACER.intersect_all([1], [2]),
    "Tracer.occluded": lambda: TRACER.occluded([1], [2]),
    "Tracer.spawn": lambda: TRACER.spawn(3, VECTOR),
    "Transform.__matmul__": lambda: ts.translate(1, 2, 3) @ [1.],
    "Transform.inverse": lambda: ts.scale(0).inverse(),
    "Triangle": lambda: ts.Triangle((0, 0), (1, 0), (0, 1)),
    "Vec.__getitem__": lambda: ts.Vec(1, 2, 3)[3],
    "Vec.__init__": lambda: ts.Vec(1, 2, "x"),
    "Vec.cross": lambda: ts.Vec(1, 2, 3).cross(3),
    "Vec.dot": lambda: ts.Vec(1, 2, 3).dot(3),
    "Vec.normalized": lambda: ts.Vec(0, 0, 0).normalized(),
    "color": lambda: ts.color("rot"),
    "compare": lambda: ts.compare(IMAGE, ts.Image.from_array(np.zeros((3, 3, 3)))),
    "hsl": lambda: ts.hsl(0, 2, 0),
    "keys": lambda: ts.keys([3]),
    "load": lambda: ts.load("nowhere.tessera"),
    "load_dict": lambda: ts.load_dict({"nodes": 3}),
    "look_at": lambda: ts.Scene(camera=ts.Camera(world_from_camera=ts.look_at(3, 4))).check(),
    "matrix": lambda: ts.matrix([1]),
    "read_image": lambda: ts.read_image("nowhere.png"),
    "reflect": lambda: ts.reflect((1, 0, 0), (0, 0, 0)),
    "render": lambda: ts.render("nowhere.tessera"),
    "rotate": lambda: ts.rotate("w", 90),
    "scale": lambda: ts.scale(1, 2),
    "solve_quadratic": lambda: ts.solve_quadratic(1, 2, float("inf")),
    "translate": lambda: ts.translate(1, 2),
}
#: Operators that Python refuses where both sides return NotImplemented.
OPERATOR = re.compile(r".*\.__(r?(add|sub|mul|truediv|floordiv|mod|pow|matmul|and|or)|lt|le|gt|ge)__")
TAKES_ANYTHING = re.compile(r".*\.__(eq|reduce_ex|deepcopy|exit)__")
#: The beginnings of errors that numpy tells: of wrong indices and types of elements.
OF_NUMPY = {"Hits.__getitem__": "only integers, slices", "Image.__array__": "data type 'x' not understood",
            "Located.name": "only integers, slices"}


def test_each_call_with_parameters_has_a_wrong_one():
    with_parameters = {name for name, call in CALLS.items() if parameters_of(call)}
    left = {name for name in with_parameters - set(WRONG) if not OPERATOR.fullmatch(name)}
    assert left == set(filter(TAKES_ANYTHING.fullmatch, with_parameters)) and set(WRONG) <= set(CALLS)


@pytest.mark.parametrize("name", WRONG)
def test_errors_are_ours(name):
    with pytest.raises((ts.Error, TypeError, ValueError, IndexError)) as told:
        WRONG[name]()
    assert re.search(OF_NUMPY.get(name, "; expected |did you mean"), str(told.value)), told.value


@pytest.mark.parametrize("name", [name for name in CALLS if OPERATOR.fullmatch(name)])
def test_operators_leave_what_they_do_not_know_to_the_other_side(name):
    owner, _, operator = name.rpartition(".")
    left = {"Color": ts.color("red"), "Placed": SPHERE, "Transform": ts.scale(2), "Vec": ts.Vec(VECTOR)}[owner]
    assert getattr(left, operator)(object()) is NotImplemented


def wrong_scene():
    """A scene with a part that is wrong, and where that is made."""
    shape = ts.Sphere(radius="x")
    line = inspect.currentframe().f_lineno - 1
    return ts.Scene(nodes=[shape]), f"{__file__}:{line}"


@pytest.mark.parametrize("use", [
    lambda scene: scene.render(size=(2, 2), workers=0), lambda scene: ts.render(scene, workers=0, wait=False),
    lambda scene: next(scene.frames(0, 1, workers=0)), lambda scene: scene.check(), lambda scene: scene.tracer(),
    lambda scene: scene.digest, lambda scene: scene.info(), lambda scene: scene.to_dict(),
    lambda scene: scene.save("x.tessera"), lambda scene: scene.nodes[0].tracer(),
    lambda scene: scene.nodes[0].intersect(VECTOR, VECTOR), lambda scene: scene.nodes[0].contains(VECTOR),
    lambda scene: farm().submit(scene), lambda scene: scene._repr_html_()])
def test_whatever_uses_a_scene_tells_the_line_that_made_what_is_wrong(use):
    scene, line = wrong_scene()
    with pytest.raises(ts.SceneError) as told:
        use(scene)
    assert told.value.place == line and str(told.value).startswith(f"{line}: ")
    assert "radius: " in str(told.value) and "; expected a number" in str(told.value)
