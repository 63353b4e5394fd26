"""Farms elsewhere: a coordinator that `tessera serve` runs, and its jobs."""
from __future__ import annotations

import json
import time
import warnings
from typing import Any, Iterator, List, NoReturn, Optional, Sequence, Tuple, Union

from . import _core
from ._arguments import boolean, named_text, number, refuse_unknown, seconds, tells_unknown, whole
from ._callers import level_of_caller
from ._html import table
from ._local_farms import BaseFarm
from ._messages import Scene
from ._options import core_options
from ._places import located_errors
from ._types import (Accelerator, Aovs, Crop, Integrator, Path, Pattern, Shadows, Size, ToneMap,
                     Transfer, Up, View, X3dColor, X3dShadows, X3dTexture)
from .errors import Error, SceneWarning, UsageError, in_python
from .picture import Image
from .rendering import checked_scene, with_picture

_LONGEST_TIMEOUT = 10**9
_Connection = Tuple[str, str, str, float]  # endpoint, key, server key and timeout


class Farm(BaseFarm):
    """A farm that `tessera serve` coordinates; needs no worker here.

    :param endpoint: of the coordinator: tcp://HOST:PORT or ipc://PATH.
    :param key: the file of our secret key, where the farm asks for one. Only its path is kept.
    :param server_key: the coordinator's public key: its .pub file, or the 64 digits.
    :param timeout: seconds of silence after which the farm counts as gone.

    Raises UsageError for keys that cannot be read. Whether the farm is there shows at the first
    question: FarmError where nobody answers, Refused where it does not let us in.
    """

    __slots__ = ("endpoint", "key", "server_key", "timeout", "_access")

    @tells_unknown
    def __init__(self, endpoint: str = "tcp://127.0.0.1:7117", key: Optional[Path] = None,
                 server_key: Optional[Path] = None, timeout: float = 15) -> None:
        self._thread = None
        if not 0 < number("timeout", timeout) <= _LONGEST_TIMEOUT:
            raise UsageError(f"timeout: {timeout}; expected seconds above 0, at most {_LONGEST_TIMEOUT}")
        self.endpoint = named_text("endpoint", endpoint)
        self.key = "" if key is None else named_text("key", key)
        self.server_key = "" if server_key is None else named_text("server_key", server_key)
        self.timeout = float(timeout)
        self._access: Optional[_core.FarmAccess] = _core.FarmAccess(*self._arguments())
        super().__init__(_core.remote_farm(*self._arguments()))

    def _arguments(self) -> _Connection:
        return self.endpoint, self.key, self.server_key, self.timeout

    def _ask(self) -> _core.FarmAccess:
        self._check_process()
        if self._access is None:
            raise RuntimeError("Farm: it is closed; expected one that is open")
        return self._access

    def close(self) -> None:
        """Ends the connection; jobs go on. May be called again."""
        super().close()
        self._access = None

    def submit(self, scene: Union[Scene, Path], *,
               frames: Union[None, str, int, range, Tuple[int, int]] = None, name: Optional[str] = None,
               priority: int = 0, weight: int = 1, size: Optional[Size] = None,
               crop: Optional[Crop] = None, camera: Optional[str] = None, view: Optional[View] = None,
               pinhole: bool = False, frame_all: bool = False, spp: Optional[int] = None,
               target_error: Optional[float] = None, min_spp: Optional[int] = None,
               filter: Optional[str] = None, pattern: Optional[Pattern] = None,
               seed: Optional[int] = None, integrator: Optional[Integrator] = None,
               max_depth: Optional[int] = None, shadows: Optional[Shadows] = None,
               accel: Optional[Accelerator] = None, aovs: Aovs = (),
               transparent_background: bool = False, time: Optional[float] = None, place: Union[str, Sequence[str]] = (),
               assets: Optional[Path] = None, environment: Optional[Path] = None, up: Optional[Up] = None,
               strict: bool = False, two_sided: bool = False, x3d_color: Optional[X3dColor] = None,
               x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
               x3d_weld: Optional[float] = None, x3d_strict: bool = False,
               x3d_two_sided: bool = False, tile: Optional[int] = None,
               exposure: Optional[float] = None, tone_map: Optional[ToneMap] = None,
               transfer: Optional[Transfer] = None, gamma: Optional[float] = None,
               **unknown: NoReturn) -> Job:
        """Leaves a scene, or the frames of its animation that `frames` tells, as (first, last), a
        range or text such as "1,5,10-20" or "1-100x5", to the farm: returns once it has all of it, a
        job of at most 10,000 frames. The options are those of `tessera submit`. Raises what `render`
        raises for them, UsageError for frames that are none, FarmError where the farm is gone.

        :param priority: from -1000 to 1000; the tiles of the highest go first.
        :param weight: its share beside jobs of its priority, from 1 to 1000."""
        options = {name: value for name, value in locals().items() if name not in _OF_JOBS}
        if unknown:
            refuse_unknown("submit", unknown, [*options, *sorted(_OF_JOBS - {"self", "unknown"})])
        access = self._ask()
        checked_priority(priority)
        if not 1 <= whole("weight", weight) <= 1000:
            raise UsageError(f"weight: {weight}; expected a whole number from 1 to 1000")
        scene = checked_scene(scene)
        with located_errors(scene):
            number, told = access.submit(
                core_options(options, of_jobs=True), scene,
                "" if name is None else named_text("name", name), priority, weight)
        for warning in told:
            warnings.warn(in_python(warning), SceneWarning, stacklevel=level_of_caller())
        return Job(self, number)

    def jobs(self) -> List["Job"]:
        """All jobs that the farm knows, by their numbers."""
        return [Job(self, job["job"]) for job in json.loads(self._ask().list())["jobs"]]

    def job(self, job: Union[int, str]) -> "Job":
        """The job of that number, or the latest of that name; "name:7" is a name, "7" a number. Of
        several of one name it warns, and refuses to change it: that takes its number. Raises
        UsageError where there is none, FarmError where the farm is gone."""
        if isinstance(job, bool) or not isinstance(job, (int, str)):
            raise TypeError(f"job: {job!r:.100}; expected the number or the name of a job")
        number, told = self._ask().find(named_text("job", str(job)))
        for warning in told:
            warnings.warn(warning, stacklevel=level_of_caller())
        found = Job(self, number)
        found._one_of_several = "; ".join(told)
        return found

    def workers(self) -> int:
        """How many workers are connected."""
        return int(json.loads(self._ask().list())["workers"])

    def __repr__(self) -> str:
        return f"Farm({self.endpoint!r})"


_ENDED = ("done", "failed", "cancelled")
_OF_JOBS = {"self", "scene", "name", "priority", "weight", "unknown"}


def checked_priority(priority: int) -> int:
    most = _core.most_priority
    if not -most <= whole("priority", priority) <= most:
        raise UsageError(f"priority: {priority}; expected a whole number from {-most} to {most}")
    return priority


class Job:
    """A job of a farm: it goes on whether or not anybody watches."""

    __slots__ = ("_farm", "_connection", "_one_of_several", "number")

    def __init__(self, farm: Farm, number: int) -> None:
        self._farm: Optional[Farm] = farm
        self._connection = farm._arguments()
        self._one_of_several = ""  # why its name alone does not tell which is to be changed
        self.number = number

    @property
    def farm(self) -> Farm:
        """Its farm. A job that was pickled connects to it when it is first asked something."""
        if self._farm is None:
            endpoint, key, server_key, timeout = self._connection
            self._farm = Farm(endpoint, key or None, server_key or None, timeout)
        return self._farm

    def status(self) -> dict[str, Any]:
        """What it is at: the object of `tessera status JOB --json`."""
        status: dict[str, Any] = json.loads(self.farm._ask().status(self.number))
        return status

    def watch(self, interval: float = .5) -> Iterator[dict[str, Any]]:
        """Yields its status every `interval` seconds, at least 0, and at its end. Raises UsageError for other
        intervals, FarmError where the farm is gone."""
        if not 0 <= seconds("interval", interval) <= _LONGEST_TIMEOUT:
            raise UsageError(f"interval: {interval}; expected seconds, at most {_LONGEST_TIMEOUT}")
        return self._statuses(interval)

    def _statuses(self, interval: float) -> Iterator[dict[str, Any]]:
        while True:
            status = self.status()
            yield status
            if status["state"] in _ENDED:
                return
            time.sleep(interval)

    def wait(self, timeout: Optional[float] = None) -> dict[str, Any]:
        """Waits until it has ended, which one that is paused or held does not. Raises TimeoutError
        after `timeout` seconds."""
        end = None if timeout is None else time.monotonic() + seconds("timeout", timeout)
        for status in self.watch(.1):
            if status["state"] in _ENDED:
                return status
            if end is not None and time.monotonic() >= end:
                raise TimeoutError(f"job {self.number} is {status['state']} after {timeout} s")
        raise AssertionError("watch() ends with an end")

    def frames(self) -> Sequence[int]:
        """Its frames by their numbers; one that is no animation has frame 0."""
        return self.farm._ask().frames(self.number)

    def fetch(self, frame: Optional[int] = None, *, denoise: bool = False) -> Image:
        """The picture of a frame by its number, of the first if left out.

        :param denoise: as render does; of jobs with aovs albedo, normal, depth and variance.

        Raises RenderError with what the frame failed with, Cancelled if the job was cancelled, both
        with what is done as `image`, and TimeoutError while it is not done: `wait()` before."""
        at = self._place_of(frame)
        fetched = self.farm._ask().fetch(self.number, at, boolean("denoise", denoise))
        if not fetched.has_ended:
            raise TimeoutError(f"job {self.number} is not done yet; expected wait() before fetch()")
        image = None if fetched.picture is None else Image._of(fetched.picture)
        try:
            fetched.throw_failure()
        except Error as error:
            raise with_picture(error, image) from None
        assert image is not None
        return image

    def snapshot(self, frame: Optional[int] = None) -> Optional[Image]:
        """What is done of a frame by its number, of the first if left out, whatever became of it; the rest is
        black. None where nothing is. Raises UsageError for the number of no frame of the job."""
        at = self._place_of(frame)
        access = self.farm._ask()
        fetched = access.fetch(self.number, at, False)
        picture = fetched.picture if fetched.has_ended else access.snapshot(self.number, at)
        return None if picture is None else Image._of(picture)

    def _place_of(self, frame: Optional[int]) -> int:
        """Where the frame of that number stands among those of the job."""
        if frame is None:
            return 0
        numbers = list(self.frames())
        if whole("frame", frame) not in numbers:
            raise UsageError(f"frame: {frame}; expected one of the job, from {numbers[0]} to {numbers[-1]}")
        return numbers.index(frame)

    def _order(self, order: _core.Order, priority: Optional[int] = None) -> None:
        if self._one_of_several:
            raise UsageError(f"job: {self._one_of_several}; expected the number of the one to change")
        self.farm._ask().order(self.number, order, priority)

    def pause(self) -> None:
        """Its tiles wait until `resume()`."""
        self._order(_core.Order.pause)

    def resume(self, priority: Optional[int] = None) -> None:
        """It goes on, with another priority if one is given, a whole number of the range that `Farm.submit`
        takes. Raises UsageError for others."""
        self._order(_core.Order.resume, None if priority is None else checked_priority(priority))

    def cancel(self) -> None:
        """It ends, with what is done of it."""
        self._order(_core.Order.cancel)

    def retry(self) -> None:
        """What failed is rendered again; what is held is tried now."""
        self._order(_core.Order.retry)

    def forget(self) -> None:
        """The farm deletes the job, its tiles and its scene."""
        self._order(_core.Order.forget)

    def __eq__(self, other: object) -> bool:
        return (isinstance(other, Job) and other.number == self.number
                and other._connection[0] == self._connection[0])

    def __hash__(self) -> int:
        return hash((self._connection[0], self.number))

    def __repr__(self) -> str:
        return f"<Job {self.number} of {self._connection[0]}>"

    def _repr_html_(self) -> str:
        return table(self.status())

    def __reduce__(self) -> Tuple[Any, ...]:
        return _unpickled, (*self._connection, self._one_of_several, self.number)


def _unpickled(endpoint: str, key: str, server_key: str, timeout: float, one_of_several: str,
               number: int) -> Job:
    job = Job.__new__(Job)
    job._farm, job._connection, job.number = None, (endpoint, key, server_key, timeout), number
    job._one_of_several = one_of_several
    return job
