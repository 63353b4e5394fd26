"""Farms elsewhere: a coordinator that `tessera serve` runs, and its jobs."""
from __future__ import annotations

import json
import time
import warnings
from typing import TYPE_CHECKING, Any, Iterator, List, NoReturn, Optional, Sequence, Tuple, Union

from . import _core
from ._html import table
from .errors import Error, SceneWarning, UsageError
from .picture import Image
from ._local_farms import BaseFarm
from ._options import number, plain_text, whole
from ._types import (Accelerator, Aovs, Crop, Integrator, Path, Pattern, Size, ToneMap, Transfer,
                     X3dColor, X3dShadows, X3dTexture)
from ._value import refuse_unknown
from .rendering import checked_scene, core_options, with_picture

if TYPE_CHECKING:
    from .scene import Scene


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

    def __init__(self, endpoint: str = "tcp://127.0.0.1:7117", key: Optional[Path] = None,
                 server_key: Optional[Path] = None, timeout: float = 15) -> None:
        self._thread = None
        if not number("timeout", timeout) > 0:
            raise UsageError(f"timeout: {timeout}; expected seconds above 0")
        self.endpoint = plain_text("endpoint", endpoint)
        self.key = "" if key is None else plain_text("key", key)
        self.server_key = "" if server_key is None else plain_text("server_key", server_key)
        self.timeout = float(timeout)
        arguments = (self.endpoint, self.key, self.server_key, self.timeout)
        self._access: Optional[_core.FarmAccess] = _core.FarmAccess(*arguments)
        super().__init__(_core.remote_farm(*arguments))

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
               frames: Union[None, str, int, Tuple[int, int]] = None, name: str = "",
               priority: int = 0, weight: int = 1, size: Optional[Size] = None,
               crop: Optional[Crop] = None, camera: Optional[str] = None, pinhole: bool = False,
               frame_all: bool = False, spp: Optional[int] = None,
               target_error: Optional[float] = None, min_spp: Optional[int] = None,
               filter: Optional[str] = None, pattern: Optional[Pattern] = None,
               seed: Optional[int] = None, integrator: Optional[Integrator] = None,
               accel: Optional[Accelerator] = None, aovs: Aovs = (),
               time: Optional[float] = None, place: Union[str, Sequence[str]] = (),
               assets: Optional[Path] = None, x3d_color: Optional[X3dColor] = None,
               x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
               x3d_weld: Optional[float] = None, x3d_strict: bool = False,
               x3d_two_sided: bool = False, tile: Optional[int] = None,
               exposure: Optional[float] = None, tone_map: Optional[ToneMap] = None,
               transfer: Optional[Transfer] = None, gamma: Optional[float] = None,
               **unknown: NoReturn) -> Job:
        """Leaves a scene, or the frames A to B of its animation, to the farm: returns once it has
        all of it. The options are those of `tessera submit`."""
        options = {name: value for name, value in locals().items() if name not in _OF_JOBS}
        if unknown:
            refuse_unknown("submit", unknown, [*options, *_OF_JOBS])
        access = self._ask()
        most = _core.most_priority
        if not -most <= whole("priority", priority) <= most:
            raise UsageError(f"priority: {priority}; expected a whole number from {-most} to {most}")
        if not 1 <= whole("weight", weight) <= 1000:
            raise UsageError(f"weight: {weight}; expected a whole number from 1 to 1000")
        number, told = access.submit(core_options(options, of_jobs=True), checked_scene(scene), name,
                                     priority, weight)
        for warning in told:
            warnings.warn(warning, SceneWarning, stacklevel=2)
        return Job(self, number)

    def jobs(self) -> List["Job"]:
        """All jobs that the farm knows, by their numbers."""
        return [Job(self, job["job"]) for job in json.loads(self._ask().list())["jobs"]]

    def job(self, job: Union[int, str]) -> "Job":
        """The job of that number, or the latest of that name."""
        number, told = self._ask().find(str(job))
        for warning in told:
            warnings.warn(warning, stacklevel=2)
        return Job(self, number)

    def workers(self) -> int:
        """How many workers are connected."""
        return int(json.loads(self._ask().list())["workers"])

    def __repr__(self) -> str:
        return f"Farm({self.endpoint!r})"


_OF_JOBS = {"self", "scene", "name", "priority", "weight", "unknown"}


class Job:
    """A job of a farm: it goes on whether or not anybody watches."""

    __slots__ = ("farm", "number")

    def __init__(self, farm: Farm, number: int) -> None:
        self.farm = farm
        self.number = number

    def status(self) -> dict[str, Any]:
        """What it is at: the object of `tessera status JOB --json`."""
        status: dict[str, Any] = json.loads(self.farm._ask().status(self.number))
        return status

    def watch(self, interval: float = .5) -> Iterator[dict[str, Any]]:
        """Yields its status every `interval` seconds, and at its end."""
        while True:
            status = self.status()
            yield status
            if status["state"] in ("done", "failed", "cancelled"):
                return
            time.sleep(interval)

    def wait(self, timeout: Optional[float] = None) -> dict[str, Any]:
        """Waits until it has ended. Raises TimeoutError after `timeout` seconds."""
        end = None if timeout is None else time.monotonic() + timeout
        for status in self.watch(.1):
            if status["state"] in ("done", "failed", "cancelled"):
                return status
            if end is not None and time.monotonic() >= end:
                raise TimeoutError(f"job {self.number} is {status['state']} after {timeout} s")
        raise AssertionError("watch() ends with an end")

    def frames(self) -> Sequence[int]:
        """The numbers of its frames; one that is no animation has frame 0."""
        return self.farm._ask().frames(self.number)

    def fetch(self, frame: Optional[int] = None, *, denoise: bool = False) -> Image:
        """The picture of a frame, of the first if left out.

        :param denoise: as render does; of jobs with aovs albedo, normal, depth and variance.

        Raises RenderError with what the frame failed with, Cancelled if the job was cancelled, both
        with what is done as `image`, and TimeoutError while it is not done: `wait()` before."""
        at = self._place_of(frame)
        fetched = self.farm._ask().fetch(self.number, at, denoise)
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
        """What is done of a frame, of the first if left out, whatever became of it; the rest is black.
        None where nothing is."""
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
        if frame not in numbers:
            raise UsageError(f"frame: {frame}; expected one from {numbers[0]} to {numbers[-1]}")
        return numbers.index(frame)

    def _order(self, order: _core.Order, priority: Optional[int] = None) -> None:
        self.farm._ask().order(self.number, order, priority)

    def pause(self) -> None:
        """Its tiles wait until `resume()`."""
        self._order(_core.Order.pause)

    def resume(self) -> None:
        """It goes on."""
        self._order(_core.Order.resume)

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
                and other.farm.endpoint == self.farm.endpoint)

    def __hash__(self) -> int:
        return hash((self.farm.endpoint, self.number))

    def __repr__(self) -> str:
        return f"<Job {self.number} of {self.farm.endpoint}>"

    def _repr_html_(self) -> str:
        return table(self.status())

    def __reduce__(self) -> Tuple[Any, ...]:
        farm = self.farm
        return _unpickled, (farm.endpoint, farm.key, farm.server_key, farm.timeout, self.number)


def _unpickled(endpoint: str, key: str, server_key: str, timeout: float, number: int) -> Job:
    return Job(Farm(endpoint, key or None, server_key or None, timeout), number)
