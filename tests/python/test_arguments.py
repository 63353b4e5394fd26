"""Arguments that cannot be meant are told by keyword, by what was found and what was expected."""
import copy
import pickle

import numpy as np
import pytest

import tessera as ts

SCENE = ts.Scene(nodes=[ts.Sphere()], background=1)
TRACER = SCENE.tracer()
TRIANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
RAY = (0, 0, 5), (0, 0, -1)


def render(**keywords):
    return SCENE.render(**{"size": (4, 4), "workers": 0, **keywords})


@pytest.mark.parametrize("call, message", [
    (lambda: render(wait=False).result("x"), "timeout: 'x'; expected a number"),
    (lambda: render(wait="x"), "wait: 'x'; expected True or False"),
    (lambda: SCENE.tracer(geometry_only="x"), "geometry_only: 'x'; expected True or False"),
    (lambda: SCENE.tracer(accel=None), "accel: None; expected text"),
    (lambda: ts.Mesh(TRIANGLE, recenter="x"), "recenter: 'x'; expected True or False"),
    (lambda: ts.LocalFarm(2, verify=[1]), "verify: [1]; expected a number"),
    (lambda: TRACER.intersect(*RAY, fields=3), "fields: 3; expected some of t, instance, primitive, uv"),
    (lambda: TRACER.intersect(*RAY, fields=(3,)), "fields: 3; expected one of t, instance, primitive, uv"),
    (lambda: TRACER.intersect(*RAY, cull=3), "cull: 3; expected one of none, back, front"),
    (lambda: TRACER.intersect(*RAY, threads="2"), "threads: '2'; expected a whole number"),
    (lambda: render(place=b"x"), "place: b'x'; expected text or several of them"),
    (lambda: render(place=["a", 3]), "place: 3; expected text or several of them"),
    (lambda: ts.load(__file__, place=b"x"), "place: b'x'; expected text or several of them"),
    (lambda: render(assets=True), "assets: True; expected the path of a folder"),
])
def test_wrong_types(call, message):
    with pytest.raises(TypeError) as told:
        call()
    assert str(told.value) == message


FRAMES = "expected a whole number from -2147483648 to 2147483647"
NAME = "''; expected text that is not empty"


@pytest.mark.parametrize("call, message", [
    (lambda: render(wait=False).result(float("nan")), "timeout: nan; expected seconds"),
    (lambda: render(frame=2**70), f"frame: {2**70}; {FRAMES}"),
    (lambda: SCENE.frames(2**31), f"first: {2**31}; {FRAMES}"),
    (lambda: ts.load(__file__, frame=-2**40), f"frame: {-2**40}; {FRAMES}"),
    (lambda: render(camera=""), "camera: ''; expected CAMERA"),
    (lambda: SCENE.tracer(camera=""), f"camera: {NAME}"),
    (lambda: TRACER.camera_rays((4, 4), camera=""), f"camera: {NAME}"),
    (lambda: render(resume=""), f"resume: {NAME}"),
    (lambda: ts.load(""), f"path: {NAME}"),
    (lambda: ts.render(""), f"scene: {NAME}"),
    (lambda: render(workers=2, verify="\ud800"), "verify: '\\ud800'; expected text that is UTF-8"),
    (lambda: ts.LocalFarm(2, verify="\ud800"), "verify: '\\ud800'; expected text that is UTF-8"),
    (lambda: TRACER.intersect(*RAY, fields=()), "fields: (); expected some of t, instance, primitive, uv"),
])
def test_wrong_values(call, message):
    with pytest.raises(ts.UsageError) as told:
        call()
    assert str(told.value) == message


def test_truths_and_numbers_of_numpy_are_taken():
    assert render(wait=np.bool_(True), frame=np.int64(1)) == render()
    with render(wait=np.bool_(False)) as task:
        assert task.result(np.float32(60)) == render()
    assert SCENE.tracer(geometry_only=np.bool_(True)).instances == TRACER.instances
    assert ts.Mesh(TRIANGLE, recenter=np.bool_(True)).transform is not None


def test_an_array_without_axes_is_one_number():
    assert ts.scale(np.array(2.)) == ts.scale(2) == ts.scale(np.array([2., 2, 2]))


@pytest.mark.parametrize("make, hint", [
    (lambda: ts.Camera(eye=(3, 2, 5)), "Camera.look_at(eye=...)"),
    (lambda: ts.Camera(centre=(0, 0, 0)), "Camera.screen(centre=...)"),
    (lambda: ts.Classic(highlight=1), "Classic.toolbox(highlight=...)"),
])
def test_keywords_of_class_methods_are_told(make, hint):
    with pytest.raises(TypeError) as told:
        make()
    assert str(told.value).endswith(f"; did you mean {hint}?")


class Ball(ts.Sphere):
    """One that forgets to have its fields set."""
    def __init__(self, radius):
        self.radius = radius


@pytest.mark.parametrize("use", [repr, copy.copy, pickle.dumps, lambda ball: ball.center])
def test_a_class_that_does_not_call_its_base_is_told(use):
    with pytest.raises(AttributeError, match=r"^Ball\.\w+ is not set; expected Ball\.__init__ to call super"):
        use(Ball(2))


class Marked(ts.Sphere):
    """One with an attribute of its own."""
    def __init__(self, marks):
        super().__init__(radius=2)
        self.marks = marks


@pytest.mark.parametrize("again, is_own", [(copy.copy, False), (copy.deepcopy, True),
                                           (lambda ball: pickle.loads(pickle.dumps(ball)), True)])
def test_attributes_of_a_derived_class_are_copied(again, is_own):
    ball = Marked(["a"])
    made = again(ball)
    assert type(made) is Marked and made == ball and made.marks == ["a"]
    assert (made.marks is not ball.marks) == is_own


@pytest.mark.parametrize("use", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_task_is_neither_copied_nor_pickled(use):
    with render(wait=False) as task, pytest.raises(TypeError, match="^Task cannot be copied or pickled"):
        use(task)


ENDLESS = []
ENDLESS.append(ENDLESS)


@pytest.mark.parametrize("call, error, message", [
    (lambda: ts.Vec(1, 2, 3)["x"], TypeError, "^'x'; expected an index from -3 to 2, or a slice"),
    (lambda: ts.Vec(1, 2, 3)[2**70], IndexError, "expected an index from -3 to 2"),
    (lambda: ts.Vec(10**400, 0, 0), ts.UsageError, "a number above all that a float has"),
    (lambda: ts.Vec(1, 0, 0) * 10**400, ts.UsageError, "a number above all that a float has"),
    (lambda: ts.Mesh([[10**400, 0, 0]] * 3, [[0, 1, 2]]), ts.UsageError, "a number above all that a float has"),
    (lambda: ts.matrix([[10**400] * 4] * 3), ts.UsageError, "a number above all that a float has"),
    (lambda: ts.solve_quadratic(10**400, 1, 1), ts.UsageError, "a: a number above all that a float has"),
    (lambda: ts.color(10**400), ValueError, "color: a number above all that a float has"),
    (lambda: ts.color(b"red"), ValueError, "color: b'red'; expected a name"),
    (lambda: ts.hsl("x", 1, 1), TypeError, "hue: 'x'; expected a number"),
    (lambda: ts.hsl(0, None, .5), TypeError, "saturation: None; expected a number"),
    (lambda: ts.hsl(float("nan"), 1, .5), ValueError, "hue: nan; expected a finite number"),
    (lambda: TRACER.intersect([[1, 2, 3], [1]], (0, 0, 1)), ValueError, "origins: .*; expected an array of numbers"),
    (lambda: ts.Image.from_array([[1, 2], [3]]), ValueError, "array: .*; expected an array of numbers"),
    (lambda: ts.translate(1, 2, 3) @ [[1, 2, 3], [1]], ValueError, "points: .*; expected an array of numbers"),
    (lambda: ts.Image.from_array([[1.]], linear="no"), TypeError, "linear: 'no'; expected True or False"),
    (lambda: ts.Image.from_array(np.ma.array([[1.]], mask=True)), ts.UsageError, "array: masked values"),
    (lambda: ts.Mesh(np.ma.array(np.eye(3), mask=np.eye(3)), [[0, 1, 2]]), ts.UsageError, "masked values"),
    (lambda: ts.load_dict({"nodes": [{"shape": {"mesh": {"positions": np.zeros((3, 2), "f4")}}}]}), ts.UsageError,
     "positions"),
    (lambda: ts.Image.from_array([[1.]]).aov("light"), ts.UsageError, "aov: 'light'; expected none"),
    (lambda: ts.Image.from_array([[1.]]).aov("\ud800"), ts.UsageError, "name: .*; expected text that is UTF-8"),
    (lambda: SCENE.find(3), TypeError, "name: 3; expected text"),
    (lambda: SCENE.find("b", "y"), TypeError, "kind: 'y'; expected a class"),
    (lambda: SCENE.tracer(time=np.array([1, 2])), TypeError, "time: .*; expected a number"),
    (lambda: ts.Scene().add(ENDLESS), ts.SceneError, "nodes: .*nested"),
    (lambda: ts.Scene().instances(ts.Sphere(), [np.eye(4)], names=5), TypeError, "names: 5; expected a sequence"),
    (lambda: ts.load_dict({"settings": {"width": 10**5000}}), ts.UsageError, "too many digits"),
])
def test_no_words_of_libraries_are_told(call, error, message):
    with pytest.raises(error, match=message):
        call()


def test_vectors_are_sliced_and_compared_with_anything():
    vector = ts.Vec(1, 2, 3)
    assert vector[0:2] == (1, 2) and vector[-1] == 3 and vector != np.ndarray


def test_what_a_number_raises_is_not_lost():
    class Bad:
        def __float__(self):
            raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        ts.Vec(1, 2, 3) * Bad()
