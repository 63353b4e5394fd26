"""How far a render is, and what shows it."""
from __future__ import annotations

import sys
import time
from typing import Any, Callable, NamedTuple, Optional, Protocol, Union, runtime_checkable

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


def progress_display(progress: ProgressOption) -> Callable[[Optional[Progress]], None]:
    """What shows progress; called with None at the end."""
    if progress is None or progress is False:
        return lambda _: None
    if progress is True:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return _text_display()
        return _bar_display(tqdm(unit="tile"), closes=True)
    if isinstance(progress, Bar):
        return _bar_display(progress, closes=False)
    if not callable(progress):
        raise TypeError(f"progress: {progress!r}; expected True, a function or a bar like tqdm's")
    tell = progress
    last: Optional[Progress] = None

    def call(now: Optional[Progress]) -> None:
        nonlocal last
        if now is not None and now != last:
            tell(now)
        last = now

    return call


def _bar_display(bar: Bar, closes: bool) -> Callable[[Optional[Progress]], None]:
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
