"""What is wrong is told: the class, the place in the script, the way to it, the nearest name."""
import pathlib

import pytest

import tessera as ts

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


def test_files(tmp_path):
    with pytest.raises(ts.MissingFile) as told:
        ts.load(tmp_path / "none.tessera")
    assert told.value.filename == str(tmp_path / "none.tessera")
    bad = tmp_path / "bad.tessera"
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
    assert repr(node).count("Sphere(") < 100_000 and "..." in repr(node)
    few = ts.Node(children=[ts.Node(), ts.Node()])
    assert eval(repr(few), vars(ts)) == few
