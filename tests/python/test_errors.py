"""What is wrong is told: the class, the place in the script, the way to it, the nearest name."""
import errno
import itertools
import os
import pathlib
import pickle

import numpy as np
import pytest

import tessera as ts
from conftest import SANITIZER
from tessera._callers import where

IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]
LINES = pathlib.Path(__file__).read_text(encoding="utf-8").splitlines()


def digest(*nodes, **fields):
    return ts.Scene(nodes=list(nodes), **fields).digest


def test_the_classes_are_what_python_has_for_them():
    assert issubclass(ts.SceneError, ValueError) and issubclass(ts.SceneError, ts.Error)
    assert issubclass(ts.MissingFile, FileNotFoundError) and issubclass(ts.MissingFile, ts.SceneError)
    assert issubclass(ts.Refused, PermissionError) and issubclass(ts.FarmError, ConnectionError)
    assert (ts.SceneError.code, ts.UsageError.code, ts.RenderError.code) == (1, 2, 3)


def test_a_wrong_value_tells_its_place_and_path():
    sphere = ts.Sphere(radius="big")
    line = test_a_wrong_value_tells_its_place_and_path.__code__.co_firstlineno + 1
    with pytest.raises(ts.SceneError) as told:
        digest(ts.Box(), ts.Node(shape=sphere))
    assert told.value.path == "nodes[1].shape.radius"
    assert told.value.place == f"{__file__}:{line}"
    assert str(told.value).endswith("nodes[1].shape.radius: 'big'; expected a number")


@pytest.mark.parametrize("make, expected", [
    (lambda: ts.Sphere((0, 0)), r"center: 2 numbers; expected 3"),
    (lambda: ts.Sphere(radius=float("nan")), "nan; expected a finite number"),
    (lambda: ts.Sphere(radius=ts.Box()), "a number"),
    (lambda: ts.Sphere(radius=True), "radius: True; expected a number"),
    (lambda: ts.Torus(major_radius=np.bool_(True)), "expected a number"),
    (lambda: ts.Sphere(transform=ts.Transform([ts.TransformStep(translate=(1, 2, "x"))])),
     r"nodes\[0\].transform.steps\[0\].translate: 'x'"),
    (lambda: ts.Node(shape=ts.Box(transform=ts.Transform([ts.TransformStep(scale=(1, 2, "x"))]))),
     r"nodes\[0\].shape.transform.steps\[0\].scale: 'x'"),
    (lambda: ts.Csg("unoin", []), "did you mean 'union'"),
    (lambda: ts.Sphere(name=3), "name: 3; expected text"),
    (lambda: ts.Sphere(name="\ud800"), "expected text"),
    (lambda: ts.Sphere(flip_normals=2), "True or False"),
    (lambda: ts.Node(shape=ts.PointLight()), "a Shape"),
    (lambda: ts.Sphere(material=ts.Box()), "a Material or the name of one"),
    (lambda: ts.Sphere(material=ts.Classic(diffuse="rde")), "did you mean 'red'"),
    (lambda: ts.PointLight(color=(1, 2, "x")), "'x'; expected a number"),
    (lambda: ts.PointLight(color=float("nan")), "color: nan; expected a finite number"),
    (lambda: ts.PointLight(color=None.__class__), "expected 3 numbers"),
])
def test_wrong_values(make, expected):
    with pytest.raises(ValueError, match=expected):
        digest(make())


def test_a_wrong_colour_tells_its_place_and_the_nearest_name():
    material = ts.Classic(diffuse="rde")
    line = test_a_wrong_colour_tells_its_place_and_the_nearest_name.__code__.co_firstlineno + 1
    with pytest.raises(ts.SceneError) as told:
        digest(ts.Sphere(material=material))
    assert str(told.value) == (f"{__file__}:{line}: nodes[0].materials[0].diffuse: 'rde': no colour; expected a "
                               "name or '#rrggbb'; did you mean 'red'?")
    assert told.value.place == f"{__file__}:{line}" and told.value.suggestion == "red"


def test_a_wrong_texture_tells_its_place():
    material = ts.Classic(specular=memoryview(bytes(10)).cast("B", [1, 2, 5]))
    with pytest.raises(ts.SceneError, match=r"specular: texels: shape \(1, 2, 5\)") as told:
        digest(ts.Sphere(material=material))
    assert told.value.path == "nodes[0].materials[0].specular" and told.value.place.startswith(__file__)


def test_values_that_are_no_part_of_a_scene_equal_nothing():
    assert ts.Classic(diffuse="tomatoo") != ts.Classic(diffuse="tomato")
    assert ts.Classic(diffuse="tomatoo") != ts.Classic(diffuse=memoryview(bytes(10)).cast("B", [1, 2, 5]))


class Stops:
    """Ctrl-C, or whatever, while a number of the user's is read."""
    def __init__(self, what):
        self.what = what

    def __float__(self):
        raise self.what

    def __array__(self, *_):
        raise self.what

    def __index__(self):
        raise self.what


@pytest.mark.parametrize("what", [KeyboardInterrupt, MemoryError])
@pytest.mark.parametrize("make", [
    lambda stops: ts.Sphere(radius=stops), lambda stops: ts.Sphere(center=(stops, 0, 0)),
    lambda stops: ts.PointLight(color=(stops, 0, 0)), lambda stops: ts.ImageTexture(width=stops),
    lambda stops: ts.ImageTexture(texels=stops)])
def test_what_is_not_about_the_value_passes(make, what):
    for raised, expected in ((what, what), (RuntimeError, ts.SceneError)):
        value = make(Stops(raised))
        with pytest.raises(expected):
            digest(ts.Sphere(material=ts.Unlit(color=value)) if isinstance(value, ts.Texture) else value)


def test_whole_numbers_have_bounds():
    for width in (-1, 2**32, 2**70, 1.5):
        with pytest.raises(ts.SceneError, match="a whole number from 0 to 4294967295"):
            digest(width=width)


def test_a_choice_is_made_once():
    both = ts.Background()
    both.solid, both.gradient = "red", ts.BackgroundGradient()
    with pytest.raises(ts.SceneError, match="set besides solid"):
        digest(background=both)


def test_what_holds_itself_ends():
    node = ts.Node()
    node.children = [node]
    with pytest.raises(ts.SceneError, match="inside itself"):
        digest(node)
    material = ts.Classic()
    material.back = material
    with pytest.raises(ts.SceneError, match="refers to itself"):
        digest(ts.Sphere(material=material))


def test_what_is_nested_without_an_end_is_told_or_cut_off():
    node, description = ts.Node(), {"nodes": [{"children": []}]}
    node.children = [node]
    description["nodes"][0]["children"] = description["nodes"]
    deep = {}
    for _ in range(1000):
        deep = {"children": [deep]}
    line = test_what_is_nested_without_an_end_is_told_or_cut_off.__code__.co_firstlineno + 1
    for call, place in ((node.copy, f"{__file__}:{line}"), (node.flip, f"{__file__}:{line}"),
                        (lambda: ts.load_dict(description), "description"),
                        (lambda: ts.load_dict({"nodes": [deep]}), "description")):
        with pytest.raises(ts.SceneError, match=f"^{place}: something inside itself, or nested too deep"):
            call()
    assert repr(node) == "Node(children=<list of 1>)"
    assert repr(ts.Node(children=[ts.Node()])) == "Node(children=[Node()])"


def test_names_that_the_module_lacks_tell_the_nearest():
    with pytest.raises(AttributeError, match="^module 'tessera' has no attribute 'Sphre'; did you mean 'Sphere'"):
        ts.Sphre
    with pytest.raises(AttributeError, match="^module 'tessera' has no attribute '__sphere__'$"):
        ts.__sphere__
    with pytest.raises(AttributeError, match="^module 'tessera.compat' has no attribute 'MeshIntersecto'; did you mean "
                                             "'MeshIntersector'.$"):
        ts.compat.MeshIntersecto
    with pytest.raises(ImportError, match="cannot import name 'Sphre'"):
        from tessera import Sphre
    assert not hasattr(ts, "zzzz")


def test_a_name_that_is_no_utf8_is_refused_too():
    with pytest.raises(AttributeError, match="no attribute"):
        setattr(ts.Sphere(), "\udc80", "x")


def test_a_word_may_be_of_a_class_of_texts():
    class Word(str):
        pass
    assert ts.Scene(accel=Word("nonuniform_octree")) == ts.Scene(accel="nonuniform-octree")


def test_an_error_of_a_farm_has_its_endpoint_or_none():
    for error in (ts.FarmError("x"), ts.Refused("x"), pickle.loads(pickle.dumps(ts.FarmError("x")))):
        assert error.endpoint is None
    assert pickle.loads(pickle.dumps(ts.Refused("x", endpoint="tcp://a:1"))).endpoint == "tcp://a:1"


def test_wrong_names_tell_the_nearest():
    with pytest.raises(TypeError, match="no keyword 'centre'; did you mean 'center'"):
        ts.Sphere(centre=(0, 0, 0))
    for make, near in ((lambda: ts.Scene(hieght=9), "height"), (lambda: ts.Lens(radious=1), "radius"),
                       (lambda: ts.Classic(diffuse_color="red"), "diffuse"),
                       (lambda: ts.PointLight(shadow_distnce=1), "shadow_distance")):
        with pytest.raises(TypeError, match=f"did you mean '{near}'.$"):
            make()
    sphere = ts.Sphere()
    with pytest.raises(AttributeError, match="did you mean 'radius'"):
        sphere.radios = 3
    with pytest.raises(AttributeError, match="did you mean 'radius'"):
        sphere.radios


SCENE, IMAGE = ts.Scene(nodes=[ts.Sphere()]), ts.Image.from_array([[0.5, 1]])
SMALL = {"size": (4, 4), "workers": 0}


@pytest.mark.parametrize("call, message", [
    (lambda: ts.Mesh([], [], copy="x"), "copy: 'x'; expected True, False or None"),
    (lambda: ts.Vec(1, 2), "2 numbers; expected a vector of 3 numbers"),
    (lambda: ts.Vec(1, "a", 3), "'a'; expected a vector of 3 numbers"),
    (lambda: ts.Vec(w=1), "w: expected Vec(x, y, z) or Vec(components)"),
    (lambda: ts.solve_quadratic(1, "a", 3), "b: 'a'; expected a number"),
    (lambda: IMAGE.aov(1.5), "name: 1.5; expected the name of an AOV"),
    (lambda: SCENE.tracer().camera_rays((4, 4), camera=1j), "camera: 1j; expected text"),
    (lambda: ts.Array.of([[]], "", ()), "Array: elements of format ''"),
    (lambda: SCENE.render(place=3, **SMALL), "place: 3; expected text or several of them"),
    (lambda: ts.load(3), "path: 3; expected the path of a file"),
    (lambda: SCENE.save(3), "path: 3; expected the name of a file"),
    (lambda: IMAGE.save(3), "path: 3; expected the name of a file"),
    (lambda: ts.compare(IMAGE, np.zeros((2, 2, 3))), "b: a ndarray; expected an Image or the path of a file"),
    (lambda: SCENE.tracer().spawn(3, (0, 0, 1)), "hits: 3; expected Hits or AllHits"),
    (lambda: ts.Sphere().mirror((0, 1, 0)), "plane: (0, 1, 0); expected a Plane"),
    (lambda: ts.load_dict(None), "description: None; expected a dict"),
    (lambda: ts.Scene(response=abs), "response: a function; expected (a, b, c) of a x^2 + b x + c; any "
     "function is for Image.apply"),
])
def test_what_is_of_a_wrong_type_is_told_in_words_of_python(call, message):
    with pytest.raises(TypeError) as told:
        call()
    assert str(told.value) == message


@pytest.mark.parametrize("call, message", [
    (lambda: SCENE.render(size=(4, 4), workers=-1), "workers: -1; expected a whole number from 0 to 1024"),
    (lambda: SCENE.render(spp=True, **SMALL), "spp: True; expected a whole number from 1 to "),
    (lambda: SCENE.render(camera=True, **SMALL), "camera: True; expected CAMERA"),
    (lambda: SCENE.render(size=(64,), workers=0),
     "size: (64,); expected (width, height), whole numbers from 1 to 65536, such as (1920, 1080)"),
    (lambda: SCENE.render(crop=(1, 2), **SMALL), "crop: (1, 2); expected (x0, y0, x1, y1) with 0 <= x0 < x1 "),
    (lambda: SCENE.tracer().camera_rays((1, 2, 3)), "size: (1, 2, 3); expected (width, height), whole numbers"),
    (lambda: ts.Array.of([1], "d", (2,)), "Array: 8 bytes; expected 16"),
    (lambda: ts.color(itertools.repeat(1)), "color: repeat(1); expected a name, '#rrggbb', three numbers or one"),
    (lambda: ts.color((1, 2)), "color: (1, 2); expected a name, '#rrggbb', three numbers or one"),
    (lambda: ts.color(None), "color: None; expected a name"),
    (lambda: ts.hsl(0, 2, .5), "saturation: 2; expected a number from 0 to 1"),
    (lambda: ts.keys([(0,)]), "pairs: (0,); expected (time, transform)"),
    (lambda: ts.Array.of(["x"], "d", (1,)), "Array: required argument is not a float; expected numbers of the"),
])
def test_values_are_told_in_words_of_python(call, message):
    with pytest.raises(ValueError) as told:
        call()
    assert str(told.value).startswith(message)


@pytest.mark.parametrize("call, name, near", [
    (lambda: ts.LocalFarm(worker=1), "worker", "workers"), (lambda: ts.Farm(endpont="x"), "endpont", "endpoint"),
    (lambda: SCENE.tracer(acel="bvh"), "acel", "accel"), (lambda: SCENE.add(ts.Box(), nmae="x"), "nmae", "name"),
    (lambda: SCENE.instances(ts.Box(), [], name="x"), "name", "names"),
    *((lambda query=query: getattr(SCENE.tracer(), query)((0, 0, 9), (0, 0, 1), tmax=3), "tmax", "t_max")
      for query in ("intersect", "occluded", "intersect_all", "crossings")),
    (lambda: SCENE.tracer().contains((0, 0, 0), shpae=1), "shpae", "shape"),
    (lambda: SCENE.tracer().camera_rays(sise=(1, 1)), "sise", "size"),
    (lambda: ts.Classic.toolbox(color="red"), "color", "colour"),
])
def test_functions_tell_the_keyword_that_is_nearest(call, name, near):
    with pytest.raises(TypeError, match=f"has no keyword '{name}'; did you mean '{near}'"):
        call()


@pytest.mark.parametrize("description, message", [
    ({1: 2}, "description: the key 1; expected text"),
    ({"nodes": {1, 2}}, "nodes: a set; expected a number, text, a list or a dict"),
    ({"nodes": [{"shape": b"x"}]}, r"nodes\[0\].shape: a bytes; expected"),
    ({"settings": {"width": float("nan")}}, "settings.width: nan; expected a finite number"),
    ({"settings": {"width": -1}}, "settings.width: -1; expected an integer"),
    ({"nodes": [{}, {"shape": {"spher": {}}}]}, r"nodes\[1\].shape: 'spher' is no field of Shape"),
    ({"nodes": [[{}]]}, "nodes: a list in a list; expected a value"),
    ({"settings": {"time": "NaN"}}, "settings.time: is not finite; expected"),
    ({"node": []}, "description: 'node' is no field of Scene; expected .*; did you mean 'nodes'"),
])
def test_what_no_description_has_is_told_by_its_path(description, message):
    with pytest.raises(ts.SceneError, match=f"^{message}") as told:
        ts.load_dict(description)
    assert (told.value.place, told.value.path) == ("", told.value.message.split(":")[0])


def test_descriptions_take_numbers_of_numpy():
    scene = ts.load_dict({"settings": {"width": np.int64(7)}, "nodes": [
        {"transform": {"steps": [{"matrix": {"rows": np.eye(3, 4).reshape(-1)}}]}}]})
    assert scene.width == 7 and len(scene.to_dict()["nodes"][0]["transform"]["steps"][0]["matrix"]["rows"]) == 12


def test_an_array_in_place_of_a_texture_has_the_line_of_what_it_stands_in():
    test = test_an_array_in_place_of_a_texture_has_the_line_of_what_it_stands_in
    line = test.__code__.co_firstlineno + 3
    wrong = ts.Classic(diffuse=np.full((2, 2, 3), np.nan))
    with pytest.raises(ts.SceneError) as told:
        ts.Scene(nodes=[ts.Sphere(material=wrong)]).render(workers=0, size=(4, 4))
    assert told.value.place == f"{__file__}:{line}"
    with pytest.raises(ValueError, match=r"texels: shape \(100000, 100000\); expected sides of at most 65536"):
        ts.ImageTexture(np.broadcast_to(np.uint8(0), (10**5, 10**5)))


def test_a_material_beside_several_is_refused():
    with pytest.raises(TypeError, match="material beside materials"):
        ts.Sphere(material="a", materials=["b"])


def test_what_never_changes_is_not_assigned_to():
    with pytest.raises(AttributeError, match="Image.linear cannot be assigned to"):
        IMAGE.linear = 5
    tracer = SCENE.tracer()
    names = tracer.instances
    tracer.instances.append("another")
    assert tracer.instances == names


def test_no_shared_verification_is_none_chosen_beside_a_farm():
    with ts.Threads(1) as farm:
        assert SCENE.render(size=(4, 4), farm=farm, verify=0).size == (4, 4)
        with pytest.raises(ts.UsageError, match="^workers: cannot be chosen with farm"):
            SCENE.render(size=(4, 4), farm=farm, workers=1)


def test_a_setting_is_taken_back():
    scene = ts.Scene(response=(1, 2, 3))
    scene.response = None
    assert scene.response is None and scene == ts.Scene()
    scene.spp = scene.width = 8
    scene.spp = scene.seed = None
    assert scene == ts.Scene(width=8) and scene.settings.sampling is None
    scene.width = None
    assert scene.settings is None


def test_what_cannot_be_written_is_no_wrong_argument(tmp_path):
    missing = tmp_path / "none"
    for write in (lambda: IMAGE.save(missing / "x.png"), lambda: SCENE.save(missing / "x.json")):
        with pytest.raises(ts.RenderError, match="cannot be written: there is no folder"):
            write()
    with pytest.raises(ts.RenderError, match="cannot be written"):
        IMAGE.save(missing / "x.png", tmp_path / "a.png")
    assert ts.read_image(tmp_path / "a.png").size == (2, 1)
    with pytest.raises(ts.UsageError):
        IMAGE.save(missing / "x.foo")


def test_names_are_spelt_with_either_dash():
    for name in ("bvh_splits", "bvh-splits"):
        assert ts.Scene(nodes=[ts.Sphere()], accel=name).render(accel=name, **SMALL)
        assert ts.Scene(nodes=[ts.Sphere()], accel=name).render(**SMALL) and SCENE.tracer(accel=name)
    for name in ("owen_sobol", "owen-sobol"):
        assert (SCENE.render(pattern=name, **SMALL)
                == ts.Scene(nodes=[ts.Sphere()], pattern=name).render(**SMALL))


@pytest.mark.parametrize("field, word, other", [
    ("accel", "bvh-splits", "bvh_splits"), ("tone_map", "reinhard-luminance", "reinhard_luminance"),
    ("pattern", "owen-sobol", "OWEN_SOBOL"), ("filter", "blackman-harris", "blackman_harris")])
def test_a_word_is_kept_in_one_spelling(field, word, other):
    scene, same = ts.Scene(**{field: word}), ts.Scene(**{field: other})
    assert getattr(same, field) == word and repr(same) == repr(scene)
    assert same == scene and same.digest == scene.digest
    assert getattr(ts.load_dict(scene.to_dict()), field) == word


def test_words_and_errors_of_values_are_spelt_as_those_of_keywords():
    paint = ts.Classic(name="front_only", sides="front_only")
    assert (paint.name, paint.sides) == ("front_only", "front-only")
    paint.sides = "back_material"
    assert paint.sides == "back-material"
    expected = "'blackmn-h_s'; expected one of box, tent, gaussian, mitchell, blackman-harris"
    for use in (lambda: SCENE.render(filter="blackmn-h_s", **SMALL), ts.Scene(filter="blackmn-h_s").check):
        with pytest.raises(ts.Error, match=expected):
            use()


def test_files(tmp_path):
    bad = tmp_path / "bad.tessera"
    with pytest.raises(ts.MissingFile) as told:
        ts.load(tmp_path / "none.tessera")
    assert told.value.filename == str(tmp_path / "none.tessera")
    for use, path in ((lambda: ts.load(bad, place="nofile.ply"), "nofile.ply"),
                      (ts.Scene(includes=[ts.Include("nope.tessera")]).check, os.path.abspath("nope.tessera")),
                      (lambda: ts.read_image("\udcff.png"), "\udcff.png")):
        bad.write_text("nodes { shape { sphere {} } }")
        with pytest.raises(ts.MissingFile, match="there is no such file|no such file") as told:
            use()
        for error in (told.value, pickle.loads(pickle.dumps(told.value))):
            assert (error.filename, error.errno, error.place) == (path, errno.ENOENT, path)
            assert str(error) == str(told.value)
    bad.write_text("nodes {\n  shpae {} }\n")
    with pytest.raises(ts.SceneError, match="did you mean 'shape'") as told:
        ts.load(bad)
    assert told.value.place.startswith(f"{bad}:2") and told.value.suggestion == "shape"
    with pytest.raises(ts.UsageError):
        ts.Scene().save(tmp_path / "scene.png")
    with pytest.raises(ts.SceneError, match="rde"):
        ts.Scene(materials=[ts.Classic(name="red")], nodes=[ts.Sphere(material="rde")]).check()


@pytest.mark.parametrize("wrong, path, found", [
    (lambda: ts.Sphere(material=ts.Physical(roughness=3)), "nodes[0].materials[0].roughness", "3"),
    (lambda: ts.Sphere(material=ts.Classic(name="m", shininess=-3)), "nodes[0].materials[0].shininess", "-3"),
    (lambda: ts.Sphere(material=ts.Classic(sides="back_material", back=ts.Classic(shininess=-2))),
     "nodes[0].materials[0].back.shininess", "-2"),
    (lambda: ts.Csg("union", [ts.Box(), ts.Sphere(material=ts.Unlit(opacity=2))]),
     "nodes[0].operands[1].materials[0].opacity", "2"),
    (lambda: ts.Sphere(material=ts.Unlit(color=ts.ImageTexture(width=7))), "nodes[0].materials[0].color.height",
     "0"),
    (lambda: ts.Object(nodes=[ts.Node(), ts.Sphere(radius=-1)]), "nodes[0].nodes[1].radius", "-1"),
])
def test_what_the_renderer_refuses_of_parts_without_names_has_its_line_in_the_script(wrong, path, found):
    scene = ts.Scene(nodes=[wrong()])
    for use in (lambda: scene.render(size=(4, 4), workers=0), scene.check):
        with pytest.raises(ts.SceneError, match=f" is {found}; expected") as caught:
            use()
        assert caught.value.path == path
        line = int(caught.value.place.rpartition(":")[2])
        assert caught.value.place == f"{__file__}:{line}" and "lambda: " in LINES[line - 1]


CUBE = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]


@pytest.mark.parametrize("make", [
    lambda: ts.Sphere(), lambda: ts.Scene(), lambda: ts.Lens(radius=1), lambda: ts.Mesh(CUBE[:3]),
    lambda: ts.Mesh.from_(type("Source", (), {"points": CUBE, "faces": [(0, 1, 2)]})),
    lambda: ts.ImageTexture(np.zeros((2, 2, 3))), lambda: ts.Instances("ball", [IDENTITY]),
    lambda: ts.Camera.look_at((0, 0, 5), (0, 0, 0)), lambda: ts.Camera.screen((0, 1, 0), (0, 0, 0), 1),
    lambda: ts.Camera.from_intrinsics(9, 9, 4, 4, 8, 8), lambda: ts.Plane.through(*CUBE[:3]),
    lambda: ts.Rectangle.from_corners(*CUBE[:4]), lambda: ts.Rectangle.from_corners(*CUBE[:3], (0, .5, 0)),
    lambda: ts.Box.from_corners(CUBE), lambda: ts.Box.from_corners(CUBE[:7] + [(0, 1, 2)]),
    lambda: ts.Box.from_corners([(x + y, y, z) for x, y, z in CUBE]), lambda: ts.Triangle(*CUBE[:3]),
    lambda: ts.Classic.toolbox(), lambda: ts.Node(children=[ts.Sphere()]).copy(), lambda: ts.Sphere() | ts.Box(),
    lambda: ts.Scene().add(ts.Sphere()), lambda: ts.Background.solid("red"), lambda: ts.translate(1, 2, 3)])
def test_whatever_makes_a_value_keeps_the_line_of_the_script(make):
    assert where(make()) == (__file__, make.__code__.co_firstlineno)


@pytest.mark.parametrize("light, path", [
    (ts.DirectionalLight(), "nodes[0].direction"),
    (ts.Node(light=ts.SpotLight()), "nodes[0].light.direction"),
])
def test_what_is_missing_is_told_as_not_set(light, path):
    with pytest.raises(ts.SceneError, match="direction is not set; expected a vector") as caught:
        ts.Scene(nodes=[light]).check()
    assert caught.value.path == path and caught.value.place.startswith(__file__ + ":")


@pytest.mark.parametrize("wrong, path, found", [
    (lambda s: s.add(ts.Sphere(), ts.Sphere(radius=-1)), "nodes[0].children[1].shape.radius", "-1"),
    (lambda s: s.add(ts.Torus(minor_radius=-2)), "nodes[0].shape.minor_radius", "-2"),
    (lambda s: (s.instances(ts.Box(), [IDENTITY] * 2), s.nodes.append(ts.Sphere(radius=-3))),
     "nodes[1].radius", "-3"),
    (lambda s: (s.instances(ts.Box(), [IDENTITY] * 2), s.nodes.append(ts.Node(name="x", shape=ts.Sphere(radius=-3)))),
     "nodes[1].shape.radius", "-3"),
    (lambda s: s.nodes.append(ts.Node(billboard_axis=(0, 1, 0), shape=ts.Sphere(
        radius=-4, transform=ts.scale(2)))), "nodes[0].shape.radius", "-4"),
    (lambda s: s.nodes.append(ts.Node(billboard_axis=(0, 1, 0), children=[ts.Box()], shape=ts.Sphere(
        radius=-4, transform=ts.scale(2)))), "nodes[0].shape.radius", "-4"),
    (lambda s: s.add(ts.Torus(minor_radius=-2), name="hall"), "nodes[0].shape.minor_radius", "-2"),
    (lambda s: s.add(ts.Torus(minor_radius=-2), name="a: b > 'c"), "nodes[0].shape.minor_radius", "-2"),
])
def test_what_only_the_renderer_sees_has_its_line_too(wrong, path, found):
    scene = ts.Scene()
    wrong(scene)
    for use in (lambda: scene.render(size=(4, 4), workers=0), scene.check, scene.tracer):
        with pytest.raises(ts.SceneError, match=f" is {found}; expected") as caught:
            use()
        assert caught.value.path == path
        assert caught.value.place.startswith(__file__ + ":")
        assert str(caught.value).startswith(f"{caught.value.place}: {path}: ")


@pytest.mark.parametrize("wrong, path, found", [
    ({"response": (1, 2)}, "output.response", "has 2 numbers"), ({"gamma": 0}, "output.gamma", "is 0"),
    ({"gamma": -1}, "output.gamma", "is -1"), ({"max_depth": 10**9}, "integrator.max_depth", "is 1000000000"),
    ({"target_error": -1}, "sampling.target_error", "is -1"), ({"width": 99999}, "width", "is 99999")])
def test_wrong_settings_have_their_line_too(wrong, path, found):
    scene = ts.Scene(nodes=[ts.Sphere()], **wrong)
    for use in (lambda: scene.render(workers=0), scene.check):
        with pytest.raises(ts.SceneError, match=f"{path} {found}; expected") as caught:
            use()
        assert caught.value.path == f"settings.{path}"
        assert caught.value.place == f"{__file__}:{LINES.index('    scene = ts.Scene(nodes=[ts.Sphere()], **wrong)') + 1}"


# ---- nodes that stand in others twice, so that each level doubles their number

@pytest.mark.parametrize("use", [
    lambda scene: scene.digest, ts.Scene.to_dict, ts.Scene.info, ts.Scene.check, ts.Scene.tracer,
    lambda scene: scene.render(workers=0), lambda scene: scene.nodes[0].intersect((0, 0, 0), (0, 0, 1))])
@pytest.mark.parametrize("again", [lambda x: ts.Node(children=[x, x]), lambda x: x | x])
def test_a_scene_of_too_many_nodes_is_refused_before_it_is_read(use, again):
    thing = ts.Sphere((0, 0, 0), 1)
    for _ in range(30):
        thing = again(thing)
    with pytest.raises(ts.SceneError, match="more than 16777216 nodes; expected fewer"):
        use(ts.Scene(width=8, height=8, nodes=[ts.Node(children=[thing])]))


def test_nodes_that_double_are_copied_turned_and_shown():
    node = ts.Node(shape=ts.Sphere((0, 0, 0), 1))
    for _ in range(40):
        node = ts.Node(children=[node, node])
    assert node.copy().instance_of.nodes[0].children[0].children
    node.flip()
    assert node.children[0] is node.children[1]
    assert repr(node) == "Node(children=<list of 2>)"
    few = ts.Node(children=[ts.Node(), ts.Node()])
    assert eval(repr(few), vars(ts)) == few


@pytest.mark.parametrize("call", [
    lambda huge: SCENE.render(max_depth=huge), lambda huge: SCENE.render(frame=huge),
    lambda huge: SCENE.render(workers=huge), lambda huge: ts.Farm(timeout=huge)])
def test_numbers_of_many_digits_are_told_shortly(call):
    for huge in (10**400, 10**5000):
        with pytest.raises(ts.UsageError, match="^[a-z_]*: a (whole )?number .{0,60}; expected") as told:
            call(huge)
        assert len(str(told.value)) < 120


@pytest.mark.parametrize("use, message", [
    (lambda path: ts.Image.from_array(np.ones((1, 1))).save(path / "a--b.xyz"), "a--b.xyz"),
    (lambda path: SCENE.render(workers=0, assets="a--b-c"), "assets: .*'a--b-c'"),
    (lambda path: SCENE.render(workers=0, camera="x:1: y"), "camera.*'x:1: y'"),
    (lambda path: SCENE.render(workers=0, pinhole=1), "pinhole: 1; expected True or False"),
    (lambda path: ts.Scene(nodes=[ts.Sphere(name="\udc80")]).digest, "expected text that is UTF-8"),
    (lambda path: SCENE.tracer(assets="nowhere"), "assets: there is no folder 'nowhere'"),
])
def test_what_users_named_is_told_as_they_wrote_it(use, message, tmp_path):
    with pytest.raises(ts.Error, match=message) as caught:
        use(tmp_path)
    assert caught.value.place == "" or "test_errors.py" in caught.value.place


def test_a_file_without_lines_is_the_place(tmp_path):
    bad = tmp_path / "bad.tesserab"
    bad.write_bytes(b"\xff" * 20)
    for path in (bad, tmp_path):
        with pytest.raises(ts.SceneError) as told:
            ts.load(path)
        assert told.value.place == str(path) and told.value.message.startswith(str(path))


def test_a_scene_that_was_loaded_tells_the_path():
    scene = ts.load_dict({"nodes": [{"shape": {"sphere": {"radius": -1}}}]})
    with pytest.raises(ts.SceneError, match="^nodes.0..shape.radius: sphere.radius is -1; expected") as told:
        scene.render(**SMALL)
    assert (told.value.place, told.value.path) == ("", "nodes[0].shape.radius")


def test_indices_beyond_64_bits_are_out_of_range():
    for wrong in (2 ** 63, -2 ** 70):
        with pytest.raises(ValueError, match="triangles: a number beyond 64 bits; expected 0 to 2"):
            ts.Mesh(np.zeros((3, 3)), [[0, 1, wrong]])


@pytest.mark.skipif(SANITIZER is not None, reason="a sanitizer needs more address space than the test allows")
@pytest.mark.parametrize("farm", ["Threads(1)", "LocalFarm(1)"])
def test_a_picture_without_memory_leaves_its_farm_usable(script, farm):
    assert script(f"""
import resource, sys
import tessera as ts
scene = ts.Scene(nodes=[ts.Sphere()], background=.5, width=16, height=16)
with ts.{farm} as farm:
    before = scene.render(farm=farm)
    used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + (1000 << 20), resource.RLIM_INFINITY))
    try:
        scene.render(size=(16000, 16000), spp=1, farm=farm)
    except MemoryError:
        print(scene.render(farm=farm) == before)
""") == "True"


def test_messages_call_options_as_python_has_them():
    behind = ts.Scene(nodes=[ts.Sphere(transform=ts.translate(0, 0, 100))], background=1)
    with pytest.warns(ts.SceneWarning, match="as with frame_all$"):
        behind.render(size=(4, 4), workers=0)
    with pytest.raises(ts.SceneError, match="or pattern owen-sobol"):
        ts.Scene(spp=3, pattern="centered_grid", nodes=[ts.Sphere()]).check()
