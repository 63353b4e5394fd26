"""Cameras of calibrations, poses, and transforms the other way."""
import pickle
import numpy as np
import pytest

import tessera as ts

FX, FY, CX, CY, WIDTH, HEIGHT = 90., 120., 20.25, 41.5, 64, 48
PLACE = ts.translate(1, 2, 3) @ ts.rotate((1, 2, -1), 35)
OPENCV = np.diag([1., -1, -1, 1])


def calibrated(**fields):
    return ts.Camera.from_intrinsics(FX, FY, CX, CY, WIDTH, HEIGHT, world_from_camera=PLACE, **fields)


def projected(points, pose):
    """The pixels of points, by the equations of OpenCV's manual."""
    x, y, z = np.linalg.inv(pose @ OPENCV)[:3] @ np.c_[points, np.ones(len(points))].T
    return np.stack([FX * x / z + CX, FY * y / z + CY], axis=-1)


def rays(camera, size=(WIDTH, HEIGHT)):
    return ts.Scene(cameras=[camera]).tracer().camera_rays(size)


def test_rays_of_a_calibrated_camera_meet_its_pixels():
    camera = calibrated()
    origins, directions = rays(camera)
    points = (origins + 7 * directions).reshape(-1, 3)
    columns, rows = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    expected = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    assert np.abs(projected(points, camera.pose) - expected).max() < 1e-10


def test_a_calibrated_picture_has_points_where_they_are_projected():
    points = PLACE @ np.array([(0., 0, -5), (1.2, .3, -4), (-.4, .9, -6)])
    scene = ts.Scene(cameras=[calibrated()], background=1,
                     nodes=[ts.Sphere(point, .1) for point in points])
    seen = scene.render(size=(WIDTH, HEIGHT), spp=1, aovs="id", workers=0).aov("id")
    for column, row in projected(points, scene.camera.pose).round().astype(int):
        assert seen[row, column]


def test_other_sizes_of_the_shape_see_the_same():
    _, small = rays(calibrated())
    _, large = rays(calibrated(), (3 * WIDTH, 3 * HEIGHT))
    assert np.abs(large[1::3, 1::3] - small).max() < 1e-14


def test_a_principal_point_in_the_middle_is_no_shift():
    camera = ts.Camera.from_intrinsics(50, 50, 31.5, 23.5, WIDTH, HEIGHT)
    assert (camera.perspective.shift_x, camera.perspective.shift_y) == (0, 0)
    plain = ts.Camera(perspective=ts.Perspective(camera.perspective.field_of_view, "horizontal"))
    assert np.array_equal(rays(camera)[1], rays(plain)[1])


def test_a_shifted_camera_frames_all():
    nodes = [ts.Sphere((x, y, z), .5) for x, y, z in ((0, 0, 0), (6, 1, -3), (2, 4, 2))]
    scene = ts.Scene(cameras=[calibrated(frame_all=True)], nodes=nodes, background=1)
    seen = scene.render(size=(WIDTH, HEIGHT), spp=1, aovs="id", workers=0).aov("id") > 0
    assert seen.any()
    assert not (seen[0].any() or seen[-1].any() or seen[:, 0].any() or seen[:, -1].any())
    across, down = np.flatnonzero(seen.any(axis=0)), np.flatnonzero(seen.any(axis=1))
    margins = across[0], WIDTH - 1 - across[-1], down[0], HEIGHT - 1 - down[-1]
    assert min(margins) <= 3 and max(abs(margins[0] - margins[1]), abs(margins[2] - margins[3])) <= 4


@pytest.mark.parametrize("wrong, message", [
    ({"fx": 0}, "^fx: 0.0; expected a focal length above 0"),
    ({"fy": float("nan")}, "^fy: nan; expected"), ({"fy": 50001}, "^fy: 50001.0; expected a number from fx / 1000"),
    ({"width": 0}, "^width: 0; expected at least 1")])
def test_numbers_of_no_calibration_are_refused(wrong, message):
    numbers = {"fx": 50, "fy": 50, "cx": 32, "cy": 24, "width": 64, "height": 48, **wrong}
    with pytest.raises(ts.UsageError, match=message):
        ts.Camera.from_intrinsics(**numbers)


def test_a_window_beyond_its_range_is_refused():
    for field, value in (("shift_x", 1001), ("shift_y", float("nan")), ("pixel_aspect", -1)):
        scene = ts.Scene(cameras=[ts.Camera(perspective=ts.Perspective(**{field: value}))])
        with pytest.raises(ts.SceneError, match=f"perspective.{field}"):
            scene.check()


def test_the_pose_is_the_matrix_of_the_camera():
    camera = ts.Camera.look_at((1, 2, 8), (1, 2, 0))
    assert np.allclose(camera.pose, [(1, 0, 0, 1), (0, 1, 0, 2), (0, 0, 1, 8), (0, 0, 0, 1)])
    assert np.array_equal(ts.Camera().pose, np.eye(4))
    camera.keys = ts.keys([(0, PLACE)])
    with pytest.raises(ts.UsageError, match="^pose: of a camera that moves"):
        camera.pose
    for rows in (calibrated().pose, calibrated().pose[:3]):
        camera.pose = rows
        assert not camera.keys and np.array_equal(camera.pose, calibrated().pose)
    with pytest.raises(ValueError, match="expected"):
        camera.pose = np.zeros((2, 2))


def test_an_inverse_undoes_its_transform():
    points = np.random.default_rng(3).normal(size=(20, 3))
    transform = PLACE @ ts.scale(2, .5, -3)
    assert np.abs(transform.inverse() @ (transform @ points) - points).max() < 1e-13
    assert np.abs((transform @ transform.inverse()).array - np.eye(3, 4)).max() < 1e-13
    with pytest.raises(ValueError, match="^transform: has no inverse"):
        ts.scale(1, 0, 1).inverse()


def test_depth_along_the_axis_is_that_along_the_ray_by_its_cosine():
    camera = calibrated()
    wall = ts.Scene(cameras=[camera], background=1, nodes=[ts.Node(shape=ts.Plane((0, 0, 1), -4), transform=PLACE)])
    size = (WIDTH, HEIGHT)
    depth = wall.render(size=size, spp=1, workers=0, aovs="depth").aov("depth")
    z = depth * (wall.tracer().camera_rays(size)[1] @ -camera.pose[:3, 2])
    assert np.abs(z - 4).max() < 2e-2 and np.ptp(depth) > .1


def test_shapes_at_different_places_are_not_equal():
    there = ts.Sphere().shift((1, 0, 0))
    assert there != ts.Sphere() and there == ts.Sphere().shift((1, 0, 0))
    assert ts.Csg("union", [there]) != ts.Csg("union", [ts.Sphere()])


def test_a_transparent_background(tmp_path):
    scene = ts.Scene(width=16, height=12, spp=8, background=(.25, .5, 1))
    scene.add(ts.Sphere(radius=.7), material=ts.Classic(emission=(.5, .25, 0), diffuse=0))
    whole, image = scene.render(workers=0), scene.render(workers=0, transparent_background=True)
    assert whole.alpha is None and image.alpha.shape == (12, 16) and not image.alpha.flags.writeable
    assert ((image.alpha > 0) & (image.alpha < 1)).any() and image.aovs == []
    over = image.linear + (1 - image.alpha[..., None]) * np.array([.25, .5, 1], "f4")
    np.testing.assert_allclose(over, whole.linear, atol=1e-6)
    image.save(tmp_path / "x.exr", tmp_path / "x.png")
    assert (ts.read_image(tmp_path / "x.exr").linear == image.linear).all()
    assert (image.to_srgb()[0, 0] == 0).all() and pickle.loads(pickle.dumps(image)) == image
    with pytest.raises(ts.UsageError, match="holds no alpha"):
        image.save(tmp_path / "x.jpg")


@pytest.mark.parametrize("length", [1e-300, 1, 1e300])
def test_the_pose_does_not_depend_on_the_length_of_up(length):
    pose = ts.Camera.look_at((0, 0, 5), (0, 0, 0), (length, 0, 0)).pose
    assert pose.tolist() == [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]
