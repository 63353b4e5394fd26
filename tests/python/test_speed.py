"""What the speed of the package rests on and can be counted: copies, bytes sent, memory. Times are
measured by tests/bench/python_speed.py, python_rays.py and winding_holes.py, which are run here with
tiny sizes."""
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import tessera as ts

BENCH = pathlib.Path(__file__).parents[1] / "bench"
BUILD = pathlib.Path(ts.__file__).parents[2]
MIB = 2**20
sys.path.insert(0, str(BENCH))
from bench_table import SLACK, Table  # noqa: E402

# Prints by how many bytes `work` raises the most memory that a process of its own ever had.
GROWTH = """
import numpy as np, tessera as ts
def status(name):
    line, = [line for line in open("/proc/self/status") if line.startswith(name)]
    return int(line.split()[1]) * 1024
small = ts.Scene(nodes=[ts.Mesh(np.zeros((8, 3), "f4"), [(0, 1, 2)])])
small.nodes[0].positions, small.digest  # what is loaded at first use
{prepare}
before = status("VmRSS:")
open("/proc/self/clear_refs", "w").write("5")
kept = {work}
print(status("VmHWM:") - before)
"""
# Four megabytes of vertices and eight of triangles as the renderer has them.
MESH = """
points = np.random.default_rng(1).random((2**20 // 3, 3), "f4")
triangles = np.random.default_rng(2).integers(0, len(points), (2**21 // 3, 3)).astype("u4")
shared = points.copy()
shared.flags.writeable = False
mesh = ts.Mesh(shared, triangles)
wide, long = points.astype("f8"), triangles.astype("i8")
scene = ts.Scene(nodes=[mesh])
"""


def growth(prepare, work):
    shown = subprocess.run([sys.executable, "-c", GROWTH.format(prepare=prepare, work=work)],
                           capture_output=True, text=True)
    assert shown.returncode == 0, shown.stderr
    return int(shown.stdout)


@pytest.mark.parametrize("work, copied", [
    ("ts.Mesh(points, triangles)", 12), ("ts.Mesh(wide, long)", 12),
    ("ts.Mesh(wide, long, recenter=True)", 12), ("ts.Mesh(shared, triangles)", 8),
    ("mesh.positions, mesh.triangles", 0), ("scene.digest", 0)])
def test_a_mesh_is_copied_once_at_most(work, copied):
    found = growth(MESH, work)
    assert (copied - 1) * MIB < found < (copied + 3) * MIB


def test_hits_take_the_memory_of_what_was_asked_for():
    """P6: ten million closest hits."""
    rays = 10**7
    prepare = f"""
tracer = ts.Scene(nodes=[ts.Mesh(np.eye(3), [(0, 1, 2)])]).tracer()
origins = np.zeros(({rays}, 3))
origins[:, :] = np.random.default_rng(1).random(3) - 1
directions = np.ones(({rays}, 3))
"""
    found = growth(prepare, 'tracer.intersect(origins, directions, fields=("t", "primitive"))')
    results = rays * (8 + 4)
    assert results - MIB < found <= results + 32 * MIB


def test_light_of_a_picture_is_a_view():
    values = "image = ts.Image.from_array(np.ones((2160, 3840, 3), 'f4'))"
    assert growth(values, "[image.linear for _ in range(100)]") < 4 * MIB


def test_a_change_sends_what_changed_alone():
    random = np.random.default_rng(1)
    material = ts.Classic(diffuse="red")
    scene = ts.Scene(width=32, height=32)
    scene.add(ts.Mesh(random.random((30_000, 3), "f4"), random.integers(0, 30_000, (10_000, 3))),
              material=material)
    scene.add(ts.DirectionalLight((0, 0, -1)))
    with ts.LocalFarm(1) as farm:
        sent = [scene.render(farm=farm).stats["bytes"]["scene"]]
        material.diffuse = ts.color("blue")
        sent.append(scene.render(farm=farm).stats["bytes"]["scene"])
        sent.append(scene.render(farm=farm).stats["bytes"]["scene"])
    assert sent[0] > 10_000 * 12  # positions are many enough to be mapped
    assert 0 < sent[1] < 10_000
    assert sent[2] == 0


def bench(folder, *arguments):
    """The rows of a benchmark with tiny sizes, which are those that it prints."""
    rows = folder / "rows.json"
    done = subprocess.run([sys.executable, "-B", *map(str, arguments), "--tiny", "--rounds", "1",
                           "--json", str(rows)], capture_output=True, text=True,
                          env={**os.environ, "TMPDIR": "/tmp"})
    assert done.returncode == 0, done.stderr
    names = [row["row"] for row in json.loads(rows.read_text())["rows"]]
    assert all(f"{name} " in done.stdout for name in names)
    return names


def test_the_benchmark_of_speed_runs(tmp_path):
    names = bench(tmp_path, BENCH / "python_speed.py")
    assert {name.split()[0] for name in names} >= {f"P{i}" for i in (1, 2, 3, 4, 7, 8, 9, 10)}
    assert len(names) >= 17


def test_the_benchmark_of_rays_runs(tmp_path):
    names = bench(tmp_path, BENCH / "python_rays.py", BUILD)
    for scene in ("room", "soup"):
        for kind in ("primary", "diffuse", "ao", "shuffled"):
            assert f"P5 {scene}, {kind}" in names
    for other in ("the loop of tessera bench rays", "one thread, by two", "mathutils.bvhtree"):
        assert f"P5 of {other}: least" in names


def test_the_benchmark_of_winding_numbers_runs(tmp_path):
    """A cube that is whole, one that lacks a triangle, and one that lacks two sides."""
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [(side[0], *side[i:i + 2]) for side in sides for i in (1, 2)]
    for name, kept in (("whole", triangles), ("hole", triangles[1:]), ("open", triangles[4:])):
        lines = ["v {} {} {}".format(*corner) for corner in np.ndindex(2, 2, 2)]
        lines += ["f {} {} {}".format(*(corner + 1 for corner in triangle)) for triangle in kept]
        (tmp_path / f"{name}.obj").write_text("\n".join(lines))
    done = subprocess.run([sys.executable, "-B", BENCH / "winding_holes.py", *sorted(tmp_path.glob("*.obj")),
                           "--points", "2000", "--rounds", "1"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "| hole | 11 | 3 | 1 | 100.000% | 100.000% |" in done.stdout
    assert "of 1 meshes " in done.stdout
    assert "left out whole: it is closed" in done.stdout
    assert "left out open: the fans' area is 50% of the triangles'" in done.stdout


@pytest.mark.parametrize("value, limit, is_missed", [
    (1.14, {"at_most": 1}, False), (1.16, {"at_most": 1}, True), (.86, {"at_least": 1}, False),
    (.84, {"at_least": 1}, True), (float("nan"), {"at_least": 1}, True), (9, {}, False)])
def test_a_missed_limit_is_an_error(value, limit, is_missed, capsys):
    class Options:
        json, check = None, True
    assert SLACK == .15
    table = Table()
    table.add("row", value, "", **limit)
    assert ("MISSED" in capsys.readouterr().out) == is_missed
    if is_missed:
        with pytest.raises(SystemExit, match="row"):
            table.finish(Options)
    else:
        table.finish(Options)
    Options.check = False
    table.finish(Options)
