"""Rendering: `render`, tasks, and who traces.

A task belongs to a farm. The farm has a thread of its own in the extension module, which runs tasks
one after the other and waits for no script: a script may compute, sleep or be interrupted meanwhile.
"""
from __future__ import annotations

import os
import sys
import time
import warnings as _warnings
from typing import (TYPE_CHECKING, Any, AsyncIterator, Callable, Generator, Iterator, Literal, NoReturn, Optional,
                    Sequence, Union, overload)

from . import _core, _messages
from ._local_farms import BaseFarm, LocalFarm, OfThisProcess, Threads, whole_count
from ._options import option_texts, plain_text, whole
from ._places import located
from ._progress import SHOW_SECONDS, Progress, ProgressOption, progress_display
from ._types import (Accelerator, Aovs, Crop, Integrator, Path, Pattern, Size, X3dColor, X3dShadows,
                     X3dTexture)
from ._value import level_of_caller, refuse_unknown
from .errors import (Cancelled, Error, MissingFile, RenderError, SceneError, SceneWarning,
                     UsageError)
from .picture import Image, Rect

if TYPE_CHECKING:
    from .scene import Scene

_LOOK_SECONDS = .02  # how often a waiting thread looks for signals


def _pass_on_log() -> None:
    """Gives what C++ logged to the logger "tessera"."""
    told = _core.take_log()
    if not told:
        return
    import logging
    for level, message in told:
        logging.getLogger("tessera").log(max(level, 1) * 10, message)


TileCallback = Callable[[Rect, Image], object]


class Task(OfThisProcess):
    """A render that goes on by itself: `await` it, iterate over its progress, or ask `result()`.

    As a context manager it is cancelled at the end of the block, if it is not done by then.
    """

    __slots__ = ("_task", "_scene", "_farm", "_owns_farm")

    def __init__(self, task: _core.Task, scene: Union[Scene, str], farm: BaseFarm,
                 owns_farm: bool) -> None:
        super().__init__()
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
        """Waits for the picture.

        Raises TimeoutError after `timeout` seconds (the render goes on), Cancelled after `cancel()`,
        and what the render failed with. KeyboardInterrupt cancels it, and is raised once all of ours
        has ended.
        """
        self._check_process()
        end = None if timeout is None else time.monotonic() + timeout
        try:
            while not self._task.wait(_LOOK_SECONDS):
                if end is not None and time.monotonic() >= end:
                    raise TimeoutError(f"the picture is not done after {timeout} s")
        except TimeoutError:
            raise
        except BaseException:
            self._end()
            raise
        return self._finish()

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
        _pass_on_log()
        picture = self._task.picture()
        image = None if picture is None else Image._of(picture)
        try:
            self._task.throw_failure()
        except SceneError as error:
            if isinstance(self._scene, str):
                raise
            raise located(self._scene, error) from None
        except Error as error:
            raise with_picture(error, image) from None
        for warning in self._task.warnings():
            _warnings.warn(warning, SceneWarning, stacklevel=3)
        assert image is not None
        return image

    def __iter__(self) -> Iterator[Progress]:
        """Yields the progress every .1 s while it changes, and at the end."""
        self._check_process()
        last = None
        while not self._task.wait(SHOW_SECONDS):
            now = self.progress
            if now != last:
                yield now
            last = now
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
                await asyncio.sleep(_LOOK_SECONDS)
        except asyncio.CancelledError:
            self.cancel()
            if self._owns_farm:
                await asyncio.get_running_loop().run_in_executor(None, self._end)
            raise
        return self._finish()

    def show(self) -> Image:
        """Waits for the picture; in a notebook one output is updated while it fills in."""
        ipython = sys.modules.get("IPython")
        if ipython is None or ipython.get_ipython() is None:
            return self.result()  # a plain script, which has nothing to update
        shown: Any = None
        for _ in self:
            picture = self.snapshot()
            if picture is None:
                continue
            if shown is None:
                shown = ipython.display.display(picture, display_id=True)
            else:
                shown.update(picture)
        return self.result()

    def __enter__(self) -> "Task":
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def __del__(self) -> None:
        if getattr(self, "_owns_farm", False) and os.getpid() == self._process:
            self._task.cancel()
            self._farm.close()

    def __repr__(self) -> str:
        state = "done" if self._task.is_done() else "running"
        return f"<Task {state}, {self.progress.done} of {self.progress.total} tiles>"


def with_picture(error: Error, image: Optional[Image]) -> Error:
    """The error of a render with what was done of the picture."""
    if isinstance(error, (RenderError, Cancelled)):
        error.image = image
        error.stats = None if image is None else image.stats
    return error


def core_options(keywords: dict[str, Any], of_jobs: bool = False) -> _core.Options:
    """Keywords as the options of `tessera render`, or of `tessera submit`."""
    options = _core.Options(of_jobs)
    for option, text in option_texts(keywords):
        try:
            options.assign(option, text)
        except UsageError as error:
            # What was given, where the text is ours.
            given = keywords[option.replace("-", "_")]
            raise UsageError(error.message.replace(f"'{text}'", repr(given))) from None
    return options


def checked_scene(scene: Union[Scene, Path]) -> Union[Scene, str]:
    """A Scene, or the path of a file that is there."""
    if isinstance(scene, os.PathLike):
        scene = os.fspath(scene)
    if isinstance(scene, str):
        scene = plain_text("scene", scene)
        if not os.path.exists(scene):
            raise MissingFile.of(scene, "a scene")
    if not isinstance(scene, (str, _messages.Scene)):
        raise TypeError(f"scene: {scene!r:.100}; expected a Scene or the path of a file")
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
    options.assign("output", os.path.abspath(plain_text("resume", picture)))
    options.assign("resume", True)


def started_farm(workers: Optional[int], threads: Optional[int], verify: Optional[float]) -> BaseFarm:
    """Who traces where no farm is given."""
    share = 0 if verify is None else verify
    if workers == 0:
        _core.share_verified(str(share), workers)
        return Threads(None if threads is None else whole_count("threads", threads))
    return LocalFarm(workers, 1 if threads is None else threads, share)


@overload
def render(scene: Union[Scene, Path], *, size: Optional[Size] = None, crop: Optional[Crop] = None,
           camera: Optional[str] = None, pinhole: bool = False, frame_all: bool = False,
           spp: Optional[int] = None, target_error: Optional[float] = None,
           min_spp: Optional[int] = None, filter: Optional[str] = None,
           pattern: Optional[Pattern] = None, seed: Optional[int] = None,
           integrator: Optional[Integrator] = None, accel: Optional[Accelerator] = None,
           aovs: Aovs = (), denoise: bool = False, time: Optional[float] = None,
           frame: Optional[int] = None, place: Union[str, Sequence[str]] = (),
           assets: Optional[Path] = None, x3d_color: Optional[X3dColor] = None,
           x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
           x3d_weld: Optional[float] = None, x3d_strict: bool = False, x3d_two_sided: bool = False,
           tile: Optional[int] = None, workers: Optional[int] = None, threads: Optional[int] = None,
           verify: Optional[float] = None, farm: Optional[BaseFarm] = None,
           resume: Union[None, bool, Path] = None,
           progress: ProgressOption = None, on_tile: Optional[TileCallback] = None,
           wait: Literal[True] = True) -> Image: ...
@overload
def render(scene: Union[Scene, Path], *, size: Optional[Size] = None, crop: Optional[Crop] = None,
           camera: Optional[str] = None, pinhole: bool = False, frame_all: bool = False,
           spp: Optional[int] = None, target_error: Optional[float] = None,
           min_spp: Optional[int] = None, filter: Optional[str] = None,
           pattern: Optional[Pattern] = None, seed: Optional[int] = None,
           integrator: Optional[Integrator] = None, accel: Optional[Accelerator] = None,
           aovs: Aovs = (), denoise: bool = False, time: Optional[float] = None,
           frame: Optional[int] = None, place: Union[str, Sequence[str]] = (),
           assets: Optional[Path] = None, x3d_color: Optional[X3dColor] = None,
           x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
           x3d_weld: Optional[float] = None, x3d_strict: bool = False, x3d_two_sided: bool = False,
           tile: Optional[int] = None, workers: Optional[int] = None, threads: Optional[int] = None,
           verify: Optional[float] = None, farm: Optional[BaseFarm] = None,
           resume: Union[None, bool, Path] = None,
           progress: ProgressOption = None, on_tile: Optional[TileCallback] = None,
           wait: Literal[False]) -> Task: ...
def render(scene: Union[Scene, Path], *, size: Optional[Size] = None, crop: Optional[Crop] = None,
           camera: Optional[str] = None, pinhole: bool = False, frame_all: bool = False,
           spp: Optional[int] = None, target_error: Optional[float] = None,
           min_spp: Optional[int] = None, filter: Optional[str] = None,
           pattern: Optional[Pattern] = None, seed: Optional[int] = None,
           integrator: Optional[Integrator] = None, accel: Optional[Accelerator] = None,
           aovs: Aovs = (), denoise: bool = False, time: Optional[float] = None,
           frame: Optional[int] = None, place: Union[str, Sequence[str]] = (),
           assets: Optional[Path] = None, x3d_color: Optional[X3dColor] = None,
           x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
           x3d_weld: Optional[float] = None, x3d_strict: bool = False, x3d_two_sided: bool = False,
           tile: Optional[int] = None, workers: Optional[int] = None, threads: Optional[int] = None,
           verify: Optional[float] = None, farm: Optional[BaseFarm] = None,
           resume: Union[None, bool, Path] = None,
           progress: ProgressOption = None, on_tile: Optional[TileCallback] = None,
           wait: bool = True, **unknown: NoReturn) -> Union[Image, Task]:
    """Renders a scene, or the scene in a file, to a picture: the bits of `tessera render`.

    The keywords are the long options of `tessera render`, with _ for -; `tessera help render` says
    what each does. Beside them:

    :param frame: the number of an animation's frame; `time` is the instant by itself.
    :param farm: who traces: a LocalFarm, Threads or Farm that is kept. Left out: worker processes on
        this machine, for this render alone; with workers=0 threads of this process.
    :param resume: the path that the picture is to have. Finished tiles are kept beside it, in
        PATH.tiles, until the render is done, and it goes on from those that an interrupted one has
        left there. True: NAME.png in the current folder, of a scene in a file.
    :param progress: True for a bar (tqdm where it is installed, else text on a terminal), a function
        that takes a Progress, or an object like tqdm's.
    :param on_tile: called with the Rect of each tile that becomes done, and the picture so far.
    :param wait: False returns a Task at once.

    Raises SceneError, UsageError, RenderError or FarmError. Callbacks are called on this thread; an
    exception in one cancels the render and is raised from here.
    """
    keywords = {name: value for name, value in locals().items() if name not in _OF_PYTHON}
    if unknown:
        refuse_unknown("render", unknown, [*keywords, *sorted(_OF_PYTHON)])
    if farm is not None and not isinstance(farm, BaseFarm):
        raise TypeError(f"farm: {farm!r}; expected a LocalFarm, Threads or Farm")
    if farm is not None and (workers is not None or threads is not None or verify is not None):
        raise UsageError("workers, threads, verify: cannot be chosen with farm, which has its own")
    scene = checked_scene(scene)
    options = core_options(keywords)
    _keep_tiles(options, resume, scene, farm)
    if farm is not None:
        farm._check_process()
    owns_farm = farm is None
    who = started_farm(workers, threads, verify) if farm is None else farm
    try:
        core, told = _core.make_task(options, scene, None if frame is None else whole("frame", frame))
        for warning in told:
            _warnings.warn(warning, SceneWarning, stacklevel=level_of_caller())
        if on_tile is not None or not wait:
            core.keep_tiles()
        who._submit(core)
    except BaseException:
        if owns_farm:
            who.close()
        raise
    task = Task(core, scene, who, owns_farm)
    if not wait:
        return task
    if progress is None and on_tile is None:
        return task.result()
    return _watched(task, progress, on_tile)


_OF_PYTHON = {"scene", "unknown", "frame", "farm", "resume", "progress", "on_tile", "wait",
              "workers", "threads", "verify"}


def _watched(task: Task, progress: ProgressOption, on_tile: Optional[TileCallback]) -> Image:
    """Waits for the task, telling how far it is."""
    show = progress_display(progress)

    def tell_tiles() -> None:
        tiles = task._task.take_tiles() if on_tile is not None else ()
        if tiles and on_tile is not None:
            so_far = task.snapshot()
            assert so_far is not None
            for tile in tiles:
                on_tile(Rect(*tile), so_far)

    try:
        while not task._task.wait(_LOOK_SECONDS):
            show(task.progress)
            tell_tiles()
        show(task.progress)
        tell_tiles()
    except BaseException:
        task._end()
        raise
    finally:
        show(None)
    return task.result()
