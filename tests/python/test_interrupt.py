"""Ctrl-C, fork, spawn and the end of the interpreter."""
import glob
import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time

import pytest

import tessera as ts

KNOT = str(pathlib.Path(__file__).parents[2] / "scenes" / "samples" / "knot.tessera")
ENDLESS = "size=(4000, 3000), spp=64"  # minutes, in many small tiles


def children(pid):
    """The process ids of all that a process started."""
    found = []
    for stat in glob.glob("/proc/[0-9]*/stat"):
        try:
            fields = pathlib.Path(stat).read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid and fields[0] != "Z":
            found.append(int(stat.split("/")[2]))
    return found


def wait_until(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(.01)


@pytest.fixture
def folder():
    with tempfile.TemporaryDirectory(prefix="t", dir="/tmp") as path:
        yield pathlib.Path(path)


# Who runs the tests in the background ignores SIGINT for them, and Python then leaves it so.
HEEDS_CTRL_C = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"


@pytest.fixture
def started(folder):
    """Starts a script that prints a line when it renders; its temporary files lie in the folder."""
    processes = []

    def start(script):
        process = subprocess.Popen([sys.executable, "-c", HEEDS_CTRL_C + script], text=True,
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE,
                                   env={**os.environ, "TMPDIR": str(folder)})
        processes.append(process)
        assert process.stdout.readline() == "begins\n"
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("who", ["workers=2", "workers=0"])
def test_ctrl_c_is_a_plain_keyboard_interrupt(who, folder, started):
    script = f"""
import sys, tessera as ts
def begins(tile, so_far):
    global begun
    if not begun: print("begins", flush=True)
    begun = True
begun = False
try:
    ts.render({KNOT!r}, {ENDLESS}, {who}, on_tile=begins)
except KeyboardInterrupt:
    print("interrupted", flush=True)
print(ts.render({KNOT!r}, size=(8, 8), {who}).sha256)
"""
    process = started(script)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=20)
    expected = ts.render(KNOT, size=(8, 8), workers=0).sha256
    assert out.split() == ["interrupted", expected] and err == ""
    assert not list(folder.iterdir())


@pytest.mark.parametrize("call", [
    "scene.digest", "scene.save('/dev/null/none.tesserab')", "scene.info()", "scene.tracer()"])
def test_ctrl_c_while_a_large_scene_is_read(started, call):
    process = started(f"""
import signal
import tessera as ts
node = ts.Node()
scene = ts.Scene(width=8, height=8, nodes=[ts.Node(children=[node] * 1000) for _ in range(1000)])
count = 0
def handler(*_):
    global count
    count += 1
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, handler)
print("begins", flush=True)
signal.setitimer(signal.ITIMER_REAL, .01)
try:
    {call}
    print("ended")
except KeyboardInterrupt:
    print("interrupted", count)
""")
    out, err = process.communicate(timeout=60)
    assert (out.strip(), err) == ("interrupted 1", "")


def test_ctrl_c_ends_workers_and_folders_before_it_is_raised(folder, started):
    script = f"""
import sys, tessera as ts
begun = False
def begins(tile, so_far):
    global begun
    if not begun: print("begins", flush=True)
    begun = True
try:
    ts.render({KNOT!r}, {ENDLESS}, workers=2, on_tile=begins)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    sys.stdin.readline()
"""
    process = started(script)
    assert len(children(process.pid)) >= 2
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "interrupted\n"
    assert not [p for p in folder.iterdir() if p.name.startswith("tessera-farm")]
    assert not [c for c in children(process.pid)
                if b"worker" in pathlib.Path(f"/proc/{c}/cmdline").read_bytes()]
    process.communicate("\n", timeout=20)
    assert process.returncode == 0


def test_no_handler_of_the_users_is_replaced():
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM,
                                                             signal.SIGCHLD, signal.SIGPIPE)}
    ts.render(KNOT, size=(8, 8), workers=1)
    assert before == {number: signal.getsignal(number) for number in before}


def test_a_killed_python_leaves_no_worker(started):
    script = f"""
import tessera as ts
farm = ts.LocalFarm(2)
ts.render({KNOT!r}, size=(8, 8), farm=farm)
print("begins", flush=True)
ts.render({KNOT!r}, {ENDLESS}, farm=farm)
"""
    process = started(script)
    workers = children(process.pid)
    assert len(workers) >= 2
    process.kill()
    process.wait()
    wait_until(lambda: not any(os.path.exists(f"/proc/{w}") for w in workers))


def test_the_end_of_the_interpreter_closes_farms(folder, started):
    script = f"""
import tessera as ts
farm = ts.LocalFarm(2)
task = ts.render({KNOT!r}, {ENDLESS}, farm=farm, wait=False)
other = ts.render({KNOT!r}, {ENDLESS}, workers=0, wait=False)
print("begins", flush=True)
"""
    process = started(script)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 0 and err == ""
    assert not list(folder.iterdir())


@pytest.mark.parametrize("call", [
    "scene.render(workers=0)", "scene.check()", "scene.digest", "ts.Mesh(points, rows)",
    "tracer.intersect(points[:1000], points[:1000])", "tracer.intersect(points, points)"])
def test_the_interpreter_ends_while_daemon_threads_are_in_our_calls(script, call):
    assert script(f"""
import threading, time
import numpy as np
import tessera as ts
scene = ts.Scene(width=16, height=16, background="red")
for i in range(500): scene.add(ts.Sphere((i, 0, 0), 1, material=ts.Unlit(color="blue")))
tracer, points = scene.tracer(), np.ones((30000, 3))
rows = np.arange(30000).reshape(-1, 3)
def loop():
    while True: {call}
for _ in range(4): threading.Thread(target=loop, daemon=True).start()
time.sleep(.3)
print("ends")
""") == "ends"


def test_workers_do_not_die_with_the_thread_that_made_the_farm():
    farms = []
    maker = threading.Thread(target=lambda: farms.append(ts.LocalFarm(2)))
    maker.start()
    maker.join()
    with farms[0] as farm:
        first = ts.render(KNOT, size=(40, 30), farm=farm)
        time.sleep(.2)
        workers = [c for c in children(os.getpid())
                   if b"worker" in pathlib.Path(f"/proc/{c}/cmdline").read_bytes()]
        second = ts.render(KNOT, size=(40, 30), farm=farm)
        assert first == second and second.stats["workers"]["lost"] == 0 and len(workers) == 2


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


def rendered(size):
    return ts.render(KNOT, size=size, workers=0).sha256


def test_spawned_processes_render():
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert len(set(pool.map(rendered, [(8, 8)] * 2))) == 1
