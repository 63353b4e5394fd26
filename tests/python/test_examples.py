"""The examples, each run as a script with nothing in its environment but where the package is."""
import math
import os
import pathlib
import re
import runpy
import subprocess
import sys

import numpy as np
import pytest

import tessera as ts

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
ENVIRONMENT = {name: os.environ[name] for name in ("PYTHONPATH", "TESSERA_PROGRAM") if name in os.environ}


# Of the linear pixels. It changes with the picture alone: look at that.
TOOLBOX_SHA256 = "1d66474cdbdc56a36050f69a1736e8673f823d3d27fa3eeb0f5bec89e7a75ac6"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Runs an example in an empty folder; returns what it prints."""
    monkeypatch.chdir(tmp_path)

    def run(name, *arguments):
        command = [sys.executable, "-B", str(EXAMPLES / name), *map(str, arguments)]
        done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return done.stdout
    return run


def test_ray_casting_measures_the_volume(run):
    radius, cap = 1.2, 0.2  # of the ball, and the height by which it sticks out of each face
    cut_off = 6 * math.pi * cap ** 2 * (3 * radius - cap) / 3
    volume = 8 - (4 / 3 * math.pi * radius ** 3 - cut_off)
    by_rays, by_points = map(float, re.findall(r"volume.* ([\d.]+) m", run("ray_casting.py", 200)))
    assert by_rays == pytest.approx(volume, abs=1e-3)
    deviation = 8 * math.sqrt(volume / 8 * (1 - volume / 8) / 200 ** 2)
    assert by_points == pytest.approx(volume, abs=4 * deviation)


def test_the_depth_camera_sees_what_is_there(run):
    told = run("depth_camera.py", 160)
    seen = {name: int(count) for name, count in re.findall(r"(\w+): (\d+) pixels", told)}
    points = np.load("points.npy")
    assert len(points) == sum(seen.values()) and min(seen.values()) > 1000
    on_floor = np.abs(points[:, 1]) < 1e-12
    on_ball = np.abs(np.linalg.norm(points - (-1, .8, 0), axis=1) - .8) < 1e-12
    assert (on_floor.sum(), on_ball.sum()) == (seen["floor"], seen["ball"])
    picture = ts.read_image("depth.png").to_srgb()
    assert picture.shape == (120, 160, 3) and not picture[0].any() and picture[-1].all()


def test_the_ao_map_is_dark_where_things_touch(run):
    assert f"{160 * 90 * 8} rays" in run("ao_map.py", 160, 8)
    assert ts.read_image("ao.png").linear[0].min() == pytest.approx(1)


def test_the_share_of_the_sky_below_a_ball_is_as_known():
    scene = ts.Scene(nodes=[ts.Plane(), ts.Sphere(center=(0, 1.5, 0))])
    tracer = scene.tracer()
    hits = tracer.intersect(np.full((10000, 3), (0, .1, 0)), (0, -1, 0))
    share = runpy.run_path(str(EXAMPLES / "ao_map.py"))["sky_share"](tracer, hits, 4).mean()
    blocked = 1 / 1.5 ** 2  # the form factor of a ball, seen from straight below
    deviation = math.sqrt(blocked * (1 - blocked) / 40000)
    assert share == pytest.approx(1 - blocked, abs=4 * deviation)


def test_the_turntable_sends_the_mesh_once(run):
    sent = list(map(int, re.findall(r"(\d+) bytes", run("turntable.py", 3, 100))))
    assert sent[0] > 500_000 and max(sent[1:]) < 10_000
    first, second, _ = (ts.read_image(f"turn.{frame:03}.png") for frame in range(3))
    assert first.width == 100 and first != second


def test_a_farm_renders_the_animation(run):
    told = run("farm.py", 3, 96)
    assert "job 1: done, 1 workers" in told
    rolls = [ts.read_image(f"roll.{frame:04}.png") for frame in range(3)]
    assert rolls[0].height == 54 and len({roll.sha256 for roll in rolls}) == 3


def test_the_toolbox_makes_the_picture_that_it_made(run):
    assert run("toolbox.py", 140, "small.png").split() == ["small.png:", TOOLBOX_SHA256]
    picture = ts.read_image("small.png")
    assert (picture.width, picture.height) == (140, 140) and picture.linear.std() > .1
    assert len((EXAMPLES / "toolbox.py").read_text().splitlines()) <= 60
