"""Nothing stays of what was rendered, traced and cancelled."""
import gc
import os
import pathlib
import tempfile

import numpy as np
import pytest

import tessera as ts

KNOT = str(pathlib.Path(__file__).parents[2] / "scenes" / "samples" / "knot.tessera")
REPEATS = 500
SETTLED = 50
MOST_GROWTH = 5 << 20


def resident(process="self"):
    """Bytes of a process in memory."""
    return int(pathlib.Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def children():
    """The processes that were started."""
    tasks = pathlib.Path("/proc/self/task").iterdir()
    return sorted(child for task in tasks for child in (task / "children").read_text().split())


def held():
    """What a process may forget to give back: descriptors, threads, children, temporary files."""
    return (len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task")), children(),
            os.listdir(os.environ["TMPDIR"]))


@pytest.fixture(autouse=True)
def temporary_folder(monkeypatch):
    """One of this test alone, with a path that is short enough for sockets."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("TMPDIR", folder)
        yield


def small_scene():
    scene = ts.Scene(width=8, height=8)
    scene.add(ts.Sphere((0, 0, 0), 1), material=ts.Classic(diffuse="red"))
    scene.add(ts.Mesh(np.eye(3, dtype=np.float32), [[0, 1, 2]]), ts.PointLight((0, 3, 3)))
    return scene


def render(farm):
    return small_scene().render(farm=farm).to_srgb()


def trace(_):
    hits = small_scene().tracer(threads=1).intersect(np.zeros((100, 3)), np.ones((100, 3)))
    return hits.point


def cancel(farm):
    task = ts.render(KNOT, size=(2000, 2000), spp=64, farm=farm, wait=False)
    task.cancel()
    with pytest.raises(ts.Cancelled):
        task.result()


@pytest.mark.parametrize("work", [render, trace, cancel])
def test_memory_and_descriptors_are_given_back(work):
    before = held()
    with ts.Threads(1) as farm:
        for i in range(REPEATS):
            work(farm)
            if i == SETTLED:
                gc.collect()
                settled = resident()
    gc.collect()
    assert resident() - settled <= MOST_GROWTH
    assert held() == before


@pytest.mark.parametrize("work", [render, cancel])
def test_memory_is_given_back_by_workers_too(work):
    before = held()
    with ts.LocalFarm(1) as farm:
        for i in range(REPEATS):
            work(farm)
            if i == SETTLED:
                gc.collect()
                started = children()
                settled = [resident(process) for process in ("self", *started)]
        gc.collect()
        assert started and children() == started
        for process, then in zip(("self", *started), settled):
            assert resident(process) - then <= MOST_GROWTH
    assert held() == before


def test_farms_of_processes_leave_nothing():
    ts.render(KNOT, size=(8, 8), workers=2)
    before = held()
    for _ in range(20):
        ts.render(KNOT, size=(8, 8), workers=2)
    gc.collect()
    assert held() == before
