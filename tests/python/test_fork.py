"""Fork and spawn: what works in the child, and what says whose it is."""
import multiprocessing
import os
import pathlib

import pytest

import tessera as ts

KNOT = str(pathlib.Path(__file__).parents[2] / "scenes" / "samples" / "knot.tessera")


def in_child(work):
    """What `work` returns in a forked child, as text."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            text = str(work())
        except BaseException as error:
            text = f"{type(error).__name__}: {error}"
        os.write(writing, text.encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        text = pipe.read()
    assert os.waitpid(child, 0)[1] == 0
    return text


def test_after_fork_farms_and_tasks_say_whose_they_are():
    with ts.Threads(1) as farm:
        task = ts.render(KNOT, size=(8, 8), farm=farm, wait=False)
        expected = task.result()
        told = f"made in process {os.getpid()}"
        assert told in in_child(lambda: ts.render(KNOT, size=(8, 8), farm=farm))
        assert told in in_child(task.result)
        assert told in in_child(task.done)
        assert told in in_child(task.__enter__)
        # What has no thread works in the child, and so does a farm of its own.
        assert in_child(lambda: expected.linear.sum()) == str(expected.linear.sum())
        fresh = "ts.render(KNOT, size=(8, 8), workers=0).sha256"
        assert in_child(lambda: eval(fresh)) == expected.sha256
        assert in_child(farm.close) == "None"
        assert ts.render(KNOT, size=(8, 8), farm=farm) == expected


@pytest.mark.parametrize("how", ["farm.close()", "del farm", "pass"])
def test_a_forked_child_leaves_the_farms_of_its_parent_alone(script, how):
    assert script(f"""
import os, signal, tessera as ts
farm = ts.Farm("tcp://127.0.0.1:9")
child = os.fork()
if child == 0:
    signal.alarm(20)
    {how}
    raise SystemExit
print(os.waitpid(child, 0)[1])
farm.close()
""") == "0"


def test_a_forked_child_leaves_the_block_of_its_parents_task(script):
    assert script(f"""
import os, signal, tessera as ts
with ts.render({KNOT!r}, size=(2000, 1000), spp=64, workers=0, wait=False) as task:
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        assert repr(task) == f"<Task of process {{os.getppid()}}>"
        raise SystemExit
    print(os.waitpid(child, 0)[1], task.done())
""") == "0 False"


def rendered(size):
    return ts.render(KNOT, size=size, workers=0).sha256


def test_spawned_processes_render():
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert len(set(pool.map(rendered, [(8, 8)] * 2))) == 1


@pytest.mark.parametrize("way, status", [("raise SystemExit(3)", 3), ("raise ValueError", 1), ("pass", 1)])
def test_a_child_that_a_callback_forks_ends(script, way, status):
    assert script(f"""
import os, signal, tessera as ts
child = None
def fork(tile, picture):
    global child
    if child is None:
        child = os.fork()
        if child == 0:
            signal.alarm(60)
            {way}
ts.render("{KNOT}", size=(200, 150), spp=4, tile=16, workers=0, threads=1, on_tile=fork)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
""") == str(status)
