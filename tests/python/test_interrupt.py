"""Ctrl-C and the end of the interpreter."""
import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time

import pytest
from processes import children, workers

import tessera as ts

KNOT = str(pathlib.Path(__file__).parents[2] / "scenes" / "samples" / "knot.tessera")
ENDLESS = "size=(4000, 3000), spp=64"  # minutes, in many small tiles


def wait_until(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(.01)


def next_line(process):
    """One line and not a byte more: communicate() reads what is left in the pipe itself."""
    line = b""
    while not line.endswith(b"\n"):
        byte = os.read(process.stdout.fileno(), 1)
        assert byte, f"it ended: {process.stderr.read()}"
        line += byte
    return line.decode()


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
        assert next_line(process) == "begins\n"
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
    "scene.digest", "scene.save('/dev/null/none.tesserab')", "scene.info()", "scene.tracer()",
    "scene.to_dict()", "pickle.dumps(scene)"])
def test_ctrl_c_while_a_large_scene_is_read(started, call):
    process = started(f"""
import pickle, signal
import tessera as ts
node = ts.Node()
scene = ts.Scene(width=8, height=8, nodes=[ts.Node(children=[node] * 1000) for _ in range(1000)])
if "pickle" in {call!r}:  # it stores a node once, however often it is listed
    scene = ts.Scene(nodes=[ts.Node() for _ in range(100_000)])
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


READS_MUCH = """
import os, signal
import tessera as ts
signal.signal(signal.SIGALRM, signal.default_int_handler)
with open({file!r}, "w") as file:
    for i in range({nodes}):
        file.write("nodes {{ transform {{ steps {{ translate {{ x: %d }} }} }} shape {{ sphere {{}} }} }}\\n" % i)
print("begins", flush=True)
before = len(os.listdir("/proc/self/task"))
signal.setitimer(signal.ITIMER_REAL, .05)
try:
    ts.load({file!r})
    print("ended")
except KeyboardInterrupt:
    print("interrupted", len(os.listdir("/proc/self/task")) - before, flush=True)
"""


def test_ctrl_c_while_a_large_file_is_read_is_raised_though_reading_goes_on(folder, started):
    process = started(READS_MUCH.format(file=str(folder / "much.tessera"), nodes=50_000) + f"""
print(ts.load({KNOT!r}).digest)
""")
    out, err = process.communicate(timeout=60)
    assert (out.split(), err) == (["interrupted", "1", ts.load(KNOT).digest], "")


def test_the_interpreter_ends_though_reading_goes_on_for_longer_than_it_waits(folder, started):
    process = started(READS_MUCH.format(file=str(folder / "much.tessera"), nodes=600_000) + """
raise SystemExit(7)
""")
    out, err = process.communicate(timeout=60)
    assert (out.split(), err, process.returncode) == (["interrupted", "1"], "", 7)


def test_arrays_shared_with_abandoned_work_live_as_long_as_that(started):
    process = started("""
import gc, signal
import numpy as np
import tessera as ts
signal.signal(signal.SIGALRM, signal.default_int_handler)
n = 1000
corner = np.arange(n * n).reshape(n, n)
triangles = np.concatenate([np.stack(each, -1).reshape(-1, 3) for each in (
    (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:]), (corner[:-1, :-1], corner[1:, 1:], corner[:-1, 1:]))])
positions = np.stack([*np.meshgrid(np.arange(n), np.arange(n)), np.random.rand(n, n)], -1)
positions = positions.reshape(-1, 3).astype("f4")
positions.flags.writeable = False
mesh = ts.Mesh(positions, triangles)
assert np.shares_memory(np.asarray(mesh.positions), positions)
print("begins", flush=True)
signal.setitimer(signal.ITIMER_REAL, .05)
try:
    ts.Scene(nodes=[mesh]).tracer()
    print("ended")
except KeyboardInterrupt:
    print("interrupted", flush=True)
del mesh, positions, triangles, corner
gc.collect()
waste = [np.random.rand(3 * n * n) for _ in range(10)]
""")
    out, err = process.communicate(timeout=60)
    assert (out.strip(), err, process.returncode) == ("interrupted", "", 0)


def test_ctrl_c_while_a_dict_is_made(script):
    assert script("""
import json, signal, time
import tessera as ts
from tessera import _core
scene = ts.Scene(nodes=[ts.Sphere(radius=i + 1) for i in range(100_000)])
text = _core.to_json(scene)
begin = time.monotonic()
json.loads(text)
whole = time.monotonic() - begin
def interrupt(*_):
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, interrupt)
def text_at_once(_):
    signal.setitimer(signal.ITIMER_REAL, whole / 10)
    return text
_core.to_json = text_at_once
begin = time.monotonic()
try:
    scene.to_dict()
except KeyboardInterrupt:
    print(time.monotonic() - begin < whole * .7)
""") == "True"


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
    assert next_line(process) == "interrupted\n"
    assert not [p for p in folder.iterdir() if p.name.startswith("tessera-farm")]
    assert not workers(process.pid)
    process.communicate("\n", timeout=20)
    assert process.returncode == 0


@pytest.mark.parametrize("call", ["image.sha256", "image.to_srgb()", "image.save(file)", "image._repr_png_()",
                                  "ts.compare(image, image)", "ts._core.blob_digest(array)"])
def test_ctrl_c_while_a_large_picture_is_worked_on_is_raised_though_work_goes_on(started, folder, call):
    process = started(f"""
import os, signal, time
import numpy as np
import tessera as ts
signal.signal(signal.SIGALRM, signal.default_int_handler)
before = len(os.listdir("/proc/self/task"))
image = ts.Image.from_array(np.random.default_rng(1).random((4000, 2000, 3), "f4"))
file = {str(folder / "out.png")!r}
array = ts.Array.from_bytes(bytes(100_000_000), "f", [25_000_000])
while len(os.listdir("/proc/self/task")) > before: time.sleep(.01)  # those that made them end
print("begins", flush=True)
signal.setitimer(signal.ITIMER_REAL, .005)
try:
    {call}
    print("ended")
except KeyboardInterrupt:
    print("interrupted", len(os.listdir("/proc/self/task")) > before, os.path.exists(file))
""")
    out, err = process.communicate(timeout=60)
    assert (out.split(), err) == (["interrupted", "True", "False"], "")


@pytest.mark.parametrize("call", ["image.to_srgb()", "ts.Image.from_array(codes)",
                                  "image.apply(lambda light: light)", "ts.Instances('ball', matrices)"])
def test_other_threads_run_while_a_picture_is_worked_on(script, call):
    assert script(f"""
import sys, threading, time
import numpy as np
import tessera as ts
codes = np.random.default_rng(1).integers(0, 256, (1000, 1000, 3), "u1")
image = ts.Image.from_array(codes)
matrices = np.tile(np.eye(4)[:3], (300_000, 1, 1))
turns = 0
def take_turns():
    global turns
    while True:
        turns += 1
        time.sleep(0)
threading.Thread(target=take_turns, daemon=True).start()
sys.setswitchinterval(1e-6)
before = turns
{call}
print(turns - before > 30)
""") == "True"


@pytest.mark.parametrize("call", ["ts.load(file)", "ts.load_dict(described)"])
def test_other_threads_run_between_parts_of_a_scene_that_are_made(script, tmp_path, call):
    assert script(f"""
import sys, threading, time
import tessera as ts
scene = ts.Scene(nodes=[ts.Sphere(radius=i + 1) for i in range(30_000)])
file = {str(tmp_path / "much.tesserab")!r}
scene.save(file)
described = scene.to_dict()
most = 0  # memory blocks that were taken between two turns of the other thread
def look():
    global most
    before = sys.getallocatedblocks()
    while True:
        time.sleep(0)
        now = sys.getallocatedblocks()
        most = max(most, now - before)
        before = now
threading.Thread(target=look, daemon=True).start()
sys.setswitchinterval(1e-6)
made = {call}
time.sleep(.1)
print(len(made.nodes), most < 60_000 or most)
""") == "30000 True"


def test_no_handler_of_the_users_is_replaced():
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM,
                                                             signal.SIGCHLD, signal.SIGPIPE)}
    ts.render(KNOT, size=(8, 8), workers=1)
    assert before == {number: signal.getsignal(number) for number in before}


def test_a_killed_python_leaves_no_worker_and_its_folder_goes_at_the_next_start(folder, started):
    script = f"""
import tessera as ts
farm = ts.LocalFarm(2)
ts.render({KNOT!r}, size=(8, 8), farm=farm)
print("begins", flush=True)
ts.render({KNOT!r}, {ENDLESS}, farm=farm)
"""
    process = started(script)
    helpers = children(process.pid)
    assert len(helpers) >= 2
    process.kill()
    process.wait()
    wait_until(lambda: not any(os.path.exists(f"/proc/{each}") for each in helpers))
    left = [path.name for path in folder.iterdir() if path.name.startswith("tessera-farm")]
    assert left
    next_one = started(f"""
import os, sys, tessera as ts
with ts.LocalFarm(1) as farm:
    ts.render({KNOT!r}, size=(8, 8), farm=farm)
    print("begins", flush=True)
    sys.stdin.readline()
    print(*os.listdir({str(folder)!r}))
""")
    out, err = next_one.communicate("\n", timeout=60)
    assert err == "" and "tessera-farm" in out and not set(left) & set(out.split())


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


def test_a_render_that_fails_has_what_was_done_of_its_picture():
    with ts.LocalFarm(1) as farm:
        task = ts.render(KNOT, size=(2000, 1500), spp=64, tile=64, farm=farm, wait=False)
        wait_until(lambda: task.progress.done > 0, 60)
        while not task.done():
            for worker in workers():
                with contextlib.suppress(ProcessLookupError):
                    os.kill(worker, signal.SIGSEGV)
            time.sleep(.02)
        with pytest.raises(ts.RenderError) as told:
            task.result()
    error = told.value
    assert error.image.linear.shape == (1500, 2000, 3) and error.image.holes
    assert error.stats["tiles"]["done"] > 0 and error.stats["workers"]["lost"] > 0


def test_workers_do_not_die_with_the_thread_that_made_the_farm():
    def make():
        farms.append(ts.LocalFarm(2))
        may_end.wait()

    farms, may_end = [], threading.Event()
    maker = threading.Thread(target=make)
    maker.start()
    wait_until(lambda: farms and len(workers()) == 2)
    with farms[0] as farm:
        first = ts.render(KNOT, size=(40, 30), farm=farm)
        before = workers()
        may_end.set()
        maker.join()
        second = ts.render(KNOT, size=(40, 30), farm=farm)
        # Dead ones would have been replaced by others.
        assert first == second and workers() == before and len(before) == 2
