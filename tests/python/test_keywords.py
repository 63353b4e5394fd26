"""The keywords of render() are the options of the command line."""
import inspect
import pathlib
import re
import warnings

import numpy as np
import pytest
from tessera.compat import MeshIntersector

import tessera as ts
from tessera import rendering

# What the command line has for files and terminals, which Python has otherwise.
INSTEAD = {
    "output": "Image.save", "stats": "Image.stats", "quiet": "nothing is printed",
    "progressive": "Task.snapshot", "frames": "Scene.frames", "fps": "Frames(per_second=)", "connect": "farm", "key": "Farm(key=)",
    "server-key": "Farm(server_key=)", "trace": "the command line", "turntable": "Camera(keys=)", "tev": "on_tile",
    "format": "the ending", "help": "help()",
}
OUTPUT = {"exposure", "tone-map", "transfer", "gamma", "ocio-view", "ocio-display", "ocio-space",
          "ocio-input", "bits"}  # keywords of save(), and all but the last of to_srgb()
OF_PYTHON = {"scene", "unknown", "frame", "farm", "progress", "on_tile", "wait"}


def test_each_option_is_a_keyword(tessera):
    options = set(re.findall(r"^\s+(?:-\w,\s*)?--([a-z0-9-]+)", tessera("help", "render"), re.M))
    assert INSTEAD.keys() <= options and OUTPUT <= options
    wanted = {name.replace("-", "_") for name in options - INSTEAD.keys() - OUTPUT}
    assert set(inspect.signature(ts.render).parameters) - OF_PYTHON == wanted


@pytest.mark.parametrize("wrong", [
    {"frame": True}, {"frame": 2.0}, {"time": {0: 1}}, {"time": [[[0]]]}, {"seed": (1,)},
    {"size": {8: 8}}, {"size": {8, 9}}, {"size": [[8], [8]]}, {"crop": [(0, 0, 1, 1)]}, {"spp": [1]},
    {"size": memoryview(np.zeros((2, 2)))}, {"crop": memoryview(np.zeros((2, 2)))},
    {"aovs": memoryview(np.zeros((2, 2)))}, {"place": memoryview(np.zeros((2, 2)))}])
def test_keywords_of_another_type_are_refused(wrong):
    (name,) = wrong
    with pytest.raises(TypeError, match=f"^{name}: .*; expected "):
        ts.Scene(width=2, height=2, spp=1).render(workers=0, **wrong)


@pytest.mark.parametrize("call, name", [
    (lambda: ts.Farm(""), "endpoint"), (lambda: ts.Farm(key=""), "key"),
    (lambda: ts.Farm(server_key=""), "server_key"), (lambda: ts.Farm().job(""), "job"),
    (lambda: ts.Farm().submit(ts.Scene(), name=""), "name"),
    *((lambda name=name: ts.Scene().render(**{name: ""}), name)
      for name in ("camera", "assets", "place", "aovs", "size", "spp", "time", "pattern")),
])
def test_an_empty_text_is_not_what_is_not_given(call, name):
    with pytest.raises(ts.UsageError, match=f"^{name}: ''; expected"):
        call()


def test_an_empty_share_to_verify_is_refused():
    for workers in (0, 2):
        with pytest.raises(ts.UsageError, match="^verify: ''; expected"):
            ts.Scene(width=2, height=2, spp=1).render(workers=workers, verify="")


@pytest.mark.parametrize("call, message", [
    (lambda: ts.Farm(timeout="x"), "timeout: 'x'; expected a number"),
    (lambda: ts.Farm(timeout=None), "timeout: None; expected a number"),
    (lambda: ts.Farm().submit(ts.Scene(), priority="x"), "priority: 'x'; expected a whole number"),
    (lambda: ts.Farm().submit(ts.Scene(), weight=1.0), "weight: 1.0; expected a whole number"),
    (lambda: ts.Farm(endpoint=3), "endpoint: 3; expected text"),
    (lambda: ts.Scene().tracer(time={0: 1}), "time: {0: 1}; expected a number"),
    (lambda: ts.Scene().tracer(camera=3), "camera: 3; expected text"),
    (lambda: ts.render(ts.Scene(), **{"\udce9": 1}), "has no keyword '\udce9'"),
    (lambda: ts.Scene().frames(first=True), "first: True; expected a whole number"),
    (lambda: ts.Scene().frames(last=2.0), "last: 2.0; expected a whole number"),
    (lambda: ts.keys(memoryview(np.zeros((2, 2)))), r"pairs: a memoryview of shape \(2, 2\)"),
    (lambda: ts.Scene(nodes=memoryview(np.zeros((2, 2)))), r"nodes: a memoryview of shape \(2, 2\)"),
    (lambda: ts.Scene().add(memoryview(np.zeros((2, 2)))), r"nodes: a memoryview of shape \(2, 2\)"),
    (lambda: ts.Scene().add(object()), "an object; expected a Shape"),
    (lambda: ts.Mesh(3), "positions: an int; expected an array"),
    (lambda: ts.Mesh([object()]), "positions: an object; expected numbers")])
def test_arguments_of_another_type_are_told(call, message):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        with pytest.raises(TypeError, match=message):
            call()


def test_options_of_numbers_are_those_of_pictures():
    keywords = set(inspect.signature(ts.Image.save).parameters) - {"self", "paths", "unknown"}
    assert keywords == {name.replace("-", "_") for name in OUTPUT}
    assert set(inspect.signature(ts.Image.to_srgb).parameters) - {"self", "unknown"} == keywords - {"bits"}


def test_options_without_a_keyword_are_in_the_guide():
    guide = (pathlib.Path(__file__).parents[2] / "docs/python.md").read_text(encoding="utf-8")
    assert all(f"`--{name}`" in guide for name in ("tev", "quiet", "trace", "progressive"))


def test_every_keyword_is_documented():
    text = inspect.getdoc(ts.render)
    assert all(f":param {name}:" in text for name in OF_PYTHON - {"scene", "unknown"})


FRAME = {"size": (32, 18), "workers": 0, "threads": 1}
SCENE = ts.Scene(nodes=[ts.Sphere()], frames=(0, 3))


@pytest.mark.parametrize("given", [0, 1, 0., "no", ""])
def test_flags_are_true_or_false(given):
    with pytest.raises(ts.UsageError, match="^denoise: .*; expected True or False$"):
        SCENE.render(denoise=given, **FRAME)


def test_flags_of_numpy():
    dark = ts.Scene(nodes=[ts.Sphere()], background=1)
    plain = dark.render(denoise=np.bool_(False), spp=4, **FRAME)
    assert plain == dark.render(spp=4, **FRAME) != dark.render(denoise=np.bool_(True), spp=4, **FRAME)


@pytest.mark.parametrize("option", [{"spp": True}, {"spp": False}, {"size": True}, {"camera": False}])
def test_others_are_no_flags(option):
    with pytest.raises(ts.UsageError, match=f"^{next(iter(option))}: (True|False); expected"):
        SCENE.render(**{**FRAME, **option})


@pytest.mark.parametrize("option, message", [
    ({"size": (64., 36)}, r"size: \(64\.0, 36\); expected"),
    ({"crop": (0, 0, 9)}, r"crop: \(0, 0, 9\); expected"),
    ({"crop": (0, 0, 99, 9)}, r"crop: 0,0,99,9; expected a part of the frame, 0,0,32,18"),
    ({"integrator": "paht"}, "integrator: 'paht'; expected .* did you mean 'path'"),
])
def test_wrong_values_are_told_as_they_were_given(option, message):
    with pytest.raises(ts.UsageError, match=message):
        SCENE.render(**{**FRAME, **option})


def test_counts_may_be_numbers_of_numpy():
    with ts.LocalFarm(workers=np.int64(1), threads=np.uint8(1)) as farm:
        assert repr(farm) == "LocalFarm(workers=1, threads=1)"
    with pytest.raises(TypeError, match="workers: 1.5; expected a whole number"):
        ts.LocalFarm(workers=1.5)
    with pytest.raises(ts.UsageError, match="^threads: 0; expected a whole number"):
        SCENE.render(workers=0, threads=0)


IMAGE = ts.Image.from_array([[.5]])
BOX = MeshIntersector([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])


@pytest.mark.parametrize("call, keyword, near", [
    (SCENE.render, "sppp", "spp"), (SCENE.frames, "sppp", "spp"), (IMAGE.to_srgb, "gama", "gamma"),
    (lambda **keywords: IMAGE.save("x.png", **keywords), "ocio_vew", "ocio_view"),
    (lambda **keywords: ts.load("x.x3d", **keywords), "x3d_strct", "x3d_strict"),
    *((lambda name=name, **keywords: getattr(BOX, name)((0, 0, 1), (0, 0, -1), **keywords),
       "ray_origns", "ray_origins") for name in ("intersects_id", "intersects_location", "intersects_first",
                                                 "intersects_any")),
])
def test_unknown_keywords(call, keyword, near):
    with pytest.raises(TypeError, match=f"has no keyword '{keyword}'; did you mean '{near}'?"):
        call(**{keyword: 1})


class OwnScene(ts.Scene):
    __slots__ = ()


class Scene:
    """Of somebody else."""


def test_scenes_are_told_by_their_class():
    assert ts.render(OwnScene(nodes=[ts.Sphere()]), **FRAME) == ts.render(SCENE, **FRAME)
    with pytest.raises(TypeError, match="scene: .* expected a Scene or the path of a file"):
        ts.render(Scene(), **FRAME)


def test_frames_share_one_farm(monkeypatch):
    started = []
    real = rendering.LocalFarm
    monkeypatch.setattr(rendering, "LocalFarm", lambda *args: started.append(real(*args)) or started[-1])
    assert [number for number, _ in SCENE.frames(size=(32, 18), workers=1)] == [0, 1, 2, 3]
    assert len(started) == 1 and started[0].closed
    first = SCENE.frames(size=(32, 18), workers=1)
    next(first)
    first.close()
    assert len(started) == 2 and started[1].closed
    with pytest.raises(ts.UsageError, match="first: 5; expected at most 3, the last frame"):
        SCENE.frames(5)


def test_warnings_name_the_script(tmp_path, monkeypatch):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl nothing\nf 1 3 2\n")
    path = tmp_path / "a.obj"
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene = ts.load(path)
        ts.render(path, **FRAME)
        real = rendering._core.make_task
        monkeypatch.setattr(rendering._core, "make_task", lambda *given: (real(*given)[0], ["odd"]))
        list(scene.frames(0, 0, **FRAME))
    of_scene = [warning for warning in told if warning.category is ts.SceneWarning]
    assert len(of_scene) >= 3 and {warning.filename for warning in of_scene} == {__file__}


@pytest.mark.parametrize("fields, told", [
    ({"nodes": [ts.Sphere(material="glod")]},
     f"^{__file__}:\\d+: nodes.0.: material 'glod' is not defined; did you mean 'gold'.$"),
    ({"objects": [ts.Object("unused", [ts.Sphere(material="brass")])]},
     "^scene: material 'brass' is not defined$"),
])
def test_undefined_names_are_told_with_their_place(fields, told):
    with pytest.raises(ts.SceneError, match=told):
        ts.Scene(materials=[ts.Classic(name="gold")], **fields).check()


@pytest.mark.parametrize("material, path", [
    (ts.Physical(base_color=ts.ColorInput(texture="wod")), "base_color.texture"),
    (ts.Physical(roughness=ts.FloatInput(texture="wod")), "roughness.texture"),
    (ts.Classic(emission=ts.ColorInput(texture="wod"), name="lamp"), "emission.texture"),
    (ts.Classic(normal_map="wod"), "normal_map"),
    (ts.Classic(diffuse=ts.CheckerTexture(even=ts.ColorInput(texture="wod"))), "diffuse.even.texture"),
])
def test_undefined_textures_are_told_with_their_place(material, path):
    scene = ts.Scene(nodes=[ts.Sphere(material=material)], textures=[ts.NoiseTexture(name="wood")], background=1)
    for use in (scene.check, lambda: scene.render(size=(2, 2), workers=0)):
        with pytest.raises(ts.SceneError, match="is 'wod'; expected the name of a texture; did you mean 'wood'.$") as told:
            use()
        assert told.value.path == f"nodes[0].materials[0].{path}"
        assert told.value.place.startswith(f"{__file__}:")


def test_a_keyword_that_is_like_none_is_told_those_there_are():
    with pytest.raises(TypeError, match="^Box.. has no keyword 'size'; expected one of min, max, name, "):
        ts.Box(size=2)
    with pytest.raises(TypeError, match="^render.. has no keyword 'samples'; expected one of size, .* spp, "):
        SCENE.render(samples=4)


def test_frames_of_a_scene_without_any_are_asked_for():
    with pytest.raises(ts.UsageError, match="frames: the scene has none of its own; expected frames.first, last"):
        ts.Scene(nodes=[ts.Sphere()]).frames()


@pytest.mark.parametrize("name, told", [("frames", "; did you mean 'settings.frames'.$"), ("render", "$"),
                                        ("digest", "$")])
def test_what_cannot_be_assigned_to(name, told):
    with pytest.raises(AttributeError, match=f"^Scene.{name} cannot be assigned to{told}"):
        setattr(ts.Scene(), name, (0, 3))


def test_load_has_the_options_of_reading(tessera):
    of_files = set(re.findall(r"--(x3d-[a-z-]+|assets|environment|place|strict|two-sided|up)\b", tessera("help", "render")))
    keywords = set(inspect.signature(ts.load).parameters) - {"path", "frame", "unknown"}
    assert keywords == {name.replace("-", "_") for name in of_files}
    for name in keywords - {"place"}:
        with pytest.raises(ts.Error, match=f"^{name}: "):
            ts.load(__file__, **{name: "?"})


def test_depth_and_shadows_are_given_or_of_the_scene():
    def scene(**settings):
        mirror = ts.Classic(reflectivity=1, diffuse=0)
        return ts.Scene(nodes=[ts.Sphere((-1.1, 0, 0), 1, material=mirror), ts.Sphere((1.1, 0, 0), 1, material=mirror),
                               ts.Box((-4, -1.2, -4), (4, -1, 4)), ts.PointLight((0, 5, 5), intensity=20),
                               ts.PointLight((3, 5, 5), intensity=20, shadows=True)],
                        cameras=[ts.Camera(world_from_camera=ts.look_at((0, 1, 6), (0, 0, 0)))], background=.5, **settings)

    pictures = {scene().render(**FRAME).sha256}
    for settings in ({"max_depth": 0}, {"max_depth": 1}, {"shadows": "off"}, {"shadows": "by-light"}):
        given = scene().render(**settings, **FRAME)
        pictures.add(given.sha256)
        assert given == scene(**settings).render(**FRAME)
    assert len(pictures) == 5
    with pytest.raises(ts.UsageError, match="max_depth: -1; expected"):
        scene().render(max_depth=-1, **FRAME)
    with pytest.raises(ts.UsageError, match="shadows: 'of'; expected one of on, by-light, off"):
        scene().render(shadows="of", **FRAME)
