"""Renders that were interrupted go on from the tiles that they left, as `tessera render --resume`."""
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import tessera as ts

TILES = 48
LOAD = {"size": (128, 96), "tile": 16, "spp": 256}
PROGRAM = os.environ["TESSERA_PROGRAM"]


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = ts.Scene(camera=ts.Camera.look_at((0, 0, 5), (0, 0, 0)))
    made.add(ts.Torus(minor_radius=.4), material=ts.Classic(diffuse="orange"))
    made.add(ts.PointLight(position=(3, 4, 5)))
    made.save("ring.tessera")
    return "ring.tessera"


def interrupt(scene, after=5, **options):
    """Renders until some tiles are done; how many were kept."""
    done = []

    def stop(rect, _):
        done.append(rect)
        if len(done) >= after:
            raise StopIteration

    with pytest.raises(StopIteration):
        ts.render(scene, on_tile=stop, **LOAD, **options)
    return len(done)


@pytest.mark.parametrize("workers", [0, 2])
def test_it_goes_on_from_what_was_kept(scene, workers):
    expected = ts.render(scene, workers=0, **LOAD)
    assert interrupt(scene, resume=True, workers=workers, threads=1) >= 5
    assert os.path.exists("ring.png.tiles")
    image = ts.render(scene, resume=True, workers=workers, **LOAD)
    assert 5 <= image.stats["tiles"]["restored"] < TILES and image == expected
    assert os.listdir() == [scene]
    assert ts.render(scene, workers=0, **LOAD).stats["tiles"]["restored"] == 0


def test_the_command_line_goes_on_from_it_and_it_from_the_command_line(scene, tmp_path):
    with ts.Threads(1) as farm:  # which is kept, and lets go of the file nevertheless
        interrupt(scene, resume=tmp_path / "a.png", farm=farm)
        command = [PROGRAM, "render", scene, "-o", "a.png", "--size", "128x96", "--tile", "16", "--spp", "256",
                   "--resume", "--workers", "0"]
        told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        assert " kept from an earlier run, " in told and ", 0 kept" not in told
        assert not os.path.exists("a.png.tiles")

    process = subprocess.Popen([*command, "--threads", "1"])
    while not os.path.exists("a.png.tiles-wal") or os.stat("a.png.tiles-wal").st_size < 100_000:
        assert process.poll() is None
        time.sleep(.001)
    process.send_signal(signal.SIGKILL)
    process.wait()
    again = ts.render(scene, resume="a.png", workers=0, **LOAD)
    assert again.stats["tiles"]["restored"] > 0 and not os.path.exists("a.png.tiles")


def test_a_script_that_was_killed_is_started_again(scene, tmp_path):
    code = f"import tessera as ts; ts.render({scene!r}, resume=True, workers=2, **{LOAD!r})"
    process = subprocess.Popen([sys.executable, "-c", code])
    log = tmp_path / "ring.png.tiles-wal"
    while not log.exists() or log.stat().st_size < 100_000:
        assert process.poll() is None
        time.sleep(.001)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert ts.render(scene, resume=True, workers=2, **LOAD).stats["tiles"]["restored"] > 0


def test_a_scene_of_python_names_its_picture(scene):
    made = ts.load(scene)
    with pytest.raises(ts.UsageError, match="resume: True, for a scene of no file"):
        made.render(resume=True)
    interrupt(made, resume="ours.png", workers=0, threads=1)
    image = made.render(resume="ours.png", workers=0, **LOAD)
    assert image.stats["tiles"]["restored"] >= 5 and np.isfinite(image.linear).all()


def test_tiles_of_another_scene_stay_and_are_told(scene, caplog):
    interrupt(scene, resume="a.png", workers=0, threads=1)
    other = ts.render(scene, seed=1, resume="a.png", workers=0, **LOAD)
    assert other.stats["tiles"]["restored"] == 0
    assert "of other scenes or settings stay in" in caplog.text and os.path.exists("a.png.tiles")


def test_what_cannot_be_resumed_is_refused(scene, tmp_path):
    (tmp_path / "b.png.tiles").write_bytes(b"diary " * 1000)
    with pytest.raises(ts.Error, match="file of finished tiles"):
        ts.render(scene, resume="b.png", workers=0)
    assert (tmp_path / "b.png.tiles").stat().st_size == 6000
    with pytest.raises(TypeError, match="resume: 3; expected"):
        ts.render(scene, resume=3)
    with pytest.raises(ts.UsageError, match="resume: tiles are kept where the coordinator is"):
        ts.render(scene, resume=True, farm=ts.Farm("tcp://127.0.0.1:1", timeout=1))
