"""The types of the package hold for mypy and stubtest, and no public name is without words."""
import ast
import doctest
import functools
import inspect
import os
import pathlib
import re
import subprocess
import sys
import typing

import pytest

import tessera as ts
from tessera import _core, _messages, _types
from public_calls import UNIT
from test_docs import ROOT, blocks

PACKAGE = pathlib.Path(ts.__file__).parent
ENVIRONMENT = {"MYPYPATH": str(PACKAGE.parent), "PYTHONPATH": str(PACKAGE.parent), "PATH": "/usr/bin:/bin"}
PAGES = ("README.md", "docs/python.md")

RIGHT = '''
import numpy as np
import numpy.typing as npt
import tessera as ts

scene = ts.Scene(width=64, height=36, spp=4, integrator="path", filter="blackman-harris")
red = ts.Classic(diffuse="red", sides="front-only")
node: ts.Node = scene.add(ts.Sphere((0, 0, 0), 1.0, material=red), transform=ts.translate(1, 2, 3))
node.transform = ts.translate(1, 2, 3) @ ts.scale(2) @ ts.rotate("x", 90)
scene.add([ts.PointLight(np.zeros(3), intensity=2), ts.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)])], scene)
scene.camera = ts.Camera.look_at((0, 0, 5), ts.Vec(0, 0, 0), fov=40, lens=ts.Lens(radius=.1, focus=5))
scene.background = "red"
scene.background = ts.Background(glow=.5)
scene.background = ts.Background.gradient(sky="skyblue", ground=(1, 1, 1))
sky: ts.Background = scene.background
if sky.gradient is not None:
    sky.gradient.model = "absolute-y"
solid: ts.Csg = ts.Sphere() - ts.Box()
moved: ts.Sphere = ts.Sphere().shift((1, 0, 0)).flip()
digest: str = scene.digest
samples: int | None = scene.spp
image: ts.Image = scene.render(aovs=["depth", "id"], pattern="blue-noise", tile=8)
task: ts.Task = ts.render("file.tessera", wait=False)
light: npt.NDArray[np.float32] = image.linear
ids: npt.NDArray[np.uint32] = image.aov("id")
for name in image.aovs:
    image.aov(name)
image.save("a.png", tone_map="reinhard-luminance", exposure=.5)
hits = scene.tracer(accel="octree").intersect((0, 0, 0), np.ones((4, 3)), fields=("t", "uv"), cull="back")
t: npt.NDArray[np.float64] = hits.t
mesh = ts.Mesh(np.zeros((3, 3)), np.zeros((1, 3), int), colors=[(1, 0, 0)] * 3)
positions: npt.NDArray[np.float32] | None = mesh.positions
mesh.positions = np.ones((3, 3))
ts.ImageTexture(np.zeros((4, 4, 3), np.uint8), wrap="mirror")
frames: list[ts.Image] = [frame for _, frame in scene.frames(0, 3, workers=0)]
with ts.LocalFarm(workers=2) as farm:
    scene.render(farm=farm, progress=print, on_tile=lambda rect, picture: rect.x0 + picture.width)
'''

# Each has one mistake.
WRONG = '''
ts.Sphere(raduis=1)
ts.Sphere(radius="1")
ts.Classic(sides="both")
ts.Classic(diffuse="red", sides="FRONT_ONLY")
ts.Classic(diffuse=object())
ts.Classic.toolbox(diffus=.5)
ts.Scene(widht=64)
ts.Scene(pattern="owen_sobol")
ts.Scene(integrator="paht")
scene.width = "64"
scene.filter = "cone"
scene.add(1)
scene.add("ball")
scene.render(sppp=4)
scene.render(pattern="owen_sobol")
scene.render(aovs=["deptth"])
scene.render(size=(1, 2, 3))
scene.frames(0, 3, acel="bvh")
scene.tracer(accel="kd")
scene.instances(ts.Sphere(), "translate")
ts.render("a.x3d", x3d_color="displayed")
ts.render(scene, wait=False).save("a.png")
ts.load("a.x3d", x3d_shadows="none")
ts.Farm().submit(scene, spp="4")
ts.Farm().submit(scene, sp=4)
ts.Camera.look_at((0, 0, 0), (0, 0, 1), fow=40)
ts.Camera.look_at((0, 0, 0), (0, 0, 1), axis="height")
ts.Lens(radius=.1, shape="round")
ts.Background.gradient(skyy="red")
ts.Background.gradient(model="linear")
ts.Plane.through((0, 0, 0), (1, 0, 0), (0, 1, 0), materiel="gold")
ts.Box.from_corners([], nam="box")
ts.Rectangle.from_corners((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), offset=1)
ts.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0), colour="red")
ts.Mesh([(0, 0, 0)], normal=[])
ts.Mesh("cube.obj")
ts.Mesh.from_(object(), recentre=True)
ts.ImageTexture("a.png", wrap="tile")
ts.rotate("w", 90)
ts.Vec("x", 0, 0)
ts.Vec(1, 2, 3).x = 4
hits.t.nothing
scene.tracer().intersect((0, 0, 0), (0, 0, 1), cull="both")
scene.tracer().intersect((0, 0, 0), (0, 0, 1), fields=("t", "point"))
image.aov("light")
image.save("a.png", tone_map="reinhard_luminance")
image.to_srgb(expo=1)
'''.strip("\n")


def page_as_script(text):
    """All blocks of a page, without what is shown of errors and results."""
    parser = doctest.DocTestParser()
    for _, source in blocks(text):
        if source.startswith(">>>"):
            source = "".join(each.source for each in parser.get_examples(source) if not each.exc_msg)
        yield source


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    """What mypy finds, as lines by file: one run for the package and all scripts."""
    folder = tmp_path_factory.mktemp("mypy")
    (folder / "right.py").write_text(RIGHT)
    (folder / "wrong.py").write_text(RIGHT + WRONG)
    for page in PAGES:
        (folder / pathlib.Path(page).with_suffix(".py").name).write_text(
            "".join(page_as_script((ROOT / page).read_text(encoding="utf-8"))))
    scripts = [*folder.glob("*.py"), *(ROOT / "examples").glob("*.py")]
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--show-absolute-path", "--cache-dir",
                           folder / "cache", PACKAGE, *scripts],
                          capture_output=True, text=True, cwd=folder, env=ENVIRONMENT)
    assert done.returncode == 1 and "source files)" in done.stdout, done.stdout + done.stderr
    found = {}
    for file, line, message in re.findall(r"^(.*?):(\d+): error: (.*)$", done.stdout, re.M):
        found.setdefault(pathlib.Path(file).name, {})[int(line)] = message
    return found


def test_the_package_the_examples_and_the_documents_have_right_types(errors):
    assert {file: told for file, told in errors.items() if file != "wrong.py"} == {}


def test_each_wrong_line_is_found(errors):
    first = RIGHT.count("\n") + 1
    lines = WRONG.splitlines()
    missed = [line for number, line in enumerate(lines, first) if number not in errors["wrong.py"]]
    assert missed == [] and len(errors["wrong.py"]) == len(lines)


def test_stubs_are_those_of_what_runs(tmp_path):
    allowed = pathlib.Path(__file__).parent / "stubtest_allowlist.txt"
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "tessera", "--allowlist", allowed],
                          capture_output=True, text=True, cwd=tmp_path,
                          env={**ENVIRONMENT, "TESSERA_PROGRAM": os.environ["TESSERA_PROGRAM"]})
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_stub_has_the_parameters_that_pybind_tells():
    """Which stubtest cannot see: functions of pybind11 have their signature in the docstring alone."""
    stub = ast.parse((PACKAGE / "_core.pyi").read_text())
    owners = [(_core, stub), *((getattr(_core, each.name), each) for each in stub.body
                               if isinstance(each, ast.ClassDef) and hasattr(_core, each.name))]
    wrong, count = [], 0
    for owner, node in owners:
        for function in (each for each in node.body if isinstance(each, ast.FunctionDef)):
            told = getattr(owner, function.name).__doc__ or ""
            signature = re.match(rf"{function.name}\((.*)\) -> ", told)
            if signature:  # neither a property nor overloaded
                names = [each.split(":")[0] for each in re.split(r", (?=\w+:)", signature[1]) if each]
                stubs = [each.arg for each in function.args.posonlyargs + function.args.args]
                alike = [a == b or re.fullmatch(r"arg\d+|self", a) for a, b in zip(names, stubs)]
                count += 1
                if len(names) != len(stubs) or not all(alike):
                    wrong.append((function.name, signature[0], stubs))
    assert wrong == [] and count > 80


def words_of_an_error(call, **keyword):
    with pytest.raises(ts.UsageError) as refused:
        call(**keyword)
    return set(re.search(r"expected one of ([^;]*)", str(refused.value)).group(1).split(", "))


def test_words_are_those_of_the_renderer():
    scene, image = ts.Scene(nodes=[ts.Sphere()]), ts.Image.from_array([[.5]])
    for keyword, words in {"integrator": _types.Integrator, "accel": _types.Accelerator, "aovs": _types.Aov,
                           "pattern": _types.Pattern, "shadows": _types.Shadows, "x3d_color": _types.X3dColor,
                           "x3d_shadows": _types.X3dShadows, "x3d_texture": _types.X3dTexture,
                           "view": _types.View, "up": _types.Up}.items():
        assert words_of_an_error(scene.render, **{keyword: "?"}) == set(typing.get_args(words))
    for keyword, words in {"tone_map": _types.ToneMap, "transfer": _types.Transfer}.items():
        assert words_of_an_error(image.to_srgb, **{keyword: "?"}) == set(typing.get_args(words))
    ray = (0, 0, 5), (0, 0, -1)
    for keyword, words in {"cull": _types.Cull, "fields": _types.HitField}.items():
        assert words_of_an_error(functools.partial(scene.tracer().intersect, *ray),
                                 **{keyword: "?"}) == set(typing.get_args(words))


def test_frames_and_jobs_take_the_options_of_render():
    def options(function):
        return set(inspect.signature(function).parameters)
    of_files = {"strict", "x3d_color", "x3d_shadows", "x3d_texture", "x3d_weld", "x3d_strict", "x3d_two_sided"}
    assert options(ts.render) - options(ts.Scene.frames) == {
        "scene", "time", "frame", "wait", "resume", *of_files}
    assert options(ts.render) - options(ts.Farm.submit) == {
        "frame", "wait", "workers", "threads", "verify", "farm", "progress", "on_tile", "denoise", "resume"}


def public_members(made):
    for base in made.__mro__:
        if base.__module__.startswith("tessera"):
            yield from ((name, held) for name, held in vars(base).items() if not name.startswith("_"))


def test_each_public_name_has_words():
    described = property, functools.cached_property, classmethod, staticmethod
    silent = []
    for name in ts.__all__:
        thing = getattr(ts, name)
        if not inspect.getdoc(thing):
            silent.append(name)
        if inspect.isclass(thing):
            silent += [f"{name}.{member}" for member, held in public_members(thing)
                       if (callable(held) or isinstance(held, described)
                           or type(held).__module__.startswith("tessera"))
                       and not inspect.getdoc(getattr(thing, member))]
    assert silent == []


def test_the_words_of_a_class_tell_each_field():
    values = [made for made in map(vars(ts).get, ts.__all__) if inspect.isclass(made) and issubclass(made, ts.Value)]
    silent = [f"{made.__name__}.{field}" for made in values for field in made._FIELDS
              if not re.search(rf"^    {field}: \S", inspect.getdoc(made), re.M) and not field.startswith("inline_")]
    assert silent == [] and len(values) > 50


#: What tells a default, at the beginning of a clause, or behind the word that it is.
DEFAULT = re.compile(r'(^|; )(no default|default \S)|\(default\)|^"default": |'
                     r"(^|[;.] |absent or )(0|none|empty|left out): \S", re.I)


#: What tells how much light a colour means.
LIGHT = re.compile(r"\b(white|black|grey|light|colours)\b")


def missing_words(told, annotation):
    """What the words of a field lack."""
    is_color = re.search(r"\bColor(Input)?Like\b", annotation)
    is_number = is_color or re.search(r"\b(float|int|VectorLike|FloatInputLike)\b", annotation)
    if is_number and not (UNIT.search(told) or is_color and LIGHT.search(told)):
        yield "a unit or range"
    if not DEFAULT.search(told):
        yield "a default"


@pytest.mark.parametrize("told, annotation, missing", [
    ("the number of its default in light and colours", "Optional[float]", ["a unit or range", "a default"]),
    ("any weight, angle, height or index of an alpha", "Optional[int]", ["a unit or range", "a default"]),
    ("metres; > 0: a ring", "Optional[float]", ["a default"]),
    ("what it is", "Optional[ColorLike]", ["a unit or range", "a default"]),
    ("of white light", "Optional[ColorLike]", ["a default"]), ("absent, but for 0: none", "Optional[str]", ["a default"]),
    ("metres; default 1", "Optional[float]", []), ("0 to 1; no default", "Optional[float]", []),
    ("metres; 0: no bound", "Optional[float]", []), ("default black", "Optional[ColorLike]", []),
    ('"box" (default); "tent"', "Optional[SamplingFilter]", []), ("empty: flat", "Optional[ArrayLike]", [])])
def test_missing_words_of_a_field_are_found(told, annotation, missing):
    assert list(missing_words(told, annotation)) == missing


def test_the_words_of_a_field_tell_its_unit_or_range_and_its_default():
    untold, count = [], 0
    for made in map(vars(_messages).get, _messages.__all__):
        for field, annotation in made.__annotations__.items():
            if field.startswith(("_", "inline_")):
                continue
            told = " ".join(re.search(rf"^        {field}: (.*(?:\n {{12}}.*)*)", made.__doc__, re.M).group(1).split())
            untold += [(made.__name__, field, told, missing) for missing in missing_words(told, annotation)]
            count += 1
    assert untold == [] and count > 250


def test_the_words_are_those_of_python():
    for made in map(vars(_messages).get, _messages.__all__):
        assert not re.search(r"\b[A-Z]+_[A-Z_]+\b|\bPHONG\b|\binline_|: \w+: 1;", made.__doc__), made
    assert inspect.getdoc(ts.Frames).startswith("The frames of an animation")
    assert 'levels: how many, of detail, each half the last, rounded up; 0: 1\n' in ts.ImageTexture.__doc__
    assert re.search(r'filter: "trilinear" .default.', ts.ImageTexture.__doc__)
    assert "no default" in ts.SpotLight.__doc__ and "no default" in ts.DirectionalLight.__doc__
    assert 'auto (default)' in ts.Scene.integrator.__doc__ and '"on" (default)' in ts.Scene.shadows.__doc__
    assert all(f":param {name}:" in ts.Image.save.__doc__ for name in ("exposure", "tone_map", "gamma"))
    assert "docs/python.md" in ts.__doc__


def test_the_words_of_a_class_tell_each_value_of_its_fields():
    count = 0
    for made in map(vars(_messages).get, _messages.__all__):
        for field, annotation in made.__annotations__.items():
            name = annotation.removeprefix("Optional[").removesuffix("]")
            words = getattr(_messages, name, None)
            if typing.get_origin(words) is typing.Literal and name not in vars(_types):
                told = re.search(rf"^        {field}: (.*?)(?=^        \w|\Z)", made.__doc__, re.M | re.S).group(1)
                assert all(f'"{word}"' in told for word in typing.get_args(words)), (made, field)
                count += 1
    assert count > 20
