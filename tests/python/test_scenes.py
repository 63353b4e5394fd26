"""Scenes as values: samples there and back, names and objects, many instances."""
import copy
import json
import os
import pathlib
import pickle
import signal
import subprocess
import warnings

import numpy as np
import pytest

import tessera as ts

SAMPLES = pathlib.Path(__file__).parents[2] / "scenes/samples"
SCENES = sorted(path for path in SAMPLES.iterdir() if path.suffix not in (".png", ".mtl", ".py"))
PROGRAM = os.environ["TESSERA_PROGRAM"]


def load(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ts.SceneWarning)
        return ts.load(path)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.name)
def test_a_sample_there_and_back(path, tmp_path):
    scene = load(path)
    told = subprocess.run([PROGRAM, "info", "--json", path], capture_output=True, check=True)
    assert scene.digest == json.loads(told.stdout)["scene"]
    assert ts.load_dict(scene.to_dict()) == scene
    assert len(repr(scene)) <= 1000
    if "<" not in repr(scene):  # long fields are told, not shown
        assert eval(repr(scene), vars(ts)) == scene
    for ending in ("tessera", "tesserab", "json"):
        scene.save(tmp_path / f"again.{ending}")
        again = load(tmp_path / f"again.{ending}")
        assert again == scene and again.digest == scene.digest, ending
    scene.save(tmp_path / "ours.json")
    subprocess.run([PROGRAM, "convert", path, tmp_path / "theirs.json"], check=True, capture_output=True)
    assert (tmp_path / "ours.json").read_bytes() == (tmp_path / "theirs.json").read_bytes()


def test_what_was_loaded_is_copied_as_what_is_made_is():
    scene = ts.load_dict({"nodes": [{"shape": {"sphere": {"radius": 2}}, "name": "ball"}]})
    node, shape = scene.nodes[0], scene.nodes[0].shape
    assert copy.copy(scene) == copy.deepcopy(scene) == scene
    assert node.copy().name == "ball" and shape.copy((1, 0, 0)).radius == 2
    assert shape.flip().flip_normals
    assert ts.Scene().add(shape, material="red").shape.materials == ["red"]
    assert len(scene.instances(shape, [ts.scale(2)], material="red")) == 1


def test_an_object_stands_for_its_name():
    red = ts.Classic(diffuse="red", name="red")
    by_object = ts.Scene(nodes=[ts.Node(shape=ts.Sphere(material=red))])
    by_name = ts.Scene(materials=[red], nodes=[ts.Node(shape=ts.Sphere(material="red"))])
    assert by_object == by_name and by_object.digest == by_name.digest


def nested(levels):
    node = ts.Node()
    for _ in range(levels):
        node = ts.Node(children=[node])
    return node


def test_values_without_an_end_are_not_compared():
    assert nested(50) == nested(50) != nested(51)
    ring, other, inner = ts.Object(), ts.Object(), nested(0)
    for each in (ring, other):
        each.nodes = [ts.Node(instance_of=each)]
    inner.children = [inner]
    for a, b in ((nested(70), nested(70)), (nested(3000), nested(3000)), (inner, nested(1)), (ring, other)):
        with pytest.raises(ts.SceneError, match="inside itself, or nested too deep|refers to itself"):
            a == b
    assert inner == inner


def test_equal_materials_without_names_are_one_and_stable():
    def made():
        spheres = [ts.Sphere((i, 0, 0), material=ts.Classic(diffuse="red")) for i in range(3)]
        return ts.Scene(nodes=spheres).to_dict()
    assert len(made()["materials"]) == 1 and made() == made()


def test_a_name_of_two_unequal_materials_is_an_error():
    scene = ts.Scene(nodes=[ts.Sphere(material=ts.Classic(diffuse=c, name="m")) for c in ("red", "blue")])
    with pytest.raises(ts.SceneError, match="two materials named 'm'"):
        scene.digest


def test_the_transform_of_a_shape_acts_before_that_of_its_node():
    shape = ts.Sphere(transform=ts.scale(2))
    scene = ts.Scene()
    scene.add(shape, transform=ts.translate(1, 2, 3))
    whole = ts.Scene(nodes=[ts.Node(transform=ts.translate(1, 2, 3) @ ts.scale(2), shape=ts.Sphere())])
    assert scene == whole


def test_transforms_are_matrices():
    product = ts.translate(1, 2, 3) @ ts.rotate("z", 90) @ ts.scale(2)
    assert np.allclose(product.array, [[0, -2, 0, 1], [2, 0, 0, 2], [0, 0, 2, 3]], atol=1e-15)
    assert np.array_equal(ts.matrix(product.array).array, product.array)
    with pytest.raises(ValueError, match="0 0 0 1"):
        ts.matrix(np.ones((4, 4)))


def test_instances_are_nodes():
    matrices = np.tile(np.eye(4), (3, 1, 1))
    matrices[:, 0, 3] = range(3)
    many, few = ts.Scene(), ts.Scene()
    cube = ts.Object("cube", [ts.Box()])
    many.instances(cube, matrices)
    for i in range(3):
        few.add(cube, transform=ts.matrix(matrices[i]))
    assert many == few and many.info().counts == few.info().counts


def test_a_scene_has_instances_with_what_it_defines():
    part = ts.Scene(nodes=[ts.Sphere(materials=["red"])], materials=[ts.Unlit(color="red", name="red")])
    scene = ts.Scene()
    scene.instances(part, [ts.translate(x, 0, 0) for x in (0, 3)])
    scene.check()
    hits = scene.tracer().intersect([(0, 0, 5), (1.5, 0, 5), (3, 0, 5)], (0, 0, -1))
    assert hits.hit.tolist() == [True, False, True]


def test_transforms_of_instances_stay_checked():
    scene = ts.Scene()
    many = scene.instances(ts.Box(), [np.eye(4)] * 3, names=["a", "b", "c"])
    many.transforms = [ts.translate(1, 0, 0), ts.scale(2), ts.rotate("x", 90)]
    assert many.transforms.shape == (3, 3, 4) and many.transforms[0, 0, 3] == 1
    for wrong in (np.zeros((2, 2)), np.full((3, 3, 4), np.nan), "matrices"):
        with pytest.raises((ValueError, TypeError), match="transforms: "):
            many.transforms = wrong
    assert eval(repr(many), vars(ts)) == many and pickle.loads(pickle.dumps(many)) == many
    many.names.pop()
    with pytest.raises(ts.SceneError, match="2 names; expected 3, one an instance") as told:
        scene.digest
    assert told.value.path == "nodes[0]" and told.value.place.startswith(__file__)
    many.names = None
    for array, found in ((ts.Array.of([1.0], "d", [1]), r"shape \(1,\)"), (np.zeros((9, 3, 4)), "a numpy"),
                         (ts.Array.of([0.0] * 12, "f", [1, 3, 4]), "shape")):
        ts.Instances._transforms.__set__(many, array)
        with pytest.raises(ts.SceneError, match=found):
            scene.digest


def test_properties_are_equal_in_any_order():
    properties = {f"key {i}": str(i) for i in range(60)}
    for _ in range(20):
        assert ts.Metadata(properties=properties) == ts.Metadata(properties=dict(reversed(properties.items())))


@pytest.mark.parametrize("value", [
    ts.Scene(spp=np.int64(4)), ts.Sphere(radius=np.float64(.5)), ts.Sphere(center=np.array([1, 2, 3])),
    ts.Sphere(center=np.array([1, 2, 3], ">i2")), ts.Sphere(center=np.array([1, 2, 3], "u8")),
    ts.Sphere(flip_normals=np.bool_(True)), ts.Sphere(center=np.array([.5, 2, 3], ">f4"))])
def test_numbers_of_numpy_print_as_what_makes_them_again(value):
    assert eval(repr(value), vars(ts)) == value
    assert "Array" not in repr(ts.Sphere(radius=np.float64(.5))) and repr(ts.Sphere(center=np.array(["x"])))


def test_what_is_added_keeps_all_it_has():
    other, scene = ts.Scene(includes=[ts.Include("room.tessera")]), ts.Scene()
    scene.add(other)
    assert scene.includes == other.includes
    for thing in (ts.Node(), ts.Object(), other, scene.instances("cube", [np.eye(4)])):
        with pytest.raises(TypeError, match=f"material: for an? {type(thing).__name__}.*expected shapes"):
            scene.add(thing, material="red")
    with pytest.raises(TypeError, match="material: for an Object"):
        scene.instances(ts.Object("cube"), [np.eye(4)], material="red")
    with pytest.raises(TypeError, match="nothing; expected a Shape"):
        scene.add()
    red = scene.add(ts.Sphere(), ts.PointLight(), material="red")
    assert red.children[0].shape.materials == ["red"] and scene.add([]).children == []


@pytest.mark.parametrize("make", [ts.translate, ts.scale])
def test_two_numbers_are_no_transform(make):
    for numbers in (dict(x=1, y=2), dict(x=1, z=2)):
        with pytest.raises(TypeError, match=r"\(\) of 2 numbers; expected 1 or 3"):
            make(**numbers)


def test_shapes_combine():
    a, b = ts.Sphere(), ts.Box()
    assert [(a | b).operation, (a & b).operation, (a - b).operation] == [
        "union", "intersection", "difference"]
    assert ts.Scene(nodes=[a - b]).to_dict()["nodes"][0]["shape"]["csg"]["operands"][1]["shape"] == {"box": {}}


def test_colours():
    assert ts.color("red") == ts.color("#f00") == ts.color((1, 0, 0)) == (1, 0, 0)
    assert ts.color("#808080").r == pytest.approx(.21586, abs=1e-5)
    assert ts.hsl(120, 1, .5) == (0, 1, 0)
    assert ts.color(.25) == ts.color(np.float32(.25)) == (.25, .25, .25)
    with pytest.raises(ts.SceneError, match="did you mean 'crimson'") as told:
        ts.color("crimsn")
    assert told.value.suggestion == "crimson"


@pytest.mark.parametrize("grey", [.5, np.float32(.5), np.float64(.5), (.5, .5, .5), ts.color(.5)])
def test_a_number_is_a_grey_colour(grey):
    def made(value):
        scene = ts.Scene(ambient=value, background=value)
        scene.add(ts.Sphere(), material=ts.Classic(diffuse=value))
        scene.add(ts.PointLight(color=value))
        return scene
    assert made(grey).digest == made((.5, .5, .5)).digest
    assert made(1) == made("white") and made(0) != made(1)


def test_settings_are_attributes():
    scene = ts.Scene(width=12, spp=16, ambient=(1, 1, 1), response=(-1.2, 2.2, 0))
    assert (scene.width, scene.spp, scene.settings.sampling.samples_per_pixel) == (12, 16, 16)
    scene.max_depth = 3
    assert scene.settings.integrator.max_depth == 3 and scene.gamma is None
    assert scene.to_dict()["settings"]["output"]["response"] == [-1.2, 2.2, 0]


def test_backgrounds_and_cameras():
    sky = ts.Background.gradient("skyblue", "white")
    assert sky.gradient.sky == "skyblue" and sky.solid is None
    camera = ts.Camera.look_at((0, 0, 5), (0, 0, 0), fov=30, lens=ts.Lens(radius=.1, focus=5))
    assert camera.perspective.field_of_view == 30 and camera.lens.radius_y == .1
    plane = ts.Plane.through((0, 1, 0), (1, 1, 0), (0, 1, -1))
    assert plane.normal == (0, 1, 0) and plane.offset == 1


def test_a_texture_from_a_file_is_that_of_the_importer(tmp_path, tessera):
    pixels = (np.arange(12 * 10 * 3) * 7 % 256).astype(np.uint8).reshape(10, 12, 3)
    ts.Image.from_array(pixels, linear=False).save(tmp_path / "x.png")
    (tmp_path / "x.tessera").write_text(
        '# proto-file: proto/tessera/v1/scene.proto\n# proto-message: tessera.v1.Scene\n'
        'textures { name: "t" image { file: "x.png" } }\n'
        'materials { name: "m" unlit { color { texture: "t" } } }\n'
        'nodes { shape { materials: "m" rectangle { corner { x: -1 y: -1 } edge_u { x: 2 } '
        'edge_v { y: 2 } } } }\n')
    loaded = ts.load(tmp_path / "x.tessera")
    ours = ts.ImageTexture(tmp_path / "x.png")
    theirs = loaded.textures[0]
    assert (ours.width, ours.height, ours.channels, ours.levels) == (12, 10, 3, theirs.levels)
    assert bytes(ours.texels) == bytes(theirs.texels) and ours.levels > 1
    from_array = ts.ImageTexture(pixels)
    assert bytes(from_array.texels) == bytes(ours.texels)
    plain = ts.ImageTexture(pixels, filter="nearest")
    assert plain.levels is None and bytes(plain.texels) == pixels.tobytes()

    scene = ts.Scene()
    scene.add(ts.Rectangle((-1, -1, 0), (2, 0, 0), (0, 2, 0)), material=ts.Unlit(color=ours))
    assert scene.render(size=(20, 20), workers=0) == loaded.render(size=(20, 20), workers=0)


def test_what_a_scene_includes_is_read_from_the_current_folder_or_the_assets(tmp_path, monkeypatch, tessera):
    ball = ts.Scene(nodes=[ts.Sphere(material=ts.Unlit(color="red"))])
    (tmp_path / "parts").mkdir()
    ball.save(tmp_path / "parts/ball.tessera")
    scene = ts.Scene(camera=ts.Camera.look_at((0, 0, 5), (0, 0, 0)),
                     includes=[ts.Include(file="ball.tessera", transform=ts.translate(1, 0, 0))])
    scene.save(tmp_path / "parts/whole.tessera")
    expected = ts.render(tmp_path / "parts/whole.tessera", workers=0, size=(20, 20))
    assert len(np.unique(expected.linear)) == 2

    monkeypatch.chdir(tmp_path / "parts")
    assert scene.render(workers=0, size=(20, 20)) == expected
    assert scene.tracer().instances == ["ball"] and scene.check() is None and len(scene.includes) == 1

    monkeypatch.chdir(tmp_path)
    assert scene.render(workers=0, size=(20, 20), assets="parts") == expected
    assert scene.tracer(assets="parts").instances == ["ball"] and scene.check(assets="parts") is None
    assert scene.info(assets="parts").bounds == pytest.approx(np.array([[0, -1, -1], [2, 1, 1]]))
    assert [picture for _, picture in scene.frames(0, 0, workers=0, size=(20, 20), assets="parts")] == [expected]
    for use in (lambda: scene.render(workers=0), scene.tracer, scene.check):
        with pytest.raises(ts.SceneError, match="ball.tessera"):
            use()
    scene.includes[0].file = "../ball.tessera"
    with pytest.raises(ts.SceneError, match="includes '../ball.tessera', which is not inside"):
        scene.check()


def test_a_made_scene_takes_in_what_is_placed(tmp_path):
    ts.Scene(nodes=[ts.Sphere(material=ts.Unlit(color="red"))]).save(tmp_path / "ball.tessera")
    camera = ts.Camera.look_at((0, 0, 5), (0, 0, 0))
    placed = ts.Scene(camera=camera).render(workers=0, size=(20, 20), place=f"{tmp_path}/ball.tessera:at=1,0,0")
    whole = ts.Scene(camera=camera)
    whole.add(ts.Sphere(material=ts.Unlit(color="red")), transform=ts.translate(1, 0, 0))
    assert placed == whole.render(workers=0, size=(20, 20))


def test_a_texture_that_is_not_there_is_told(tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere.png: there is no such file"):
        ts.ImageTexture("nowhere.png")
    (tmp_path / "x.png").write_bytes(b"nothing")
    with pytest.raises(ts.SceneError, match="x.png"):
        ts.ImageTexture(tmp_path / "x.png")
    for wrong in (np.zeros((2, 2, 5), np.uint8), np.zeros((0, 2), np.uint8), np.zeros(3, np.uint8)):
        with pytest.raises(ValueError, match="texels: shape"):
            ts.ImageTexture(wrong)
    with pytest.raises(TypeError, match="texels: .*expected uint8, uint16 or floats"):
        ts.ImageTexture(np.zeros((2, 2), np.int64))


def test_a_colour_is_a_background():
    scene = ts.Scene(background="red")
    scene.background = "navy"
    assert scene.background == ts.Background.solid("navy")
    assert scene == ts.Scene(background=ts.Background.solid("navy")) == pickle.loads(pickle.dumps(scene))
    scene.background = None
    assert scene == ts.Scene()
    scene.background = ts.Sphere()
    with pytest.raises(ts.SceneError, match="background: .*; expected a Background"):
        scene.digest


def test_find_gives_the_first_part_of_a_name_and_class():
    ivory, light = ts.Classic(name="ivory"), ts.PointLight(name="light")
    inner = ts.Sphere(name="ball", material=ts.Unlit(name="glow"))
    scene = ts.Scene(materials=[ivory], objects=[ts.Object("thing", [ts.Node("leaf", shape=inner)])])
    node = scene.add(light, ts.Box(material="ivory"), name="ball")
    assert scene.find("ivory") is ivory and scene.find("light", ts.Light) is light
    assert scene.find("ball", ts.Node) is node and scene.find("ball") is inner
    assert scene.find("glow", ts.Material) is inner.material and scene.find("leaf").shape is inner
    scene.find("ivory", ts.Classic).diffuse = "red"
    assert ivory.diffuse == "red"
    for wrong in (lambda: scene.find("ivoy", ts.Material), lambda: scene.find("ivoy")):
        with pytest.raises(ts.UsageError, match="name: 'ivoy'; expected that of a .*; did you mean 'ivory'"):
            wrong()
    with pytest.raises(ts.UsageError, match="expected that of a Unlit"):
        scene.find("ivory", ts.Unlit)


def test_one_material_for_a_mesh_that_has_one_a_triangle_is_refused():
    red, blue = ts.Classic(diffuse="red"), ts.Classic(diffuse="blue")
    arrays = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 1)]
    mesh = ts.Mesh(*arrays, materials=[red, blue], face_materials=[0, 1])
    scene = ts.Scene()
    for call in (lambda: scene.add(mesh, material=red),
                 lambda: scene.instances(mesh, np.eye(4)[None], material=red),
                 lambda: ts.Mesh(*arrays, material=red, materials=[red, blue], face_materials=[0, 1]),
                 lambda: setattr(mesh, "material", red)):
        with pytest.raises(ValueError, match="^material: for a Mesh with face_materials"):
            call()
    assert mesh.materials == [red, blue] and mesh.material is red and not scene.nodes
    mesh.face_materials = None
    mesh.material = blue
    assert mesh.materials == [blue]


def test_messages_name_values_with_their_article_and_whole_characters():
    for scene, message in ((ts.Scene(nodes=[ts.Node(instance_of=3)]), "3; expected an Object or"),
                           (ts.Scene(objects=[3]), "3; expected an Object"),
                           (ts.Scene(nodes=[ts.Sphere(radius=object())]), "radius: an object; expected"),
                           (ts.Scene(nodes=[ts.Sphere(radius="\u00e9" * 58)]), "'\u00e9{29}\\.\\.\\.; exp")):
        with pytest.raises(ts.SceneError, match=message):
            scene.digest


@pytest.mark.parametrize("use", [
    lambda scene: scene.check(), lambda scene: scene.info(),
    lambda scene: scene.tracer(), lambda scene: pickle.loads(pickle.dumps(scene.tracer()))])
def test_what_is_left_out_of_a_scene_is_logged_at_once(caplog, use):
    use(ts.Scene(nodes=[ts.Sphere(), ts.Sphere(transform=ts.scale(0))], background=1))
    assert "1 node scaled to nothing or out of range: left out" in caplog.text


def test_what_a_picture_leaves_out_is_warned_of():
    flat = ts.Scene(nodes=[ts.Sphere(), ts.Sphere(transform=ts.scale(0))], background=1)
    with pytest.warns(ts.SceneWarning, match="node: its transform makes it flat"):
        flat.render(size=(4, 4), workers=0)
    mesh = ts.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 1]])
    with pytest.warns(ts.SceneWarning, match="^1 triangle without an area: left out$"):
        ts.Scene(nodes=[mesh], background=1).render(size=(4, 4), workers=0)


def test_find_looks_at_each_part_once():
    leaf = ts.Sphere(name="leaf")
    node = ts.Node(shape=leaf)
    for _ in range(60):
        node = ts.Node(children=[node, node])
    scene = ts.Scene(nodes=[node])
    assert scene.find("leaf") is leaf


def test_info_has_the_bounds_that_the_command_line_tells(tessera, tmp_path):
    scene = ts.Scene(nodes=[ts.Sphere(center=(1, 2, 3), radius=.5), ts.Box(min=(-1, 0, 0), max=(0, 1, 1))])
    scene.save(tmp_path / "two.tessera")
    told = json.loads(tessera("info", tmp_path / "two.tessera", "--json"))["bounds"]
    bounds = scene.info().bounds
    assert bounds == (tuple(told["min"]), tuple(told["max"]))
    assert np.allclose(bounds, [(-1, 0, 0), (1.5, 2.5, 3.5)]) and "(-1, 0, 0) to (1.5" in scene._repr_html_()
    assert ts.Scene().info().bounds is None
    wrong = ts.Scene(nodes=[ts.Sphere(radius=1, material="gold")])
    assert wrong.info().undefined and ts.Scene(nodes=[ts.Sphere(radius=-1)]).info().bounds is None


def test_numbers_that_make_or_take_light_are_told_by_both_front_ends(tessera, tmp_path):
    scene = ts.Scene(width=8, height=8, spp=1)
    scene.add(ts.Sphere(material=ts.Classic(name="chalk", diffuse=(.5, 1.5, 0))))
    scene.add(ts.Box(min=(2, 0, 0), max=(3, 1, 1), material=ts.Physical(name="snow", base_color=2)))
    scene.add(ts.PointLight(position=(0, 5, 5), name="lamp"),
              ts.PointLight(position=(0, 5, 5), name="hole", intensity=-.5))
    with pytest.warns(ts.SceneWarning) as caught:
        scene.render(workers=0)
    told = [str(warning.message) for warning in caught]
    assert told == [
        "material 'chalk': diffuse is (0.5, 1.5, 0); expected at most 1, as more light would come back than "
        "came; 1 more like it",
        "light 'hole': intensity is -0.5; expected 0 or more, as it takes light away"]
    scene.save(tmp_path / "odd.tessera")
    assert json.loads(tessera("info", tmp_path / "odd.tessera", "--json"))["warnings"] == told
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ts.Scene(width=8, height=8, background=5, nodes=[
            ts.Sphere(material=ts.Classic(diffuse=1, emission=40))]).render(workers=0)


def test_a_headlight_that_takes_light_is_told_with_its_camera(tessera, tmp_path):
    cameras = [ts.Camera(name="front", headlight=ts.DirectionalLight((0, 0, -1), intensity=-1))]
    ts.Scene(nodes=[ts.Sphere()], cameras=cameras).save(tmp_path / "odd.tessera")
    assert json.loads(tessera("info", tmp_path / "odd.tessera", "--json"))["warnings"] == [
        "headlight of camera 'front': intensity is -1; expected 0 or more, as it takes light away"]


def test_nodes_that_their_transform_makes_flat_are_told(tessera, tmp_path):
    node = 'nodes { name: "%s" %s shape { sphere { radius: 1 } } %s }\n'
    flat = "transform { steps { scale { x: 1 y: %s z: 1 } } }"
    (tmp_path / "flat.tessera").write_text(
        "background { solid { r: 1 } }\n" + node % ("leaf", flat % 0, "") + node % ("ball", flat % -.1, "")
        + node % ("away", flat % 0, "hidden: true") + node % ("paper", flat % 0, ""))
    assert json.loads(tessera("info", tmp_path / "flat.tessera", "--json"))["warnings"] == [
        "node 'leaf': its transform makes it flat; expected one that keeps three dimensions, so that something "
        "is seen; 1 more like it"]


def test_what_is_given_to_a_scene_is_not_changed():
    settings = ts.Settings(width=10, output=ts.Output(gamma=2))
    scene = ts.Scene(settings=settings, width=99, gamma=1.5, frames=(1, 2))
    assert (scene.width, scene.gamma, scene.settings.frames.last) == (99, 1.5, 2)
    assert settings == ts.Settings(width=10, output=ts.Output(gamma=2))
    assert ts.Scene(settings=settings).settings is settings
    other = ts.Scene(materials=[ts.Classic(name="red")])
    empty = ts.Scene()
    with pytest.raises(TypeError, match="a Camera; expected a Shape"):
        empty.add(other, ts.Camera())
    assert empty == ts.Scene()


@pytest.mark.parametrize("wrong", [5, (1, 2, 3)])
def test_frames_of_a_scene_are_two_numbers(wrong):
    with pytest.raises(TypeError, match="frames: .*; expected Frames or \\(first, last\\)"):
        ts.Scene(frames=wrong)


def test_a_camera_is_given_once():
    with pytest.raises(TypeError, match="camera beside cameras; expected one of them"):
        ts.Scene(cameras=[ts.Camera()], camera=ts.Camera())


def test_find_sees_textures_and_headlights():
    checks, light = ts.CheckerTexture(name="checks"), ts.PointLight(name="near")
    scene = ts.Scene(camera=ts.Camera(headlight=light), nodes=[ts.Sphere(material=ts.Classic(diffuse=checks))])
    assert scene.find("checks") is checks and scene.find("near") is light


def test_a_thing_that_only_makes_arrays_is_a_texture():
    class Made:
        def __array__(self, dtype=None):
            return np.zeros((2, 2, 3), np.uint8)

    materials = [ts.Classic(diffuse=picture) for picture in (Made(), np.zeros((2, 2, 3), np.uint8))]
    first, second = (ts.Scene(nodes=[ts.Sphere(material=material)]) for material in materials)
    assert first == second


def test_a_node_is_hit_whose_material_has_the_name_that_another_uses():
    node = ts.Node(children=[ts.Sphere(material=ts.Classic(name="m", diffuse="red")),
                             ts.Sphere((5, 0, 0), material="m")])
    assert node.intersect((0, 0, -3), (0, 0, 1)).t == 2


def test_a_list_of_nodes_that_shrinks_while_it_is_read():
    scene, many = ts.Scene(), [ts.Sphere() for _ in range(200_000)]
    before = signal.signal(signal.SIGALRM, lambda *_: scene.nodes.clear())
    try:
        for i in range(20):
            scene.nodes.extend(many)
            signal.setitimer(signal.ITIMER_REAL, .0005 + .0002 * i)
            assert isinstance(scene.digest, str)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_settings_can_be_deleted():
    scene = ts.Scene(width=10, gamma=2)
    del scene.width, scene.gamma
    assert scene == ts.Scene()


def test_long_texts_are_cut_field_by_field():
    few = ts.Scene(width=64, nodes=[ts.Node(shape=ts.Sphere()) for _ in range(30)])
    assert eval(repr(few), vars(ts)) == few and len(repr(few)) > 500
    many = ts.Scene(width=64, nodes=[ts.Node(shape=ts.Sphere()) for _ in range(1000)])
    assert repr(many) == "Scene(settings=Settings(width=64), nodes=<list of 1000>)"
    mesh = ts.Mesh(np.zeros((300, 3)), [(0, 1, 2)], name="flat")
    assert repr(mesh) == ("Mesh(positions=<ndarray (300, 3)>, triangles=Array.of([0, 1, 2], 'I', (1, 3)), "
                          "name='flat')")
    assert repr(ts.Classic(name="a" * 2000)) == "Classic(name=<str of 2000>)"
    many.nodes.append(ts.Node(children=many.nodes))
    assert repr(many).endswith("nodes=<list of 1001>)")
