"""Rendering: `render` and its tasks.

A task belongs to a farm. The farm has a thread of its own in the extension module, which runs tasks
one after the other and waits for no script: a script may compute, sleep or be interrupted meanwhile.
"""
from __future__ import annotations

import os
import sys
import time
import warnings as _warnings
from typing import (Any, AsyncIterator, Generator, Iterator, Literal, NoReturn, Optional,
                    Sequence, Union, overload)

from . import _core
from ._arguments import (boolean, fraction_text, frame_number, named_text, refuse_unknown, seconds,
                         whole_count)
from ._callers import level_of_caller
from ._local_farms import BaseFarm, LocalFarm, OfThisProcess, Threads
from ._log import pass_on_log
from ._messages import Scene
from ._options import core_options
from ._places import located_errors
from ._progress import SHOW_SECONDS, Callbacks, Progress, ProgressOption, TileCallback
from ._types import (Accelerator, Aovs, Crop, Integrator, Path, Pattern, Shadows, Size, Up, View,
                     X3dColor, X3dShadows, X3dTexture)
from .errors import (Cancelled, Error, MissingFile, RenderError, SceneError, SceneWarning,
                     UsageError, in_python)
from .picture import Image

_LOOK_SECONDS = .02  # how often a waiting thread looks for signals


class Task(OfThisProcess):
    """A render that goes on by itself: `await` it, iterate over its progress, or ask `result()`.

    As a context manager it is cancelled at the end of the block, if it is not done by then.
    """

    __slots__ = ("_task", "_scene", "_farm", "_owns_farm", "_callbacks")

    def __init__(self, task: _core.Task, scene: Union[Scene, str], farm: BaseFarm,
                 owns_farm: bool, callbacks: Callbacks) -> None:
        super().__init__()
        self._callbacks = callbacks
        self._scene = scene
        self._task = task
        self._farm = farm
        self._owns_farm = owns_farm

    def done(self) -> bool:
        """Whether it has ended, in whatever way."""
        self._check_process()
        return self._task.is_done()

    def cancel(self) -> None:
        """Ends it soon, if it is not done. Returns at once."""
        self._check_process()
        self._task.cancel()

    @property
    def progress(self) -> Progress:
        """How far it is now."""
        self._check_process()
        return Progress(*self._task.progress())

    def snapshot(self) -> Optional[Image]:
        """What is done of the picture so far, the rest black; None before the first tile."""
        self._check_process()
        picture = self._task.snapshot()
        return None if picture is None else Image._of(picture)

    def result(self, timeout: Optional[float] = None) -> Image:
        """Waits for the picture, and calls `progress` and `on_tile` of `render` meanwhile.

        Raises TimeoutError after `timeout` seconds (the render goes on), Cancelled after `cancel()`,
        and what the render failed with. KeyboardInterrupt cancels it, and is raised once all of ours
        has ended.
        """
        self._check_process()
        end = None if timeout is None else time.monotonic() + seconds("timeout", timeout)
        try:
            is_done = self._task.wait(_LOOK_SECONDS)
            while not (is_done or (end is not None and time.monotonic() >= end)):
                self._callbacks.tell(self)
                self._check_process()  # which a callback may have forked
                is_done = self._task.wait(_LOOK_SECONDS)
            if is_done:
                self._callbacks.tell(self)
                self._callbacks.end()
            else:
                self._callbacks.pause()
        except BaseException:
            self._abandon()
            raise
        if not is_done:
            raise TimeoutError(f"the picture is not done after {timeout} s")
        return self._finish()

    def _abandon(self) -> None:
        """Cancels it and waits for its end, but in a forked child. Its picture is dropped."""
        try:
            if os.getpid() == self._process:
                self._task.abandon()
                self._end()
        finally:
            self._callbacks.end()

    def _end(self) -> None:
        """Cancels, and waits until nothing of it runs."""
        self._task.cancel()
        while not self._task.wait(1):
            pass
        if self._owns_farm:
            self._farm.close()

    def _finish(self) -> Image:
        if self._owns_farm:
            self._farm.close()
        pass_on_log()
        picture = self._task.picture()
        image = None if picture is None else Image._of(picture)
        try:
            with located_errors(self._scene):
                self._task.throw_failure()
        except SceneError:
            raise
        except Error as error:
            raise with_picture(error, image) from None
        for warning in self._task.warnings():
            _warnings.warn(in_python(warning), SceneWarning, stacklevel=level_of_caller())
        assert image is not None
        return image

    def __iter__(self) -> Iterator[Progress]:
        """Yields the progress every .1 s while it changes, and at the end. Ctrl-C while it waits
        for the next cancels the render; to leave the loop, by whatever way, does not."""
        self._check_process()
        last = None
        try:
            while not self._task.wait(SHOW_SECONDS):
                now = self.progress
                if now != last:
                    yield now
                last = now
        except KeyboardInterrupt:
            self._abandon()
            raise
        yield self.progress

    async def __aiter__(self) -> AsyncIterator[Progress]:
        import asyncio
        last = None
        while not self.done():
            if self.progress != last:
                last = self.progress
                yield last
            await asyncio.sleep(SHOW_SECONDS)
        yield self.progress

    def __await__(self) -> Generator[Any, None, Image]:
        return self._wait_async().__await__()

    async def _wait_async(self) -> Image:
        import asyncio  # here: it takes longer to import than all of ours
        try:
            while not self.done():
                self._callbacks.tell(self)
                await asyncio.sleep(_LOOK_SECONDS)
            self._callbacks.tell(self)
            self._callbacks.end()
        except (asyncio.CancelledError, Exception):
            try:
                self._check_process()
                self.cancel()
                if self._owns_farm:
                    await asyncio.get_running_loop().run_in_executor(None, self._end)
            finally:
                self._callbacks.end()
            raise
        if self._owns_farm:  # its workers end meanwhile, and the loop goes on
            await asyncio.get_running_loop().run_in_executor(None, self._farm.close)
        return self._finish()

    def show(self) -> None:
        """Waits for the picture, which `result` then returns at once; in a notebook one output is updated
        while it fills in. Raises what `result` does."""
        ipython = sys.modules.get("IPython")
        if ipython is None or ipython.get_ipython() is None:
            self.result()  # a plain script, which has nothing to update
            return
        shown: Any = None
        for _ in self:
            picture = self.snapshot()
            if picture is None:
                continue
            if shown is None:
                shown = ipython.display.display(picture, display_id=True)
            else:
                shown.update(picture)
        self.result()

    def __enter__(self) -> "Task":
        self._check_process()
        return self

    def __exit__(self, *_: object) -> None:
        if os.getpid() == self._process:
            self._end()

    def __del__(self) -> None:
        # Nobody can have its picture.
        if hasattr(self, "_owns_farm") and os.getpid() == self._process:
            self._task.abandon()
            if self._owns_farm:
                self._farm.close()

    def __reduce__(self) -> NoReturn:
        raise TypeError("Task cannot be copied or pickled: it belongs to its process")

    def __repr__(self) -> str:
        if os.getpid() != self._process:
            return f"<Task of process {self._process}>"
        state = "done" if self._task.is_done() else "running"
        return f"<Task {state}, {self.progress.done} of {self.progress.total} tiles>"


def with_picture(error: Error, image: Optional[Image]) -> Error:
    """The error of a render with what was done of the picture."""
    if isinstance(error, (RenderError, Cancelled)):
        error.image = image
        error.stats = None if image is None else image.stats
    return error




def checked_scene(scene: Union[Scene, Path], keyword: str = "scene") -> Union[Scene, str]:
    """A Scene, or the path of a file that is there."""
    if isinstance(scene, os.PathLike):
        scene = os.fspath(scene)
    if isinstance(scene, str):
        scene = named_text(keyword, scene)
        if not os.path.exists(scene):
            raise MissingFile.of(scene, "a scene")
    if not isinstance(scene, (str, Scene)):
        raise TypeError(f"{keyword}: {scene!r:.100}; expected a Scene or the path of a file")
    return scene


def _keep_tiles(options: Any, resume: Any, scene: Any, farm: Optional[BaseFarm]) -> None:
    """Asks for `resume`, which names the picture beside which finished tiles are kept."""
    if resume is None or resume is False:
        return
    if farm is not None and not isinstance(farm, (LocalFarm, Threads)):
        raise UsageError("resume: tiles are kept where the coordinator is; expected no Farm elsewhere")
    if resume is True and not isinstance(scene, str):
        raise UsageError("resume: True, for a scene of no file; expected the path of the picture, "
                         "beside which finished tiles are kept")
    if resume is not True and not isinstance(resume, (str, os.PathLike)):
        raise TypeError(f"resume: {resume!r}; expected True or the path of the picture")
    picture = os.path.splitext(os.path.basename(scene))[0] + ".png" if resume is True else resume
    options.assign("output", os.path.abspath(named_text("resume", picture)))
    options.assign("resume", True)


def started_farm(workers: Optional[int], threads: Optional[int], verify: Union[None, float, str]) -> BaseFarm:
    """Who traces where no farm is given."""
    workers = None if workers is None else whole_count("workers", workers, least=0)
    share = fraction_text("verify", 0 if verify is None else verify)
    if workers == 0:
        _core.share_verified(share, workers)
        farm: BaseFarm = Threads(None if threads is None else whole_count("threads", threads))
    else:
        farm = LocalFarm(workers, 1 if threads is None else threads, share)
    farm._is_of_render = True
    return farm


@overload
def render(scene: Union[Scene, Path], *, size: Optional[Size] = None, crop: Optional[Crop] = None,
           camera: Optional[str] = None, view: Optional[View] = None, pinhole: bool = False,
           frame_all: bool = False, spp: Optional[int] = None, target_error: Optional[float] = None,
           min_spp: Optional[int] = None, filter: Optional[str] = None,
           pattern: Optional[Pattern] = None, seed: Optional[int] = None,
           integrator: Optional[Integrator] = None, max_depth: Optional[int] = None,
           shadows: Optional[Shadows] = None, accel: Optional[Accelerator] = None,
           aovs: Aovs = (), transparent_background: bool = False, denoise: bool = False,
           time: Optional[float] = None, frame: Optional[int] = None, place: Union[str, Sequence[str]] = (),
           assets: Optional[Path] = None, environment: Optional[Path] = None, up: Optional[Up] = None,
           strict: bool = False, two_sided: bool = False, x3d_color: Optional[X3dColor] = None,
           x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
           x3d_weld: Optional[float] = None, x3d_strict: bool = False, x3d_two_sided: bool = False,
           tile: Optional[int] = None, workers: Optional[int] = None, threads: Optional[int] = None,
           verify: Union[None, float, str] = None, farm: Optional[BaseFarm] = None,
           resume: Union[None, bool, Path] = None,
           progress: ProgressOption = None, on_tile: Optional[TileCallback] = None,
           wait: Literal[True] = True) -> Image: ...
@overload
def render(scene: Union[Scene, Path], *, size: Optional[Size] = None, crop: Optional[Crop] = None,
           camera: Optional[str] = None, view: Optional[View] = None, pinhole: bool = False,
           frame_all: bool = False, spp: Optional[int] = None, target_error: Optional[float] = None,
           min_spp: Optional[int] = None, filter: Optional[str] = None,
           pattern: Optional[Pattern] = None, seed: Optional[int] = None,
           integrator: Optional[Integrator] = None, max_depth: Optional[int] = None,
           shadows: Optional[Shadows] = None, accel: Optional[Accelerator] = None,
           aovs: Aovs = (), transparent_background: bool = False, denoise: bool = False,
           time: Optional[float] = None, frame: Optional[int] = None, place: Union[str, Sequence[str]] = (),
           assets: Optional[Path] = None, environment: Optional[Path] = None, up: Optional[Up] = None,
           strict: bool = False, two_sided: bool = False, x3d_color: Optional[X3dColor] = None,
           x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
           x3d_weld: Optional[float] = None, x3d_strict: bool = False, x3d_two_sided: bool = False,
           tile: Optional[int] = None, workers: Optional[int] = None, threads: Optional[int] = None,
           verify: Union[None, float, str] = None, farm: Optional[BaseFarm] = None,
           resume: Union[None, bool, Path] = None,
           progress: ProgressOption = None, on_tile: Optional[TileCallback] = None,
           wait: Literal[False]) -> Task: ...
def render(scene: Union[Scene, Path], *, size: Optional[Size] = None, crop: Optional[Crop] = None,
           camera: Optional[str] = None, view: Optional[View] = None, pinhole: bool = False,
           frame_all: bool = False, spp: Optional[int] = None, target_error: Optional[float] = None,
           min_spp: Optional[int] = None, filter: Optional[str] = None,
           pattern: Optional[Pattern] = None, seed: Optional[int] = None,
           integrator: Optional[Integrator] = None, max_depth: Optional[int] = None,
           shadows: Optional[Shadows] = None, accel: Optional[Accelerator] = None,
           aovs: Aovs = (), transparent_background: bool = False, denoise: bool = False,
           time: Optional[float] = None, frame: Optional[int] = None, place: Union[str, Sequence[str]] = (),
           assets: Optional[Path] = None, environment: Optional[Path] = None, up: Optional[Up] = None,
           strict: bool = False, two_sided: bool = False, x3d_color: Optional[X3dColor] = None,
           x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
           x3d_weld: Optional[float] = None, x3d_strict: bool = False, x3d_two_sided: bool = False,
           tile: Optional[int] = None, workers: Optional[int] = None, threads: Optional[int] = None,
           verify: Union[None, float, str] = None, farm: Optional[BaseFarm] = None,
           resume: Union[None, bool, Path] = None,
           progress: ProgressOption = None, on_tile: Optional[TileCallback] = None,
           wait: bool = True, **unknown: NoReturn) -> Union[Image, Task]:
    """Renders a scene, or the scene in a file, to a picture: the bits of `tessera render`.

    The keywords are those long options of `tessera render` that say what to trace and who does, with _
    for -; `tessera help render` says what each does. Beside them:

    :param frame: the number of an animation's frame; `time` is the instant by itself.
    :param farm: who traces: a LocalFarm, Threads or Farm that is kept. Left out: worker processes on
        this machine, for this render alone; with workers=0 threads of this process.
    :param resume: the path that the picture is to have. Finished tiles are kept beside it, in
        PATH.tiles, until the render is done, and it goes on from those that an interrupted one has
        left there. True: NAME.png in the current folder, of a scene in a file.
    :param progress: True for a bar (of tqdm or rich where installed, else a terminal's text), a function
        that takes a Progress, or an object like tqdm's.
    :param on_tile: called with the Rect of each tile that becomes done, and the picture so far.
    :param wait: False returns a Task at once.

    Raises SceneError, UsageError, RenderError or FarmError. Callbacks are called on the thread that
    waits, here or in `Task.result`; an exception in one cancels the render and is raised from there.
    """
    keywords = {name: value for name, value in locals().items() if name not in _OF_PYTHON}
    if unknown:
        refuse_unknown("render", unknown, [*keywords, *sorted(_OF_PYTHON - {"unknown"})])
    if farm is not None and not isinstance(farm, BaseFarm):
        raise TypeError(f"farm: {farm!r}; expected a LocalFarm, Threads or Farm")
    given = {"workers": workers, "threads": threads, "verify": verify or None}
    chosen = [name for name, value in given.items() if value is not None]
    if farm is not None and chosen:
        raise UsageError(f"{', '.join(chosen)}: cannot be chosen with farm, which has its own")
    waits, callbacks = boolean("wait", wait), Callbacks(progress, on_tile)
    scene = checked_scene(scene)
    options = core_options(keywords)
    _keep_tiles(options, resume, scene, farm)
    if farm is not None:
        farm._check_process()
    owns_farm = farm is None
    who = started_farm(workers, threads, verify) if farm is None else farm
    try:
        with located_errors(scene):
            core, told = _core.make_task(options, scene,
                                         None if frame is None else frame_number("frame", frame))
        for warning in told:
            _warnings.warn(in_python(warning), SceneWarning, stacklevel=level_of_caller())
        if callbacks.wants_tiles() or not waits:
            core.keep_tiles()
        who._submit(core)
    except BaseException:
        if owns_farm:
            who.close()
        raise
    task = Task(core, scene, who, owns_farm, callbacks)
    return task.result() if waits else task


_OF_PYTHON = {"scene", "unknown", "frame", "farm", "resume", "progress", "on_tile", "wait",
              "workers", "threads", "verify"}
