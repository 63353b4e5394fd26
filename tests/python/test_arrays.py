"""Arrays between Python and Tessera: what is taken, shared, copied, refused and handed out."""
import copy
import ctypes
import gc
import pickle
import warnings

import numpy as np
import pytest

import tessera as ts

CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype="f4")
FACES = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7)], dtype="u4")


def test_import_brings_neither_numpy_nor_sockets(script):
    assert script("import sys, tessera; print({'numpy', 'socket'} & {*sys.modules})") == "set()"


@pytest.mark.parametrize("make", [
    lambda a: a, lambda a: a.astype("f8"), lambda a: a.astype(">f4"), lambda a: a.astype(">f8"),
    lambda a: a.astype("f2"), lambda a: a.astype("i8"), lambda a: np.asfortranarray(a),
    lambda a: np.repeat(a, 2, axis=0)[::2], lambda a: a[::-1][::-1], lambda a: a.tolist(),
    lambda a: [tuple(row) for row in a.tolist()], lambda a: memoryview(a), lambda a: WithArray(a)])
def test_positions_of_any_kind_are_taken(make):
    mesh = ts.Mesh(make(CUBE), FACES)
    assert mesh.positions.dtype == np.float32 and np.array_equal(mesh.positions, CUBE)


def of_ctypes(code, array):
    """An array of ctypes, whose buffer tells no strides."""
    kind = code
    for length in reversed(array.shape):
        kind = kind * length
    return kind.from_buffer_copy(np.ascontiguousarray(array, dtype=np.dtype(code)).tobytes())


def test_arrays_of_ctypes_are_taken_everywhere():
    texels = np.arange(24, dtype="u1").reshape(2, 4, 3)
    vertices, colors = of_ctypes(ctypes.c_float, CUBE), np.linspace(0, 1, 24).reshape(8, 3)
    mesh = ts.Mesh(vertices, of_ctypes(ctypes.c_int, FACES),
                   normals=of_ctypes(ctypes.c_double, CUBE - .5),
                   uvs=of_ctypes(ctypes.c_float, CUBE[:, :2]),
                   second_uvs=of_ctypes(ctypes.c_float, CUBE[:, 1:]), colors=of_ctypes(ctypes.c_float, colors),
                   tangents=of_ctypes(ctypes.c_float, np.ones((8, 4))),
                   materials=["a", "b"], face_materials=of_ctypes(ctypes.c_ubyte, np.array([0, 1, 0])))
    assert mesh == ts.Mesh(CUBE, FACES, normals=CUBE - .5, uvs=CUBE[:, :2], second_uvs=CUBE[:, 1:], colors=colors,
                           tangents=np.ones((8, 4)), materials=["a", "b"], face_materials=[0, 1, 0])
    matrices = np.arange(24.0).reshape(2, 3, 4)
    assert (ts.Scene().instances("it", of_ctypes(ctypes.c_double, matrices))
            == ts.Scene().instances("it", matrices))
    assert np.array_equal(ts.matrix(of_ctypes(ctypes.c_float, matrices[0])).array, matrices[0])
    assert ts.ImageTexture(of_ctypes(ctypes.c_ubyte, texels)) == ts.ImageTexture(texels)
    rays = np.array([[(0, 0, 5), (0, 0, 6)], [(0, 0, -1), (0, 0, 1)]], "f8")
    tracer = ts.Scene(nodes=[ts.Sphere()]).tracer()
    for code in (ctypes.c_double, ctypes.c_float):
        hits = tracer.intersect(*(of_ctypes(code, each) for each in rays),
                                t_max=of_ctypes(code, np.array([9., 9])))
        assert hits.t.tolist() == tracer.intersect(*rays).t.tolist()


class Shrinking:
    """A number that empties a list when it is read."""

    def __init__(self, rows):
        self.rows = rows

    def __float__(self):
        self.rows.clear()
        return 1.0


@pytest.mark.parametrize("of_row", [False, True])
def test_a_list_that_shrinks_while_it_is_read(of_row):
    rows = [[0.0, 0.0, 0.0] for _ in range(1000)]
    rows[0][0] = Shrinking(rows[0] if of_row else rows)
    found = "shrank from 3 to 0" if of_row else "shrank from 1000 to 0"
    with pytest.raises(ValueError, match=f"positions: a sequence that {found} while it was read"):
        ts.Mesh(rows, [(0, 1, 2)])


class WithMesh:
    def __init__(self, vertices, faces):
        self.vertices, self.faces = vertices, faces


class WithArray:
    def __init__(self, array):
        self.array = array

    def __array__(self, dtype=None):
        return self.array


@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", ">i4", ">u8"])
def test_indices_of_any_integer_type(kind):
    faces = FACES.astype(kind)
    assert np.array_equal(ts.Mesh(CUBE, faces).triangles, FACES)
    assert np.array_equal(ts.Mesh(CUBE, [list(row) for row in faces]).triangles, FACES)


@pytest.mark.parametrize("index", [-1, 8, 2**32, 2**32 + 1, 2**63])
def test_an_index_out_of_range_is_told(index):
    faces = FACES.astype("u8" if index == 2**63 else "i8")
    faces[1, 2] = index
    with pytest.raises(ValueError, match=f"triangles: index {index} in row 1; expected 0 to 7"):
        ts.Mesh(CUBE, faces)


def test_an_index_is_told_by_what_it_counts():
    with pytest.raises(ValueError, match="triangles: index 0 .*; expected none, since the mesh has no vert"):
        ts.Mesh(np.zeros((0, 3)), [(0, 1, 2)])
    with pytest.raises(ValueError, match="face_materials: index -1 in row 0; expected 0 to 4294967295$"):
        ts.Mesh(CUBE, FACES, face_materials=[-1, 0, 0])


def unaligned(array):
    """The same numbers one byte beside where they should be."""
    return np.frombuffer(b"x" + array.tobytes(), "u1")[1:].view(array.dtype).reshape(array.shape)


@pytest.mark.parametrize("kind, bad", [("u4", 5000), ("u4", 2**32 - 1), ("i4", -1), ("u8", 2**63),
                                       ("i8", 2**32 + 1), ("i8", -2**63), ("i2", -1), (">u4", 5000)])
def test_an_index_out_of_range_is_found_wherever_it_is(kind, bad):
    good = np.random.default_rng(1).integers(0, 5000, (4001, 3))
    good[17, 1] = 4999
    positions = np.zeros((5000, 3), "f4")
    for array in (good.astype(kind), unaligned(good.astype(kind)), good.astype(kind)[:, ::-1]):
        assert np.array_equal(ts.Mesh(positions, array).triangles, array)
    for row in (0, 341, 2000, 3999, 4000):
        wrong = good.astype(kind)
        wrong[row, 2] = bad
        with pytest.raises(ValueError, match=f"index {bad} in row {row}; expected 0 to 4999"):
            ts.Mesh(positions, wrong)


@pytest.mark.parametrize("count", [1, 2, 511, 512, 513, 3000])
def test_rounding_is_that_of_numpy(count):
    exact = np.random.default_rng(count).uniform(-1000, 3000, (count, 3))
    least, most = exact.min(axis=0), exact.max(axis=0)
    middle = least + (most - least) / 2
    for array in (exact, exact.astype(">f8"), unaligned(exact), np.asfortranarray(exact)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ts.PrecisionWarning)
            assert np.array_equal(ts.Mesh(array, [(0, 0, 0)]).positions, exact.astype("f4"))
        mesh = ts.Mesh(array, [(0, 0, 0)], recenter=True)
        assert np.array_equal(mesh.transform.array[:, 3], middle)
        assert np.array_equal(mesh.positions, (exact - middle).astype("f4"))


@pytest.mark.parametrize("row", [0, 1, 998, 999, 1000])
def test_the_largest_move_is_told_wherever_it_is(row):
    for axis in range(3):
        points = np.full((1001, 3), 2.0**25)
        points[row, axis] += 1  # single precision has every fourth number there
        with pytest.warns(ts.PrecisionWarning, match="rounded by up to 1 m"):
            ts.Mesh(points, FACES)


@pytest.mark.parametrize("field, array, message", [
    ("normals", np.zeros((4, 3)), r"normals: shape \(4, 3\); expected \(8, 3\), one a vertex"),
    ("uvs", np.zeros((8, 3)), r"uvs: shape \(8, 3\); expected \(8, 2\), one a vertex"),
    ("colors", np.zeros((8, 5)), r"colors: shape \(8, 5\); expected \(8, 3\) or \(8, 4\), one a vertex"),
    ("face_materials", np.zeros(4, "u4"), r"face_materials: shape \(4,\); expected \(3,\), one a triangle"),
])
def test_shapes_are_told_as_found_and_expected(field, array, message):
    with pytest.raises(ValueError, match=message):
        ts.Mesh(CUBE, FACES, **{field: array})
    mesh = ts.Mesh(CUBE, FACES)
    with pytest.raises(ValueError, match=message):
        setattr(mesh, field, array)


@pytest.mark.parametrize("positions", ["text", b"bytes", 3, None.__class__, [[1, 2], [3]], [[1, "x", 2]],
                                       np.zeros((2, 3), "c16"), np.zeros((2, 3), "O"),
                                       np.zeros(2, "f4,f4"), np.zeros((2, 3), "M8[s]"), [1, [2, 3]]])
def test_what_is_no_array_of_numbers(positions):
    with pytest.raises((TypeError, ValueError)):
        ts.Mesh(positions, FACES)
    with pytest.raises(TypeError, match="integer type"):
        ts.Mesh(CUBE, FACES.astype("f8"))


def frozen(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def test_read_only_memory_is_shared_and_kept_alive():
    positions = frozen(CUBE)
    mesh = ts.Mesh(positions, FACES)
    assert np.shares_memory(mesh.positions, positions)
    view = mesh.positions
    del mesh, positions
    gc.collect()
    assert np.array_equal(view, CUBE) and not view.flags.writeable


def test_memory_that_can_be_written_to_is_copied():
    positions = CUBE.copy()
    mesh = ts.Mesh(positions, FACES)
    positions[:] = 7
    assert np.array_equal(mesh.positions, CUBE)
    assert not np.shares_memory(ts.Mesh(CUBE, frozen(FACES)).triangles, FACES)
    # Nor can indices be changed through an Array, which is taken as it is.
    faces = FACES.copy()
    mesh = ts.Mesh(triangles=ts.Array.from_bytes(memoryview(faces).toreadonly(), "I", [3, 3]))
    mesh.positions = CUBE
    faces[:] = 2**31
    assert np.array_equal(mesh.triangles, FACES) and ts.Scene(nodes=[mesh]).digest
    assert np.shares_memory(ts.Scene(nodes=[mesh]).nodes[0].triangles, mesh.triangles)


@pytest.mark.parametrize("array, why", [(CUBE, "can be written to"), (frozen(CUBE.astype("f8")), "type"),
                                        (frozen(CUBE.astype(">f4")), "byte order"),
                                        (frozen(CUBE)[::2], "contiguous")])
def test_a_copy_can_be_refused(array, why):
    with pytest.raises(ValueError, match=f"positions: copy=False, but .*{why}"):
        ts.Mesh(array, FACES[:1], copy=False)
    shared = frozen(CUBE)
    assert np.shares_memory(ts.Mesh(shared, FACES, copy=False).positions, shared)
    assert not np.shares_memory(ts.Mesh(shared, FACES, copy=True).positions, shared)


@pytest.mark.parametrize("view", [
    lambda a: a.view(), lambda a: a[:], lambda a: memoryview(a).toreadonly(),
    lambda a: np.asarray(memoryview(a).toreadonly()),
    lambda a: np.frombuffer(bytearray(a.tobytes()), "f4").reshape(8, 3)])
def test_a_read_only_view_of_what_can_be_written_to_is_copied(view):
    positions = CUBE.copy()
    shown = view(positions)
    if isinstance(shown, np.ndarray):
        shown.flags.writeable = False
    mesh = ts.Mesh(shown, FACES)
    before = ts.Scene(nodes=[mesh]).digest
    positions[:] = 7
    assert np.array_equal(mesh.positions, CUBE) and ts.Scene(nodes=[ts.Mesh(CUBE, FACES)]).digest == before
    with pytest.raises(ValueError, match="copy=False, but .*can be written to"):
        ts.Mesh(shown, FACES, copy=False)


def test_views_of_what_nobody_can_write_to_are_shared():
    fixed = frozen(np.concatenate([CUBE, CUBE]))
    of_bytes = np.frombuffer(CUBE.tobytes(), "f4").reshape(8, 3)
    for shown in (fixed[8:], memoryview(fixed[8:]), of_bytes, ts.Mesh(CUBE, FACES).positions):
        assert np.shares_memory(ts.Mesh(shown, FACES, copy=False).positions, np.asarray(shown))


def test_recentring_cannot_go_without_a_copy():
    with pytest.raises(ValueError, match="copy=False, but recenter=True"):
        ts.Mesh(frozen(CUBE), FACES, copy=False, recenter=True)


def test_the_move_that_is_told_is_that_of_a_vertex():
    far = np.array([(2.0 ** 24, 2.0 ** 24, 2.0 ** 24)] * 3) + [(0, 0, 0), (1, 1, 1), (4, 0, 0)]
    with pytest.warns(ts.PrecisionWarning, match=r"rounded by up to 1\.73 m"):
        ts.Mesh(far)
    # On each axis it is less than a millionth of the extent.
    beside = 8 + 7e-7
    near = np.array([(beside, beside, beside), (9, 8, 8), (8, 9, 8)])
    with pytest.warns(ts.PrecisionWarning, match="rounded by up to .*e-0[67] m") as told:
        ts.Mesh(near + [16, 16, 16])
    assert len(told) == 1


def test_rounding_that_matters_is_told_once_a_mesh():
    corners = np.array([(0, 0, 0), (1, .1, 0), (.3, 1, .7)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ts.Mesh(corners + [2, 1, 1])
        ts.Mesh(1e-9 * (corners + [2, 1, 1]))
    with pytest.warns(ts.PrecisionWarning):
        ts.Mesh(1e-3 * corners + [.2, 17, 1])
    with pytest.warns(ts.PrecisionWarning) as told:
        mesh = ts.Mesh(corners + 1e6)
        mesh.positions = corners + 2e6
        copy.copy(mesh).positions = corners + 3e6
        pickle.loads(pickle.dumps(mesh)).positions = corners + 4e6
    assert len(told) == 1


def test_rounding_is_told_and_avoided():
    far = CUBE.astype("f8") + [1e7, 0, 0] + .1
    with pytest.warns(ts.PrecisionWarning, match="rounded by up to"):
        mesh = ts.Mesh(CUBE, FACES)
        mesh.positions = far
    with pytest.warns(ts.PrecisionWarning, match="rounded by up to") as told:
        ts.Mesh(far, FACES)
        ts.Mesh.from_(WithMesh(far, FACES))
    assert [warning.filename for warning in told] == [__file__] * 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ts.Mesh(CUBE.astype("f8") * .1, FACES)
        mesh = ts.Mesh(far, FACES, recenter=True)
    moved = mesh.positions.astype("f8") + mesh.transform.array[:, 3]
    assert np.abs(moved - far).max() < 1e-7


def test_none_at_all_is_legal():
    mesh = ts.Mesh(np.zeros((0, 3)), np.zeros((0, 3), "u4"))
    assert mesh.positions.shape == (0, 3) and mesh.triangles.shape == (0, 3)
    assert ts.Mesh([], []).positions.shape == (0, 3)
    assert ts.Scene(nodes=[mesh]).digest


def test_colours_without_alpha_get_one():
    mesh = ts.Mesh(CUBE, FACES, colors=np.full((8, 3), .5))
    assert np.array_equal(mesh.colors, np.tile(np.float32([.5, .5, .5, 1]), (8, 1)))


def test_read_only_colours_without_alpha_are_copied_whole():
    given = frozen(np.random.default_rng(1).random((8, 3), "f4"))
    held = ts.Mesh(CUBE, FACES, colors=given).colors
    assert held.shape == (8, 4) and np.array_equal(held[:, :3], given) and (held[:, 3] == 1).all()
    assert not np.shares_memory(held, given)
    with pytest.raises(ValueError, match="colors: copy=False, but it has another shape"):
        ts.Mesh(frozen(CUBE), FACES, colors=given, copy=False)
    mesh = ts.Mesh(CUBE, FACES)
    mesh.colors = ts.Array.from_bytes(given.tobytes(), "f", [8, 3])
    assert np.array_equal(mesh.colors, held)


def test_arrays_of_our_own():
    array = ts.Array.of([1.0, 2.0, 3.0, 4.0], "d", [2, 2])
    assert len(array) == 2 and array[1][0] == 3 and array[-1][-1] == 4 and array.shape == (2, 2)
    assert eval(repr(array), vars(ts)) == array
    assert np.shares_memory(np.asarray(array), np.asarray(array))
    with pytest.raises(IndexError):
        array[2]
    with pytest.raises((TypeError, ValueError)):
        memoryview(array)[0, 0] = 1
    for wrong in ([-1], [5], [2**62, 4]):
        with pytest.raises(ValueError):
            ts.Array.from_bytes(bytes(32), "d", wrong)


def test_vectors():
    a, b = ts.Vec(1, 2, 3), ts.Vec((4, 5, 6))
    assert a + b == (5, 7, 9) and a - b == (-3, -3, -3) and 2 * a == (2, 4, 6) and -a == (-1, -2, -3)
    assert a.dot(b) == 32 and a.cross(b) == (-3, 6, -3) and ts.Vec(3, 4, 0).length == 5
    assert np.array_equal(np.asarray(a), [1, 2, 3]) and tuple(a) == (1, 2, 3)
    assert ts.Scene(nodes=[ts.Sphere(a)]) == ts.Scene(nodes=[ts.Sphere(np.array([1, 2, 3]))])


@pytest.mark.parametrize("wrong, found", [
    ((1, 2), "2 numbers"), ((1, 2, "a"), "'a'"), ("abc", "'abc'"), (3, "3"), ((1, None, 2), "None")])
def test_what_is_no_vector_is_told(wrong, found):
    for use in (lambda: ts.Vec(wrong), lambda: ts.Vec(1, 2, 3).dot(wrong)):
        with pytest.raises(TypeError) as told:
            use()
        assert str(told.value) == f"{found}; expected a vector of 3 numbers"


def test_a_list_that_changes_while_it_is_read_is_no_vector():
    class Clears:
        def __float__(self):
            numbers.clear()
            return 1.0
    numbers = [Clears(), *np.random.default_rng(1).random(2).tolist()]
    rest = numbers[1:]
    assert tuple(ts.Vec(numbers)) == (1, *rest) and numbers == []


def test_textures_from_arrays():
    for texels, channels, bits in ((np.zeros((2, 3), "u1"), 1, 8), (np.zeros((2, 3, 4), "f2"), 4, 16),
                                   (np.zeros((2, 3, 3), "f8"), 3, 32)):
        texture = ts.ImageTexture(texels)
        assert (texture.height, texture.width, texture.channels, texture.bits) == (2, 3, channels, bits)
    by_array = ts.Scene(nodes=[ts.Sphere(material=ts.Classic(diffuse=np.zeros((2, 3, 3), "u1")))])
    assert len(by_array.to_dict()["textures"]) == 1
    picture = np.arange(24, dtype="u1").reshape(2, 4, 3)
    materials = [ts.Classic(diffuse="red", normal_map=given)
                 for given in (picture, ts.ImageTexture(picture, encoding="linear"))]
    skies = [ts.Background(panorama=ts.BackgroundPanorama(given)) for given in (picture, ts.ImageTexture(picture))]
    by_array, by_texture = (
        ts.Scene(nodes=[ts.Sphere(material=material)], background=sky, textures=[given]).digest
        for material, sky, given in zip(materials, skies, (picture, ts.ImageTexture(picture))))
    assert by_array == by_texture
    for none, found in ((np.zeros((2, 2), bool), "booleans"), ([], "no numbers"), (np.zeros((2, 2), "i8"), "other integers")):
        with pytest.raises(TypeError, match=f"texels: {found}.*; expected uint8, uint16 or floats"):
            ts.ImageTexture(none)
    with pytest.raises(ValueError, match=r"texels: shape \(2, 3, 5\)"):
        ts.ImageTexture(np.zeros((2, 3, 5), "u1"))


def test_a_mesh_of_what_has_points_and_cells():
    class Soup:
        points, cells = CUBE, FACES
    assert ts.Mesh.from_(Soup()) == ts.Mesh(CUBE, FACES)


def test_meshes_of_others():
    import meshio
    mesh = ts.Mesh.from_(meshio.Mesh(CUBE, [("triangle", FACES)]))
    assert np.array_equal(mesh.positions, CUBE) and np.array_equal(mesh.triangles, FACES)
    with pytest.raises(TypeError, match="expected vertices or points"):
        ts.Mesh.from_(object())


def test_cells_of_meshio_that_are_quads_become_triangles():
    import meshio
    quads = np.array([(0, 1, 3, 2), (4, 6, 7, 5)])
    mesh = ts.Mesh.from_(meshio.Mesh(CUBE, [("triangle", FACES), ("quad", quads)]))
    assert mesh.triangles.tolist() == [*FACES.tolist(), [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]]
    assert ts.Mesh.from_(meshio.Mesh(CUBE, [("quad", quads)])).triangles.tolist() == mesh.triangles[3:].tolist()
    beside = meshio.Mesh(CUBE, [("vertex", [[0]]), ("line", [(0, 1)]), ("triangle", FACES)])
    assert np.array_equal(ts.Mesh.from_(beside).triangles, FACES)
    with pytest.raises(ValueError, match="cells: 1 of kind 'tetra'; expected those of kinds 'triangle' and 'quad'"):
        ts.Mesh.from_(meshio.Mesh(CUBE, [("triangle", FACES), ("tetra", [(0, 1, 2, 4)])]))


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_whole_colours_of_vertices_are_codes_in_srgb(kind):
    most = np.iinfo(kind).max
    codes = np.array([(most, 0, most // 2, most // 2)] * 3, kind)
    for given in (codes, codes[:, :3]):
        held = ts.Mesh(TRIANGLE, colors=given).colors
        share = codes[0, 2] / most
        alpha = share if given is codes else 1
        assert held[0].tolist() == pytest.approx([1, 0, ((share + .055) / 1.055) ** 2.4, alpha], rel=1e-6)


def test_other_whole_colours_are_light_up_to_1():
    assert ts.Mesh(TRIANGLE, colors=[(1, 0, 0)] * 3).colors.tolist() == [[1, 0, 0, 1]] * 3
    with pytest.raises(ValueError, match="colors: the whole number 255; expected floats, or uint8"):
        ts.Mesh(TRIANGLE, colors=[(255, 0, 0)] * 3)
    assert ts.Mesh(TRIANGLE, colors=[(255., 0, 0)] * 3).colors[0, 0] == 255


TRIANGLE = [(0., 0, 0), (1, 0, 0), (0, 1, 0)]


def test_the_class_below_an_array_refuses_to_be_called():
    base = ts.Array.__base__
    for made in (base, type("Derived", (base,), {})):
        with pytest.raises(TypeError, match="cannot be called"):
            made()
    assert list(ts.Array.of([1, 2], "I", [2])) == [1, 2]


def test_masked_values_are_refused():
    whole = np.ma.array(np.eye(3))
    assert ts.Mesh(whole, [(0, 1, 2)]) == ts.Mesh(np.eye(3), [(0, 1, 2)])
    holed = np.ma.array(np.eye(3), mask=np.eye(3))
    for use in (lambda: ts.Mesh(holed, [(0, 1, 2)]), lambda: ts.ImageTexture(holed.astype("f4"))):
        with pytest.raises(ValueError, match="masked values; expected none"):
            use()


@pytest.mark.parametrize("use", [
    lambda hole: ts.Scene(nodes=[ts.Sphere(radius=hole)]).digest,
    lambda hole: ts.Scene(nodes=[ts.Sphere(center=(0, hole, 0))]).digest,
    lambda hole: ts.Scene(nodes=[ts.Sphere(material=ts.Classic(diffuse=hole))]).digest,
    lambda hole: ts.Scene(width=hole).digest,
    lambda hole: ts.Scene(cameras=[ts.Camera.look_at((0, 0, 5), (0, 0, 0), fov=hole)]).to_dict(),
    lambda hole: ts.Scene().render(workers=0, time=hole),
    lambda hole: ts.Scene().render(workers=0, size=(4, hole)),
    lambda hole: ts.Farm(timeout=hole), lambda hole: ts.Mesh([(0, hole, 0)]), lambda hole: ts.Vec((0, hole, 0)),
    lambda hole: ts.color((hole, 0, 0)),
])
def test_a_masked_number_is_refused_before_it_is_converted(use):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match="masked values; expected none, as in the array's filled"):
            use(np.ma.masked)


def test_booleans_are_no_indices_in_lists_either():
    for booleans in ([[True, False, True]], [[np.True_, np.False_, np.True_]], np.array([[True, False, True]])):
        with pytest.raises(TypeError, match="^triangles: booleans; expected an integer type"):
            ts.Mesh(TRIANGLE, booleans)
    with pytest.raises(TypeError, match="^face_materials: booleans; expected an integer type"):
        ts.Mesh(TRIANGLE, [(0, 1, 2)], face_materials=[True])
    assert len(ts.Mesh(TRIANGLE, [], face_materials=[]).triangles) == 0


@pytest.mark.parametrize("wrong", [np.ones(3, complex), np.full(3, "1")])
def test_transforms_move_real_numbers(wrong):
    with pytest.raises(TypeError, match="points: dtype .*; expected float64 or what fits into it"):
        ts.translate(1, 2, 3) @ wrong
