"""Renders that go on by themselves, and who traces them."""
import asyncio
import contextlib
import io
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest
from processes import workers

import tessera as ts

SAMPLES = pathlib.Path(__file__).parents[2] / "scenes" / "samples"
KNOT = SAMPLES / "knot.tessera"
SMALL = {"size": (60, 40)}


@pytest.fixture(scope="module")
def threads():
    with ts.Threads(2) as farm:
        yield farm


@pytest.fixture(scope="module")
def expected(threads):
    return ts.render(KNOT, farm=threads, **SMALL)


def endless(threads):
    """A render that nobody waits for."""
    return ts.render(KNOT, farm=threads, spp=64, size=(4000, 3000), wait=False)


def test_a_task_has_the_picture_of_a_render(threads, expected):
    task = ts.render(KNOT, farm=threads, wait=False, **SMALL)
    assert task.result() == expected
    assert task.done() and task.progress.done == task.progress.total > 0


def test_a_task_can_be_awaited_and_gathered(threads, expected):
    async def both():
        tasks = [ts.render(KNOT, farm=threads, wait=False, **SMALL) for _ in range(2)]
        return await asyncio.gather(*tasks)

    assert asyncio.run(both()) == [expected, expected]


def test_its_time_goes_on_until_it_ends(threads):
    task = ts.render(KNOT, farm=threads, wait=False, **SMALL)
    began = task.progress.elapsed
    image = task.result()
    seconds = image.stats["seconds"]
    assert task.progress.elapsed >= max(began, seconds["total"] - seconds["parse"])
    assert task.progress.elapsed == task.progress.elapsed


def test_progress_may_be_awaited():
    async def watched():
        with ts.Scene(nodes=[ts.Sphere()], background=1).render(size=(64, 36), workers=0, wait=False) as task:
            return [progress async for progress in task], task.done()

    told, is_done = asyncio.run(watched())
    assert is_done and told[-1].done == told[-1].total > 0 and len(set(told)) >= len(told) - 1


def test_cancelling_what_awaits_it_cancels_the_job(threads):
    async def cancelled():
        task = endless(threads)
        waiting = asyncio.ensure_future(task._wait_async())
        await asyncio.sleep(.1)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        with pytest.raises(ts.Cancelled):
            task.result(10)

    asyncio.run(cancelled())


def test_cancel_keeps_what_was_done(threads):
    task = ts.render(KNOT, farm=threads, size=(800, 600), spp=64, wait=False)
    for progress in task:
        if progress.done > 3:
            task.cancel()
    with pytest.raises(ts.Cancelled) as caught:
        task.result(10)
    assert caught.value.code == 4 and caught.value.image.linear.any()


def test_cancelling_while_it_is_denoised_keeps_what_was_traced(threads):
    options = dict(size=(600, 450), spp=2, farm=threads)

    def cancels(progress):
        if progress.waiting_for == "the denoiser":
            task.cancel()

    task = ts.render(KNOT, denoise=True, wait=False, progress=cancels, **options)
    with pytest.raises(ts.Cancelled) as caught:
        task.result()
    assert caught.value.image == ts.render(KNOT, **options)


@pytest.mark.parametrize("own", [True, False])
def test_ctrl_c_while_it_is_iterated_cancels_it(threads, own):
    task = ts.render(KNOT, size=(4000, 3000), spp=64, wait=False, **({"workers": 0} if own else {"farm": threads}))

    def interrupt():
        while task.progress.done == 0 and not task.done():
            time.sleep(.01)
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Thread(target=interrupt).start()
        with pytest.raises(KeyboardInterrupt):
            for _ in task:
                pass
        assert task.done()
    finally:
        signal.signal(signal.SIGINT, before)


def test_who_leaves_the_loop_over_it_leaves_it_running(threads):
    with endless(threads) as task:
        for _ in task:
            break
        assert not task.done()


def test_a_picture_that_waits_for_another_of_its_farm_is_cancelled_at_once(threads, expected):
    with endless(threads):
        waiting = ts.render(KNOT, farm=threads, wait=False, **SMALL)
        assert waiting.progress.waiting_for == "another picture of the same farm"
        waiting.cancel()
        assert waiting.done()
        with pytest.raises(ts.Cancelled) as caught:
            waiting.result()
        assert caught.value.image is None
        with ts.render(KNOT, farm=threads, wait=False, **SMALL) as left:
            pass
        assert left.done()
    assert ts.render(KNOT, farm=threads, **SMALL) == expected


def test_a_picture_that_nobody_can_have_is_not_rendered(threads, expected):
    endless(threads)
    with pytest.raises(TimeoutError):
        endless(threads).result(timeout=.1)
    assert ts.render(KNOT, farm=threads, **SMALL) == expected


def test_a_block_that_is_left_cancels_it(threads):
    with endless(threads) as task:
        assert not task.done()
    assert task.done()


def test_a_script_that_shows_a_task_gets_its_picture_alone(threads, expected, capsys):
    import IPython  # imported, but not running
    assert IPython.get_ipython() is None
    task = ts.render(KNOT, farm=threads, wait=False, **SMALL)
    assert task.show() is None and task.result(timeout=0) == expected
    assert capsys.readouterr().out == ""


def test_a_timeout_leaves_it_running(threads, expected):
    with endless(threads) as task:
        with pytest.raises(TimeoutError, match="not done after 0.05 s"):
            task.result(.05)
        assert not task.done()
    assert ts.render(KNOT, farm=threads, **SMALL) == expected


def test_a_snapshot_has_the_pixels_that_are_done(threads):
    tiles = []
    task = ts.render(KNOT, farm=threads, size=(200, 200), spp=16, wait=False)
    for _ in task:
        picture = task.snapshot()
        if picture is not None:
            tiles.append(np.count_nonzero(picture.linear.any(axis=2)))
    whole = task.result()
    assert tiles and tiles == sorted(tiles)
    assert task.snapshot() == whole


def test_on_tile_is_told_each_tile_once(threads):
    seen = np.zeros((90, 130), int)

    def on_tile(rect, so_far):
        seen[rect.y0:rect.y1, rect.x0:rect.x1] += 1
        assert so_far.width == 130

    ts.render(KNOT, farm=threads, size=(130, 90), on_tile=on_tile)
    assert (seen == 1).all()


@pytest.mark.parametrize("workers", [0, 1])
def test_a_scene_that_fails_has_no_tiles_to_tell(workers):
    scene = ts.Scene(width=64, height=64)
    scene.add(ts.Sphere((0, 0, 0), 1), material=ts.Classic(shininess=-1))
    told = []
    with pytest.raises(ts.SceneError, match="shininess"):
        ts.render(scene, workers=workers, on_tile=lambda *each: told.append(each))
    assert not told


def test_tasks_that_fail_give_back_the_arrays_of_their_scene(script, tmp_path):
    # The farm's thread lets go of tasks that nobody else has, while others are submitted.
    assert script(f"""
import signal, sys, time, numpy as np, tessera as ts
signal.alarm(100)
positions, triangles = np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], dtype=np.uint32)
for array in (positions, triangles):
    array.flags.writeable = False
def render():
    scene = ts.Scene(width=8, height=8)
    scene.add(ts.Mesh(positions, triangles))
    return ts.render(scene, farm=farm, resume={str(tmp_path / "missing" / "a.png")!r}, wait=False)
with ts.Threads(1) as farm:
    for _ in range(3000):
        task = render()
    core = task._task
    del task  # which has the scene
    while not core.wait(1):
        pass
    while sys.getrefcount(positions) > 2:  # the thread lets go of the last one after it is done
        time.sleep(.001)
    print("given back")
""") == "given back"


@pytest.mark.parametrize("which", ["progress", "on_tile"])
def test_an_exception_in_a_callback_cancels_the_render(threads, expected, which):
    def fails(*_):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        ts.render(KNOT, farm=threads, size=(4000, 3000), spp=64, **{which: fails})
    assert ts.render(KNOT, farm=threads, **SMALL) == expected


def awaited(task):
    async def wait():
        return await task

    return asyncio.run(wait())


@pytest.mark.parametrize("wait", [ts.Task.result, ts.Task.show, awaited])
def test_callbacks_of_a_task_are_called_by_who_waits_for_it(threads, wait):
    seen, told, callers = np.zeros((90, 130), int), [], set()

    def on_tile(rect, so_far):
        seen[rect.y0:rect.y1, rect.x0:rect.x1] += 1
        callers.add(threading.get_ident())

    task = ts.render(KNOT, farm=threads, size=(130, 90), progress=told.append, on_tile=on_tile, wait=False)
    while not task.done():
        pass
    assert not told and not seen.any()
    image = wait(task)
    assert (seen == 1).all() and callers == {threading.get_ident()}
    assert told[-1].done == told[-1].total > 0
    calls = len(told)
    assert image in (None, task.result()) and len(told) == calls  # show() returns nothing


@pytest.mark.parametrize("which", ["progress", "on_tile"])
@pytest.mark.parametrize("wait", [ts.Task.result, awaited])
def test_an_exception_in_a_callback_of_a_task_cancels_it(threads, which, wait):
    def fails(*_):
        raise TimeoutError("mine")

    task = ts.render(KNOT, farm=threads, size=(4000, 3000), spp=64, wait=False, **{which: fails})
    with pytest.raises(TimeoutError, match="mine"):
        wait(task)
    with pytest.raises(ts.Cancelled) as cancelled:
        task.result(20)
    # Nobody wants what was done, and so nobody waits until it is a picture.
    assert wait is awaited or cancelled.value.image is None


@pytest.mark.parametrize("wait", [True, False])
@pytest.mark.parametrize("wrong, message", [
    ({"progress": 3}, "progress: 3; expected True, a function or a bar like tqdm's"),
    ({"on_tile": "x"}, "on_tile: 'x'; expected a function of a Rect and an Image")])
def test_what_is_no_callback_is_told_at_the_call(threads, wrong, message, wait):
    with pytest.raises(TypeError) as told:
        ts.render(KNOT, farm=threads, wait=wait, **SMALL, **wrong)
    assert str(told.value) == message


def test_progress_is_told_to_a_function_and_to_a_bar(threads):
    told = []
    ts.render(KNOT, farm=threads, progress=told.append, **SMALL)
    assert told[-1].done == told[-1].total > 0
    from tqdm import tqdm
    with tqdm(file=io.StringIO()) as bar:
        ts.render(KNOT, farm=threads, progress=bar, **SMALL)
        assert bar.n == bar.total == told[-1].total
    ts.render(KNOT, farm=threads, progress=True, **SMALL)
    with pytest.raises(TypeError, match="expected True, a function or a bar"):
        ts.render(KNOT, farm=threads, progress=3, **SMALL)


def test_a_bar_of_ours_ends_full_and_with_its_line(threads):
    told = io.StringIO()
    with contextlib.redirect_stderr(told):
        image = ts.render(KNOT, farm=threads, progress=True, size=(20, 10))
    count = image.stats["tiles"]["total"]
    assert f"{count}/{count}" in told.getvalue().split("\r")[-1] and told.getvalue().endswith("\n")


@pytest.mark.parametrize("missing, shown", [(["tqdm"], "tiles"), (["tqdm", "rich"], "")])
def test_without_tqdm_rich_shows_progress_and_else_a_terminal_text(script, missing, shown):
    pytest.importorskip("rich", reason="rich is not installed, whose progress bar is tested")
    assert script(f"""
import contextlib, io, sys
import tessera as ts
for name in {missing!r}:
    sys.modules[name] = sys.modules[name + ".auto"] = sys.modules[name + ".progress"] = None
told = io.StringIO()
with contextlib.redirect_stderr(told):
    ts.render({str(KNOT)!r}, size=(20, 10), workers=0, progress=True)
print({shown!r} in told.getvalue(), bool(told.getvalue()))
""") == f"True {bool(shown)}"


def test_a_closed_farm_is_told(expected):
    farm = ts.Threads(1)
    assert ts.render(KNOT, farm=farm, **SMALL) == expected
    farm.close()
    farm.close()
    with pytest.raises(RuntimeError, match="closed"):
        ts.render(KNOT, farm=farm, **SMALL)


def test_closing_a_farm_cancels_its_tasks():
    farm = ts.Threads(1)
    task = endless(farm)
    farm.close()
    with pytest.raises(ts.Cancelled):
        task.result(10)


def test_a_farm_that_is_forgotten_warns():
    farm = ts.Threads(1)
    with pytest.warns(ResourceWarning, match="not closed"):
        del farm


def test_several_threads_share_a_farm(threads, expected):
    got = []
    callers = [threading.Thread(target=lambda: got.append(ts.render(KNOT, farm=threads, **SMALL)))
               for _ in range(6)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert got == [expected] * 6


def test_worker_processes_are_kept(expected):
    with ts.LocalFarm(2) as farm:
        first = ts.render(KNOT, farm=farm, **SMALL)
        second = ts.render(KNOT, farm=farm, **SMALL)
    assert first == second == expected
    assert first.stats["bytes"]["scene"] > 10_000 > second.stats["bytes"]["scene"]


@pytest.mark.parametrize("wrong, message", [
    ({"spp": 0}, "spp: 0; expected a whole number"),
    ({"min_spp": 4}, "min_spp: is for target_error"),
    ({"accel": "bvj"}, "did you mean 'bvh'"),
    ({"crop": (0, 0, 2000, 1)}, "crop: 0,0,2000,1; expected a part of the frame, 0,0,960,540"),
    ({"frame": 1, "time": 2.}, "time: a frame has its own instant"),
    ({"workers": -1}, "workers: -1; expected a whole number from 0 to 1024"),
    ({"threads": 0}, "threads: 0; expected a whole number from 1 to 1024"),
    ({"verify": 2.}, "verify: '2.0'; expected a share"),
    ({"verify": .5, "workers": 0}, "verify: needs a second worker"),
    ({"verify": .5, "workers": 1}, "verify: needs a second worker"),
    ({"camera": "nobody"}, "camera: 'nobody' is not in the scene"),
    ({"size": (0, 1)}, "size: 0x1; expected sides from 1"),
])
def test_wrong_keywords_are_named_as_python_has_them(wrong, message):
    with pytest.raises(ts.UsageError) as caught:
        ts.render(KNOT, **wrong)
    assert message in str(caught.value) and "--" not in str(caught.value)
    assert isinstance(caught.value, ValueError) and caught.value.code == 2


def test_an_unknown_keyword_is_a_type_error():
    with pytest.raises(TypeError, match="render.. has no keyword 'sppp'; did you mean 'spp'"):
        ts.render(KNOT, sppp=3)


def test_pictures_that_are_hardly_meant_are_told(threads):
    dark = ts.Scene(width=8, height=8)
    dark.add(ts.Sphere((0, 0, 0), 1))
    with pytest.warns(ts.SceneWarning, match="the picture will be black"):
        ts.render(dark, farm=threads)
    glaring = ts.Scene(width=8, height=8)
    glaring.add(ts.Sphere((0, 0, 0), 1), material=ts.Classic(diffuse=(3e38,) * 3))
    glaring.add(ts.PointLight((0, 0, 9), intensity=3e38))
    with pytest.warns(ts.SceneWarning, match="no colour that a pixel can hold"):
        ts.render(glaring, farm=threads)


def test_a_missing_file_is_told():
    with pytest.raises(FileNotFoundError) as caught:
        ts.render("nowhere.tessera", workers=0)
    assert isinstance(caught.value, ts.SceneError) and "nowhere.tessera" in str(caught.value)


def test_nothing_is_printed_or_warned(capfd, expected):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ts.render(KNOT, workers=0, **SMALL) == expected
    assert capfd.readouterr() == ("", "")


def test_a_kept_farm_replaces_workers_while_it_is_idle():
    with ts.LocalFarm(1) as farm:
        ts.render(KNOT, size=(8, 8), spp=1, farm=farm)
        before, = workers()
        os.kill(before, signal.SIGKILL)
        end = time.monotonic() + 60
        while not set(workers()) - {before}:
            assert time.monotonic() < end
            time.sleep(.02)


def test_a_bar_of_the_caller_shows_each_render(threads):
    class Bar:
        total = n = 0
        shown = []

        def update(self, n):
            self.n += n
            self.shown.append(self.n)

        def refresh(self):
            pass

        close = refresh

    bar = Bar()
    for _ in range(2):
        ts.render(KNOT, farm=threads, size=(60, 40), tile=20, spp=1, progress=bar)
    assert bar.shown.count(6) == 2


@pytest.mark.parametrize("made", [ts.Threads, ts.LocalFarm, ts.Farm])
def test_a_farm_that_was_not_set_up_says_so(made):
    class Own(made):
        def __init__(self):
            pass

    for use in (lambda farm: farm.close(), lambda farm: ts.render(KNOT, farm=farm)):
        with pytest.raises(AttributeError, match="is not set; expected Own.__init__ to call super"):
            use(Own())


def test_several_wait_for_one_task(threads):
    task = ts.render(KNOT, farm=threads, size=(120, 80), tile=16, wait=False, on_tile=lambda *_: time.sleep(.005))
    pictures = []
    waiting = [threading.Thread(target=lambda: pictures.append(task.result())) for _ in range(4)]
    for thread in waiting:
        thread.start()
    for thread in waiting:
        thread.join()
    assert len(pictures) == 4 and all(picture == pictures[0] for picture in pictures)


@pytest.mark.parametrize("left, warnings", [
    ("farm = ts.Threads(1)", 1), ("farms = [ts.Threads(1), ts.Threads(2)]", 2),
    ("farm = ts.Threads(1); farm.close()", 0), ("ts.Threads(1).close()", 0),
    ("task = ts.Scene(nodes=[ts.Sphere()], background=1).render(workers=0, wait=False)", 0)])
def test_a_farm_that_is_open_when_the_script_ends_is_told_once(left, warnings):
    code = f"import sys, tessera as ts\n{left}\nsys.exit(3)"
    done = subprocess.run([sys.executable, "-B", "-W", "always::ResourceWarning", "-c", code], capture_output=True,
                          text=True, timeout=60)
    assert done.returncode == 3
    assert done.stderr.count(") was not closed") == warnings, done.stderr
