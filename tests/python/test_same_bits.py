"""Python renders the bits of the command line, whoever traces."""
import json
import pathlib

import pytest

import tessera as ts

SAMPLES = pathlib.Path(__file__).parents[2] / "scenes" / "samples"
SCENES = sorted(p.name for p in SAMPLES.iterdir()
                if p.suffix in (".tessera", ".obj", ".x3d", ".x3dv", ".wrl", ".gltf", ".glb", ".ply",
                              ".stl", ".crt"))
SIZE = (48, 36)


@pytest.fixture(scope="module")
def farms():
    with ts.Threads(2) as threads, ts.LocalFarm(2) as processes:
        yield threads, processes


@pytest.mark.parametrize("name", SCENES)
def test_a_sample_as_file_and_as_value(name, farms, tessera, tmp_path):
    path = str(SAMPLES / name)
    crop = (3, 2, 40, 30)
    tessera("render", path, "--size", "48x36", "--crop", "3,2,40,30", "--aovs", "depth,id",
            "--workers", "0", "-o", tmp_path / "x.exr", "--stats", tmp_path / "x.json", "--quiet")
    expected = json.loads((tmp_path / "x.json").read_text())["pixels_sha256"]
    for farm in farms:
        for scene in (path, ts.load(path)):
            image = ts.render(scene, size=SIZE, crop=crop, aovs=("depth", "id"), farm=farm)
            assert image.sha256 == expected
    plain = ts.render(path, size=SIZE, crop=crop, farm=farms[0])
    assert plain.sha256 == expected


@pytest.mark.parametrize("python, command", [
    ({"spp": 9, "pattern": "independent", "seed": 5}, ["--spp", "9", "--pattern", "independent",
                                                      "--seed", "5"]),
    ({"spp": 16, "filter": "gaussian:1.25"}, ["--spp", "16", "--filter", "gaussian:1.25"]),
    ({"integrator": "path", "spp": 4, "tile": 7}, ["--integrator", "path", "--spp", "4", "--tile", "7"]),
    ({"target_error": .05, "min_spp": 4, "spp": 32}, ["--target-error", ".05", "--min-spp", "4",
                                                      "--spp", "32"]),
    ({"accel": "octree", "time": .5, "pinhole": True}, ["--accel", "octree", "--time", ".5",
                                                        "--pinhole"]),
    ({"frame_all": True, "camera": "1"}, ["--frame-all", "--camera", "1"]),
    ({"view": "right", "up": "z"}, ["--view", "right", "--up", "z"]),
    ({"transparent_background": True, "spp": 4}, ["--transparent-background", "--spp", "4"]),
    ({"place": ":at=1,0,0:scale=2"}, ["--place", ":at=1,0,0:scale=2"]),
])
def test_an_option_does_what_it_does_on_the_command_line(python, command, farms, tessera, tmp_path):
    path = str(SAMPLES / "mosaic.tessera")
    tessera("render", path, "--size", "48x36", "--workers", "0", "-o", tmp_path / "x.exr", "--quiet",
            *command)
    image = ts.render(path, size=SIZE, farm=farms[1], **python)
    assert (image.linear == ts.read_image(tmp_path / "x.exr").linear).all()


def test_nothing_of_the_environment_is_needed(tmp_path):
    import os
    import subprocess
    import sys
    script = ("import tessera as ts; print(ts.render(%r, size=(8, 8), integrator='depth').sha256)"
              % str(SAMPLES / "knot.tessera"))
    python_path = os.environ["PYTHONPATH"]
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                           env={"PYTHONPATH": python_path}, cwd=tmp_path).stdout
    assert shown.strip() == ts.render(str(SAMPLES / "knot.tessera"), size=(8, 8), workers=0,
                                      integrator="depth").sha256
