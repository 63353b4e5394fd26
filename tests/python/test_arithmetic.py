"""Operators of vectors, colours and transforms, also with arrays of numpy."""
import operator

import numpy as np
import pytest

import tessera as ts

V = ts.Vec(1, 2, 4)
OPERATORS = [operator.add, operator.sub, operator.mul, operator.truediv, operator.floordiv, operator.mod,
             operator.pow, operator.matmul, operator.eq, operator.ne, operator.lt, operator.le,
             operator.gt, operator.ge]


@pytest.mark.parametrize("of", OPERATORS)
@pytest.mark.parametrize("array", [np.array([2., 3, 4]), np.arange(1, 10).reshape(3, 3)])
def test_with_arrays_a_vector_is_one(of, array):
    for found, expected in ((of(V, array), of(np.asarray(V), array)),
                            (of(array, V), of(array, np.asarray(V)))):
        assert type(found) is type(expected) and np.array_equal(found, expected)


def test_numbers_of_numpy_are_numbers():
    for number in (2, 2., np.float64(2), np.float32(2), np.int64(2), np.array(2.)):
        assert type(V * number) is type(number * V) is type(V / number) is ts.Vec
        assert V * number == number * V == ts.Vec(2, 4, 8) and V / number == ts.Vec(.5, 1, 2)
    assert np.allclose(np.sin(V), np.sin([1, 2, 4])) and np.linalg.norm(V) == V.length


def test_vectors_compare_by_value():
    for same in (V, (1, 2, 4), [1, 2, 4], [1., 2, 4]):
        assert V == same and same == V and not V != same
    for other in ((1, 2, 5), (1, 2), [1, 2, 4, 8], "124", None, 4, [1, 2, "4"]):
        assert V != other and other != V and not V == other
    assert len({V, ts.Vec(1, 2, 4)}) == 1


@pytest.mark.parametrize("wrong", [lambda: V * "2", lambda: V + 1, lambda: V * V, lambda: V + "abc",
                                   lambda: V + (1, 2), lambda: 1 / V, lambda: V @ V, lambda: V < V])
def test_what_vectors_cannot_do(wrong):
    with pytest.raises(TypeError):
        wrong()


def test_operators_are_left_to_the_other():
    class Other:
        def __radd__(self, _):
            return "radd"

        def __rmul__(self, _):
            return "rmul"
    assert V + Other() == "radd" and V * Other() == "rmul"


def test_colours_are_added_and_scaled():
    red, grey = ts.Color(.5, .25, 0), ts.color(.25)
    for found, expected in ((red * 2, (1, .5, 0)), (2 * red, (1, .5, 0)), (red / 2, (.25, .125, 0)),
                            (red + grey, (.75, .5, .25)), (red - grey, (.25, 0, -.25)),
                            ((1, 1, 1) - red, (.5, .75, 1)), ((1, 1, 1) + red, (1.5, 1.25, 1)),
                            (-red, (-.5, -.25, 0)), (red * np.float64(2), (1, .5, 0))):
        assert type(found) is ts.Color and found == expected
    assert np.array_equal(red * np.arange(3), [0, .25, 0]) and np.array_equal(np.arange(3) + red, [.5, 1.25, 2])
    with pytest.raises(TypeError):
        red + "red"


def test_transforms_apply_to_points():
    moved = ts.translate(1, 2, 3) @ ts.rotate("z", 90) @ ts.scale(2)
    points = np.random.default_rng(5).normal(size=(4, 7, 3))
    array = moved.array
    expected = np.einsum("ij,abj->abi", array[:, :3], points) + array[:, 3]
    assert np.allclose(moved @ points, expected, rtol=1e-15, atol=1e-14) and (moved @ points).shape == (4, 7, 3)
    assert np.allclose(moved @ [(1, 0, 0), (0, 0, 1)], [(1, 4, 3), (1, 2, 5)])
    one = moved @ ts.Vec(1, 0, 0)
    assert isinstance(one, ts.Vec) and np.allclose(one, (1, 4, 3))
    assert isinstance(moved @ moved, ts.Transform)
    with pytest.raises(ts.UsageError, match=r"points: shape \(2, 4\); expected \(\.\.\., 3\)"):
        moved @ np.zeros((2, 4))
    for wrong in ("abc", 3, None, ts.Sphere()):
        with pytest.raises(TypeError):
            moved @ wrong


@pytest.mark.parametrize("wrong, shape", [(np.eye(2), r"\(2, 2\)"), ([[1, 0], [0, 1]], r"\(2, 2\)"),
                                          ([1, 2, 3], r"\(3,\)")])
def test_shapes_of_matrices_are_told_as_given(wrong, shape):
    with pytest.raises(ValueError, match=rf"matrix: shape {shape}; expected \(3, 4\) or \(4, 4\)"):
        ts.matrix(wrong)


def test_matrices_of_lists():
    rows = [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7]]
    assert (ts.matrix(rows).array == rows).all() and (ts.matrix([*rows, [0, 0, 0, 1]]).array == rows).all()
    with pytest.raises(ValueError, match="matrix: 2 matrices; expected one"):
        ts.matrix([rows, rows])


def test_copies_are_apart():
    paint, ball = ts.Classic(), ts.Sphere(radius=1)
    ball.material = paint
    solid = ball - ts.Box()
    for original in (ts.Node(shape=solid), ts.Node(children=[ts.Node(shape=solid)]), solid):
        before = original.__copy__()
        twin = original.copy()
        inner = twin
        while not isinstance(inner, ts.Csg):
            inner = (inner.instance_of.nodes[0] if inner.instance_of else
                     inner.children[0] if inner.children else inner.shape)
        inner.operands[0].radius = 2
        inner.operands[0].shift((1, 0, 0))
        assert original == before and ball.radius == 1 and ball.transform is None
        assert inner.operands[0].material is paint
