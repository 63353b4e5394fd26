"""How far a render is, and what shows it."""
from __future__ import annotations

import importlib
import sys
import time
from typing import (TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Protocol, Union,
                    runtime_checkable)

from .picture import Image, Rect

if TYPE_CHECKING:
    from .rendering import Task

SHOW_SECONDS = .1
"""From one look at a task to the next, for who shows it."""


class Progress(NamedTuple):
    """How far a render is."""

    done: int
    """Tiles that are finished."""
    total: int
    """Tiles in all; 0 before they are known."""
    workers: int
    """Workers that are connected."""
    elapsed: float
    """Seconds since it began."""
    remaining: float
    """Seconds until it is done, by an estimate; negative: not known yet."""
    waiting_for: str
    """What it waits for, such as "workers"; empty while tiles are traced."""


@runtime_checkable
class Bar(Protocol):
    """What is used of a bar like tqdm's."""

    total: Any
    n: Any

    def update(self, n: int) -> object: ...
    def refresh(self) -> object: ...
    def close(self) -> object: ...


ProgressOption = Union[None, bool, Callable[[Progress], object], Bar]
TileCallback = Callable[[Rect, Image], object]


class Callbacks:
    """What a render tells, on the thread that waits for it."""

    __slots__ = ("_progress", "_on_tile", "_show")

    def __init__(self, progress: ProgressOption, on_tile: Optional[TileCallback]) -> None:
        if not (progress is None or isinstance(progress, (bool, Bar)) or callable(progress)):
            raise TypeError(f"progress: {progress!r:.100}; expected True, a function or a bar like tqdm's")
        if not (on_tile is None or callable(on_tile)):
            raise TypeError(f"on_tile: {on_tile!r:.100}; expected a function of a Rect and an Image")
        self._progress = None if progress is False else progress
        self._on_tile = on_tile
        self._show: Optional[Callable[[Optional[Progress]], None]] = None

    def wants_tiles(self) -> bool:
        """Whether each tile is told."""
        return self._on_tile is not None

    def tell(self, task: Task) -> None:
        """Tells what is new."""
        progress, on_tile, show = self._progress, self._on_tile, self._show  # another thread may end all
        if progress is not None:
            if show is None:
                show = self._show = _display(progress)
            show(task.progress)
        tiles = () if on_tile is None else task._task.take_tiles()
        if tiles and on_tile is not None:
            so_far = task.snapshot()
            assert so_far is not None
            for tile in tiles:
                on_tile(Rect(*tile), so_far)

    def pause(self) -> None:
        """Takes down what is shown, as nobody waits now."""
        show, self._show = self._show, None
        if show is not None:
            show(None)

    def end(self) -> None:
        """Tells nothing any more."""
        self._progress = self._on_tile = None
        self.pause()


def _display(progress: ProgressOption) -> Callable[[Optional[Progress]], None]:
    """What shows progress; called with None at the end."""
    if progress is True:
        for shown_by in (_tqdm_display, _rich_display):
            try:
                return shown_by()
            except ImportError:
                pass
        return _text_display()
    if isinstance(progress, Bar):
        return _bar_display(progress, closes=False)
    assert callable(progress)
    tell = progress
    last: Optional[Progress] = None

    def call(now: Optional[Progress]) -> None:
        nonlocal last
        if now is not None and now != last:
            tell(now)
        last = now

    return call


def _tqdm_display() -> Callable[[Optional[Progress]], None]:
    # Imported by name, as mypy finds its stubs on some machines and not on others.
    tqdm: Any = importlib.import_module("tqdm.auto").tqdm
    show: Optional[Callable[[Optional[Progress]], None]] = None

    def show_once_there_is_a_total(now: Optional[Progress]) -> None:
        nonlocal show
        if show is None and now is not None and now.total:
            show = _bar_display(tqdm(unit="tile", total=now.total), closes=True)
        if show is not None:
            show(now)

    return show_once_there_is_a_total


def _rich_display() -> Callable[[Optional[Progress]], None]:
    progress, console = (importlib.import_module(f"rich.{name}") for name in ("progress", "console"))
    bars: Any = progress.Progress(console=console.Console(stderr=True))
    task = bars.add_task("tiles", total=None)
    bars.start()

    def show(now: Optional[Progress]) -> None:
        if now is None:
            bars.stop()
        else:
            bars.update(task, completed=now.done, total=now.total or None)

    return show


def _bar_display(bar: Bar, closes: bool) -> Callable[[Optional[Progress]], None]:
    bar.n = 0  # which may have shown another render

    def show(now: Optional[Progress]) -> None:
        if now is None:
            if closes:
                bar.close()
            return
        if now.total and bar.total != now.total:
            bar.total = now.total
            bar.refresh()
        if now.done > bar.n:
            bar.update(now.done - bar.n)

    return show


def _text_display() -> Callable[[Optional[Progress]], None]:
    last = 0.

    def show(now: Optional[Progress]) -> None:
        nonlocal last
        if not sys.stderr.isatty():
            return
        if now is None:
            sys.stderr.write("\r\x1b[K")
        elif time.monotonic() - last > SHOW_SECONDS and now.total:
            last = time.monotonic()
            left = f", {now.remaining:.1f} s left" if now.remaining > 0 else ""
            sys.stderr.write(f"\r\x1b[K{now.done} of {now.total} tiles{left}")
        sys.stderr.flush()

    return show
