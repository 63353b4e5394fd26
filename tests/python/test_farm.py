"""A farm elsewhere, with keys and two workers."""
import logging
import os
import pathlib
import pickle
import subprocess
import time

import pytest

import tessera as ts

KNOT = str(pathlib.Path(__file__).parents[2] / "scenes" / "samples" / "knot.tessera")
SIZE = (60, 40)


class Served:
    """A coordinator and two workers, with keys in a folder."""

    def __init__(self, folder):
        self.folder = folder
        self.processes = []
        self.run("keygen", folder / "farm.key")
        lines = [self.run("keygen", folder / f"{name}.key", "--role", role)
                 for name, role in (("node", "worker"), ("alice", "submitter"))]
        self.run("keygen", folder / "stranger.key", "--role", "submitter")
        (folder / "allow").write_text("".join(lines))
        serve = self.start("serve", "--bind", "tcp://127.0.0.1:0", "--key", folder / "farm.key",
                           "--allow", folder / "allow", "--store", folder / "store")
        self.endpoint = serve.stdout.readline().split()[-1]
        assert self.endpoint.startswith("tcp://127.0.0.1:")
        for _ in range(2):
            self.start("worker", "--connect", self.endpoint, "--key", folder / "node.key",
                       "--server-key", folder / "farm.pub", "--threads", "1")

    def run(self, *arguments):
        return subprocess.run([os.environ["TESSERA_PROGRAM"], *map(str, arguments)], check=True,
                              capture_output=True, text=True).stdout

    def start(self, *arguments):
        process = subprocess.Popen([os.environ["TESSERA_PROGRAM"], *map(str, arguments)],
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.processes.append(process)
        return process

    def keys(self, name="alice"):
        return {"key": self.folder / f"{name}.key", "server_key": self.folder / "farm.pub"}

    def farm(self, **options):
        return ts.Farm(self.endpoint, **{**self.keys(), **options})

    def end(self):
        for process in self.processes:
            process.terminate()
        for process in self.processes:
            process.wait()
            process.stdout.close()


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    served = Served(tmp_path_factory.mktemp("farm"))
    try:
        with served.farm() as farm:
            end = time.monotonic() + 30
            while farm.workers() < 2:
                assert time.monotonic() < end
                time.sleep(.05)
        yield served
    finally:
        served.end()


@pytest.fixture(scope="module")
def expected():
    return ts.render(KNOT, size=SIZE, workers=0)


def test_a_render_by_the_farm_has_the_same_bits(served, expected):
    with served.farm() as farm:
        assert ts.render(KNOT, size=SIZE, farm=farm) == expected
        assert ts.load(KNOT).render(size=SIZE, farm=farm) == expected


def test_the_picture_is_shown_while_it_is_traced(served):
    options = {"size": (200, 120), "spp": 64, "tile": 20}
    area, shown = 0, []

    def on_tile(tile, so_far):
        nonlocal area
        area += (tile.x1 - tile.x0) * (tile.y1 - tile.y0)
        shown.append((tile, so_far.linear[tile.y0:tile.y1, tile.x0:tile.x1].copy(), area))

    with served.farm() as farm:
        picture = ts.render(KNOT, farm=farm, on_tile=on_tile, **options)
    assert area == 200 * 120
    assert shown[0][2] < area / 2, "all came at the end"
    for tile, light, _ in shown:
        assert (light == picture.linear[tile.y0:tile.y1, tile.x0:tile.x1]).all()


def test_a_job_shows_what_is_done_of_it(served):
    with served.farm() as farm:
        job = farm.submit(KNOT, size=(200, 120), spp=64, tile=20)
        pictures = []
        while job.status()["state"] != "done":
            pictures.append(job.snapshot())
        final = job.fetch()
        assert (job.snapshot().linear == final.linear).all()
        job.forget()
    some = [picture.linear for picture in pictures if picture is not None]
    partly = [linear for linear in some if (linear != final.linear).any()]
    assert partly
    for linear in partly:
        done = (linear != 0).any(axis=2)
        assert done.any() and (linear[done] == final.linear[done]).all()


def test_a_scene_that_a_farm_is_not_given_has_its_line_in_the_script(served):
    scene = ts.Scene(nodes=[ts.Sphere()], gamma=0)
    with served.farm() as farm, pytest.raises(ts.SceneError) as told:
        farm.submit(scene, size=(8, 8))
    line = test_a_scene_that_a_farm_is_not_given_has_its_line_in_the_script.__code__.co_firstlineno + 1
    assert told.value.place == f"{__file__}:{line}"


def test_a_job_from_its_submission_to_its_picture(served, expected):
    with served.farm() as farm:
        job = farm.submit(KNOT, size=SIZE, name="a knot", priority=3)
        assert job.wait(60)["state"] == "done"
        image = job.fetch()
        assert image == expected and list(job.frames()) == [0]
        assert image.stats["pixels_sha256"] == image.sha256 and image.stats["rays"]["primary"] > 0
        assert image.stats["tiles"]["done"] == image.stats["tiles"]["total"] > 0
        status = job.status()
        assert (status["name"], status["priority"]) == ("a knot", 3)
        assert farm.job("a knot") == job == farm.job(job.number) and job in farm.jobs()
        assert [s["state"] for s in job.watch()] == ["done"]
        assert str(job.number) in job._repr_html_()
        with pytest.raises(ts.UsageError, match="is done; expected one that has not ended"):
            job.cancel()
        job.forget()
        assert job not in farm.jobs()
        with pytest.raises(ts.UsageError, match="no job of the farm, or forgotten"):
            job.status()


def test_an_animation(served):
    with served.farm() as farm:
        job = farm.submit(KNOT, size=(8, 8), frames=range(3, 6))
        job.wait(60)
        assert list(job.frames()) == [3, 4, 5]
        assert job.fetch(4) == ts.render(KNOT, size=(8, 8), frame=4, workers=0)
        with pytest.raises(ts.UsageError, match="frame: 9; expected one of the job, from 3 to 5"):
            job.fetch(9)


@pytest.mark.parametrize("frames, numbers", [("1,5,8-10", [1, 5, 8, 9, 10]), (range(2, 9, 3), [2, 5, 8])])
def test_frames_that_are_no_plain_range(served, frames, numbers):
    with served.farm() as farm:
        assert list(farm.submit(KNOT, size=(8, 8), frames=frames).frames()) == numbers


def test_too_many_frames_are_refused_before_the_scene_is_read(served):
    with served.farm() as farm, pytest.raises(ts.UsageError, match="10001 frames; expected at most 10000 in one job"):
        farm.submit(KNOT, size=(8, 8), frames=(0, 10000))


def test_orders(served):
    with served.farm() as farm:
        job = farm.submit(KNOT, size=(4000, 3000), spp=64)
        job.pause()
        assert job.status()["state"] == "paused"
        with pytest.raises(TimeoutError, match="not done yet"):
            job.fetch()
        with pytest.raises(TimeoutError):
            job.wait(.2)
        job.resume(priority=7)
        status = job.status()
        assert status["state"] in ("queued", "running") and status["priority"] == 7
        with pytest.raises(ts.UsageError, match="priority: 1001; expected a whole number from -1000 to 1000"):
            job.resume(1001)
        job.cancel()
        assert job.wait(30)["state"] == "cancelled"
        job.cancel()  # as on the command line, twice is as good as once
        with pytest.raises(ts.UsageError, match="is cancelled; expected one that failed or is held"):
            job.retry()
        with pytest.raises(ts.UsageError, match="did you mean|no job"):
            farm.job("nothing of that name")


def test_a_cancelled_job_has_no_picture_but_what_is_done(served):
    with served.farm() as farm:
        job = farm.submit(KNOT, size=(400, 300), spp=256, tile=20)
        while job.snapshot() is None:
            time.sleep(.01)
        job.cancel()
        job.wait(30)
        with pytest.raises(ts.Cancelled, match=f"job {job.number} was cancelled") as caught:
            job.fetch()
        assert caught.value.image.holes and caught.value.image.linear.any()
        assert caught.value.stats["tiles"]["done"] > 0
        assert job.snapshot() == caught.value.image
        job.forget()


def test_a_picture_is_denoised_when_it_is_fetched(served):
    options = {"size": SIZE, "spp": 4, "integrator": "path"}
    with served.farm() as farm:
        job = farm.submit(KNOT, aovs=("albedo", "normal", "depth", "variance"), **options)
        plain = farm.submit(KNOT, **options)
        job.wait(60), plain.wait(60)
        smooth = job.fetch(denoise=True)
        expected = ts.render(KNOT, workers=0, denoise=True, **options)
        assert (smooth.linear == expected.linear).all() and (job.fetch().linear != smooth.linear).any()
        with pytest.raises(ts.UsageError, match="denoise: the job lacks"):
            plain.fetch(denoise=True)


def test_what_is_asked_of_a_job_is_checked(served):
    with served.farm() as farm:
        job = farm.submit(KNOT, size=(8, 8), spp=1)
        for wrong in (None, True, 1.5, job):
            with pytest.raises(TypeError, match="^job: .*; expected the number or the name of a job"):
                farm.job(wrong)
        with pytest.raises(ts.UsageError, match="job: .*; expected text that is UTF-8"):
            farm.job("\ud800")
        for wrong in (-1, float("nan"), float("inf")):
            with pytest.raises(ts.UsageError, match="interval: .*; expected seconds"):
                job.watch(wrong)
        with pytest.raises(TypeError, match="frame: True; expected a whole number"):
            job.fetch(True)
        with pytest.raises(TypeError, match="denoise: 'yes'; expected True or False"):
            job.fetch(denoise="yes")
        job.wait(60)
        job.forget()
        with pytest.raises(ts.RenderError, match="is forgotten"):
            job.fetch()


def test_a_job_may_have_no_name(served):
    with served.farm() as farm:
        named, unnamed = (farm.submit(KNOT, size=(8, 8), **name) for name in ({}, {"name": None}))
        assert named.status()["name"] == unnamed.status()["name"] != ""
        with pytest.raises(TypeError) as told:
            farm.submit(KNOT, name=3)
        assert str(told.value) == "name: 3; expected text"


def test_of_jobs_that_share_a_name_the_latest_is_told_and_none_is_changed(served):
    with served.farm() as farm:
        jobs = [farm.submit(KNOT, size=(8, 8), name="twin") for _ in range(2)]
        with pytest.warns(UserWarning, match=f"2 jobs have the name 'twin': job {jobs[1].number}"):
            twin = farm.job("twin")
        assert twin == jobs[1]
        for one in (twin, pickle.loads(pickle.dumps(twin))):
            for change in (one.cancel, one.pause, one.resume, one.forget):
                with pytest.raises(ts.UsageError, match="2 jobs have the name.*; expected the number"):
                    change()
        assert [job.wait(60)["state"] for job in jobs] == ["done", "done"]
        farm.job(jobs[1].number).forget()
        assert jobs[0] in farm.jobs() and jobs[1] not in farm.jobs()


def test_wrong_keys_and_dead_farms_are_told(served, tmp_path):
    with served.farm(**served.keys("stranger")) as farm:
        with pytest.raises(ts.Refused, match="does not let this key in") as caught:
            farm.jobs()
        assert isinstance(caught.value, PermissionError)
        with pytest.raises(ts.Refused) as again:
            ts.render(KNOT, size=SIZE, farm=farm)
        for error in (caught.value, again.value, pickle.loads(pickle.dumps(caught.value))):
            assert error.endpoint == served.endpoint
    with pytest.raises(ts.UsageError, match="^key: .*no such file"):
        served.farm(key=tmp_path / "missing.key")
    with pytest.raises(ts.UsageError, match="^key: needs server_key"):
        ts.Farm(served.endpoint, key=served.folder / "alice.key")
    with ts.Farm("tcp://127.0.0.1:9", timeout=5) as nobody:
        with pytest.raises(ts.FarmError, match="nothing listens") as caught:
            nobody.jobs()
        assert isinstance(caught.value, ConnectionError) and caught.value.code == 3
        assert caught.value.endpoint == "tcp://127.0.0.1:9"
    with served.farm() as farm:
        for keyword in ("workers", "denoise", "output", "stats", "resume", "connect", "on_tile"):
            with pytest.raises(TypeError, match=f"submit.. has no keyword '{keyword}'"):
                farm.submit(KNOT, **{keyword: True})
        with pytest.raises(ts.UsageError, match="priority: 2000"):
            farm.submit(KNOT, priority=2000)
    with pytest.raises(RuntimeError, match="closed"):
        farm.jobs()
    for timeout in (0, float("inf"), float("nan"), 1e300):
        with pytest.raises(ts.UsageError, match="^timeout: .*expected seconds above 0"):
            served.farm(timeout=timeout)


def test_another_key_of_the_coordinator_is_told_long_before_the_timeout(served):
    others = served.folder / "stranger.pub"
    with served.farm(server_key=others, timeout=10**6) as farm:
        with pytest.raises(ts.FarmError, match="no connection .*another key"):
            farm.jobs()
        with pytest.raises(ts.FarmError, match="no connection .*another key"):
            ts.render(KNOT, size=SIZE, farm=farm)


def test_ctrl_c_ends_a_question_that_waits_for_that_of_another_thread(script):
    # What listens here says nothing: the other thread's question lasts for all of `timeout`.
    assert script("""
import os, signal, socket, threading, time, tessera as ts
def interrupt(*_):
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, interrupt)
with socket.create_server(("127.0.0.1", 0)) as silent:
    farm = ts.Farm(f"tcp://127.0.0.1:{silent.getsockname()[1]}", timeout=15)
    other = threading.Thread(target=farm.jobs)
    other.start()
    time.sleep(1)
    signal.setitimer(signal.ITIMER_REAL, .2)
    try:
        farm.jobs()
    except KeyboardInterrupt:
        print(other.is_alive(), flush=True)
    os._exit(0)
""") == "True"


def test_jobs_pickle_and_no_secret_is_told(served, caplog):
    secret = (served.folder / "alice.key").read_text()
    words = [word for word in secret.split() if len(word) >= 32]
    assert words
    with caplog.at_level(logging.DEBUG), served.farm() as farm:
        job = farm.submit(KNOT, size=(8, 8))
        threads = len(os.listdir("/proc/self/task"))
        copy = pickle.loads(pickle.dumps(job))
        assert (copy, hash(copy), repr(copy)) == (job, hash(job), repr(job))
        assert len(os.listdir("/proc/self/task")) == threads  # it connects when it is asked something
        with copy.farm:
            assert copy == job and copy.wait(60)["state"] == "done"
        shown = [repr(farm), repr(job), caplog.text, pickle.dumps(job).decode("latin1")]
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(farm)
    assert not [word for word in words for text in shown if word in text]
