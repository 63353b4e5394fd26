"""Values copy and pickle, in this process and into others."""
import copy
import multiprocessing
import pickle

import cloudpickle
import numpy as np
import pytest

import tessera as ts
from tessera import _core


def made():
    positions = np.arange(9, dtype="f4").reshape(3, 3)
    scene = ts.Scene(width=8, background="skyblue")
    scene.add(ts.Mesh(positions, [(0, 1, 2)], material=ts.Classic(diffuse="red")), name="mesh")
    scene.instances(ts.Sphere(), np.eye(4)[None])
    return scene


@pytest.mark.parametrize("module", [pickle, cloudpickle])
@pytest.mark.parametrize("protocol", [2, 4, 5])
def test_a_scene_there_and_back(module, protocol):
    scene = made()
    again = pickle.loads(module.dumps(scene, protocol=protocol))
    assert again == scene and again.digest == scene.digest and repr(again) == repr(scene)


def test_what_is_not_set_takes_no_bytes():
    text = pickle.dumps(ts.Sphere(radius=2))
    assert b"radius" in text and b"center" not in text


def test_arrays_go_out_of_band():
    buffers = []
    data = pickle.dumps(made(), protocol=5, buffer_callback=buffers.append)
    assert sum(buffer.raw().nbytes for buffer in buffers) == 9 * 4 + 3 * 4 + 12 * 8
    assert pickle.loads(data, buffers=buffers) == made()


def test_arrays_of_tracers_and_hits_go_out_of_band():
    points = np.random.default_rng(3).uniform(0, 1, (3000, 3)).astype("f4")
    tracer = ts.Scene(nodes=[ts.Mesh(points, np.arange(3000).reshape(-1, 3))]).tracer()
    hits = tracer.intersect(np.zeros((1000, 3)), (1, 1, 1))
    for made, most in ((tracer, 1000), (hits, 4000)):
        buffers = []
        data = pickle.dumps(made, protocol=5, buffer_callback=buffers.append)
        assert len(data) < most and buffers
        again = pickle.loads(data, buffers=buffers)
        assert again.intersect((0, 0, 0), (1, 1, 1)).t == hits.t[0] if made is tracer else (again.t == hits.t).all()


def test_another_process_sees_the_same():
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(digest_of, (made(),)) == made().digest


def digest_of(scene):
    return scene.digest


def test_a_copy_is_apart():
    scene = made()
    shallow, deep = copy.copy(scene), copy.deepcopy(scene)
    shallow.nodes.pop()
    deep.nodes[0].name = "other"
    assert len(scene.nodes) == 2 and scene.nodes[0].name == "mesh"
    assert shallow != scene and deep != scene and made() == scene


def test_a_material_shared_stays_shared():
    red = ts.Classic(diffuse="red")
    first, second = pickle.loads(pickle.dumps([ts.Sphere(material=red), ts.Box(material=red)]))
    assert first.material is second.material


def test_the_place_survives():
    sphere = pickle.loads(pickle.dumps(ts.Sphere(radius="big")))
    with pytest.raises(ts.SceneError) as told:
        ts.Scene(nodes=[sphere]).digest
    assert told.value.place.startswith(__file__)


CLASSES = [_core.Array, _core.Vec, _core.Picture, _core.Options, _core.Task, _core.FarmThread,
           _core.FarmAccess, _core.FetchedPicture, _core.Tracer]


def test_all_classes_of_the_module_are_known_here():
    bases = {_core.ValueBase, _core.Order}  # which hold nothing, and a number
    assert {held for held in vars(_core).values() if isinstance(held, type)} - bases == {*CLASSES}


@pytest.mark.parametrize("made", CLASSES, ids=lambda made: made.__name__)
def test_no_object_is_there_without_what_it_holds(made):
    tampered = b"\x80\x02ctessera._core\n" + made.__name__.encode() + b"\n)\x81."
    for make in (lambda: made.__new__(made), lambda: made.__base__.__new__(made),
                 lambda: object.__new__(made), lambda: pickle.loads(tampered),
                 lambda: type("Derived", (made,), {})):
        with pytest.raises(TypeError):
            make()


def test_new_makes_the_whole_object():
    made = ts.Vec.__new__(ts.Vec, 1, 2, 3)
    assert made == (1, 2, 3)
    made.__init__(4, 5, 6)  # vectors never change
    assert made == (1, 2, 3)
    for value in (made, ts.translate(1, 2, 3).array.base.obj):
        assert pickle.loads(pickle.dumps(value)) == value == copy.deepcopy(value)


def test_functions_of_objects_refuse_none():
    farm = _core.threads_here(1)
    for call in (lambda: _core.picture_state(None), lambda: farm.submit(None)):
        with pytest.raises(TypeError):
            call()
    farm.close()


def test_a_class_of_messages_stands_for_the_one_that_users_see():
    """As in pickles of shapes that once had no class of their own."""
    text = pickle.dumps(ts.Sphere(radius=2), protocol=0)
    older = text.replace(b"ctessera._shapes\nSphere\n", b"ctessera._messages\nSphere\n")
    assert older != text
    again = pickle.loads(older)
    assert type(again) is ts.Sphere and again == ts.Sphere(radius=2)
    assert again.shift((1, 0, 0)).transform is not None
