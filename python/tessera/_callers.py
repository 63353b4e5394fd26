"""Where in the user's script a value is made, and a warning belongs."""
from __future__ import annotations

import sys
from types import CodeType
from typing import Any, Optional, Tuple, Union

Place = Tuple[Union[CodeType, str], int]


def here() -> Optional[Place]:
    """Where in the user's script a value is being made."""
    frame: Any = sys._getframe(2)
    while frame is not None and frame.f_globals.get("__package__") == __package__:
        frame = frame.f_back
    return None if frame is None else (frame.f_code, frame.f_lasti)


def level_of_caller() -> int:
    """For `warnings.warn` of the function that asks: how far up the stack the user's script is."""
    frame: Any = sys._getframe(1)
    level = 1
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        frame = frame.f_back
        level += 1
    return level


def where(value: Any) -> Optional[Tuple[str, int]]:
    """The file and line that made a value."""
    place = getattr(value, "_place", None)
    if place is None or isinstance(place[0], str):
        return place
    code, at = place
    lines = (line for begin, end, line in code.co_lines() if begin <= at < end and line)
    return code.co_filename, next(lines, code.co_firstlineno)
