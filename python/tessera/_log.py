"""What C++ logs, for the logger "tessera"."""
from __future__ import annotations

import contextlib
from typing import Iterator

from . import _core


def pass_on_log() -> None:
    """Gives what C++ logged to the logger "tessera"."""
    logged = _core.take_log()
    if not logged:
        return
    import logging
    for level, message in logged:
        logging.getLogger("tessera").log(max(level, 1) * 10, message)


@contextlib.contextmanager
def logged_at_end() -> Iterator[None]:
    """Passes on, at the end of the block, what C++ logged in it."""
    try:
        yield
    finally:
        pass_on_log()
