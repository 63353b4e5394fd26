"""Who traces on this machine: worker processes, or threads of this one."""
from __future__ import annotations

import atexit
import os
import warnings
import weakref
from typing import NoReturn, Optional, TypeVar, Union

from . import _core
from ._arguments import fraction_text, tells_unknown, whole_count
from ._program import program

F = TypeVar("F", bound="BaseFarm")


class OfThisProcess:
    """What a forked child must not use: its thread stayed in the parent."""

    __slots__ = ("_process",)

    def __init__(self) -> None:
        self._process = os.getpid()

    def __getattr__(self, name: str) -> NoReturn:
        made = type(self).__name__
        is_unset = any(name in getattr(base, "__slots__", ()) for base in type(self).__mro__)
        raise AttributeError(f"{made}.{name} is not set; expected {made}.__init__ to call super().__init__()"
                             if is_unset else f"{made} has no attribute '{name}'", name=name, obj=self)

    def _check_process(self) -> None:
        if os.getpid() != self._process:
            raise RuntimeError(f"{type(self).__name__}: made in process {self._process}, used in its "
                               f"child {os.getpid()}; expected one that the child made")


_open_farms: "weakref.WeakSet[BaseFarm]" = weakref.WeakSet()


def _close_farms() -> None:
    """At the end of the interpreter: closes all farms, and tells of those that a script has left open."""
    left = [farm for farm in _open_farms if farm._process == os.getpid()]
    for farm in left:
        farm.close()
    for farm in left:
        if not farm._is_of_render:
            farm._tell_open()


atexit.register(_close_farms)


class BaseFarm(OfThisProcess):
    """Who traces. A context manager; may be used by several threads."""

    __slots__ = ("_thread", "_is_of_render", "__weakref__")

    def __init__(self, thread: _core.FarmThread) -> None:
        super().__init__()
        self._thread: Optional[_core.FarmThread] = thread
        self._is_of_render = False  # which started it and closes it
        _open_farms.add(self)

    def _submit(self, task: _core.Task) -> None:
        self._check_process()
        if self._thread is None:
            raise RuntimeError(f"{type(self).__name__}: it is closed; expected one that is open")
        self._thread.submit(task)

    def close(self) -> None:
        """Cancels what still runs, and ends workers, sockets and folders. May be called again."""
        thread, self._thread = self._thread, None
        if thread is not None and os.getpid() == self._process:
            thread.close()
        _open_farms.discard(self)

    @property
    def closed(self) -> bool:
        """Whether close() was called."""
        return self._thread is None

    def __enter__(self: F) -> F:
        self._check_process()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_thread", None) is not None and os.getpid() == self._process:
            try:
                self._tell_open()
            finally:  # where warnings are errors, too
                self.close()

    def _tell_open(self) -> None:
        warnings.warn(f"{self!r} was not closed", ResourceWarning, source=self)

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"{type(self).__name__} cannot be pickled: it has threads and processes")


class LocalFarm(BaseFarm):
    """Worker processes on this machine, kept between renders.

    :param workers: how many processes; one a core if left out.
    :param threads: of each worker.
    :param verify: the share of tiles, such as .01 or "1%", that a second worker traces too.

    Raises UsageError for numbers out of their range: workers and threads are from 1 to 1024.
    """

    __slots__ = ("workers", "threads")

    @tells_unknown
    def __init__(self, workers: Optional[int] = None, threads: int = 1,
                 verify: Union[float, str] = 0) -> None:
        self._thread = None
        self.workers = None if workers is None else whole_count("workers", workers)
        self.threads = whole_count("threads", threads)
        program()  # Workers are its processes: ImportError tells where it is not of our version.
        super().__init__(_core.local_farm(self.workers, self.threads, fraction_text("verify", verify)))

    def __repr__(self) -> str:
        return f"LocalFarm(workers={self.workers}, threads={self.threads})"


class Threads(BaseFarm):
    """Threads of this process, kept between renders: for small pictures, which start at once.

    :param n: how many, from 1 to 1024; one a core if left out. Raises UsageError for others.
    """

    __slots__ = ("n",)

    @tells_unknown
    def __init__(self, n: Optional[int] = None) -> None:
        self._thread = None
        self.n = None if n is None else whole_count("n", n)
        super().__init__(_core.threads_here(self.n))

    def __repr__(self) -> str:
        return f"Threads({self.n or ''})"
