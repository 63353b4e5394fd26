"""The exceptions of Tessera.

Messages read "place: what was found; what was expected". `except ValueError` catches wrong scenes
and wrong values of arguments; arguments of wrong types are a TypeError, as in all of Python.
"""
from __future__ import annotations

import contextlib
import errno
import re
from typing import TYPE_CHECKING, Any, Iterator, Optional, Tuple

from . import _core
from ._callers import where

if TYPE_CHECKING:
    from .picture import Image


class Error(Exception):
    """Base of the classes below: the message, and what is known beside it."""

    code = 3

    def __init__(self, message: str = "", *, place: str = "", suggestion: Optional[str] = None):
        super().__init__(message)
        self.message = message
        self.place = place
        found = re.search(r"did you mean '([^']+)'", message)
        self.suggestion = suggestion or (found.group(1) if found else None)

    def __str__(self) -> str:
        return self.message  # an OSError would put its errno and file name here


class SceneError(Error, ValueError):
    """The scene is wrong, or a file that it names."""

    code = 1

    def __init__(self, message: str = "", *, place: str = "", path: str = "",
                 suggestion: Optional[str] = None):
        super().__init__(message, place=place, suggestion=suggestion)
        self.path = path


class NestingError(SceneError):
    """A value lies inside itself, or deeper than a scene may be."""


class MissingFile(SceneError, FileNotFoundError):
    """A file that is to be read is not there."""

    def __init__(self, message: str = "", *, filename: str = "", suggestion: Optional[str] = None):
        super().__init__(message, place=filename, suggestion=suggestion)
        self.errno, self.filename = errno.ENOENT, filename

    def __reduce__(self) -> Tuple[Any, ...]:
        state = {**self.__dict__, "errno": self.errno, "filename": self.filename}
        return type(self), (self.message,), state

    @classmethod
    def of(cls, path: str, expected: str) -> MissingFile:
        """That of a file at `path`."""
        return cls(f"{path}: there is no such file; expected {expected}", filename=path)


class UsageError(Error, ValueError):
    """An argument has a value that it cannot have."""

    code = 2


class RenderError(Error, RuntimeError):
    """Rendering or writing failed. `image` is what was done of the picture, holes marked, and `stats`
    what is known of it, where there is one."""

    image: Optional["Image"] = None
    stats: Optional[dict[str, Any]] = None


class FarmError(RenderError, ConnectionError):
    """A farm cannot be reached, or fell silent. `endpoint` is that of its coordinator, as
    "tcp://host:7117"; None where it is not known."""

    endpoint: Optional[str] = None

    def __init__(self, message: str = "", *, endpoint: Optional[str] = None, place: str = "",
                 suggestion: Optional[str] = None):
        super().__init__(message, place=place, suggestion=suggestion)
        self.endpoint = endpoint


class Refused(FarmError, PermissionError):
    """A farm does not accept the key."""


class Cancelled(Error):
    """The task was cancelled before it was done. `image` is what was done of the picture, if any."""

    code = 4
    image: Optional["Image"] = None
    stats: Optional[dict[str, Any]] = None


class SceneWarning(UserWarning):
    """Something in a scene or file is taken otherwise than might be expected."""


class PrecisionWarning(UserWarning):
    """Numbers were rounded by more than their use bears."""


def scene_error(found: str, expected: str, path: str, value: object,
                kind: type[SceneError] = SceneError) -> SceneError:
    """The error of a value that is no part of a scene: where it was made and the way to it."""
    made = where(value)
    place = f"{made[0]}:{made[1]}" if made else ""
    beginning = "".join(f"{part}: " for part in (place, path) if part)
    message = f"{beginning}{found}{f'; expected {expected}' if expected else ''}"
    return kind(message, place=place, path=path)


@contextlib.contextmanager
def nesting_ends(value: object, path: str = "") -> Iterator[None]:
    """For what calls itself for the values inside `value`: tells of those without an end, and where
    the value was made or which argument it is."""
    try:
        yield
    except RecursionError:
        raise scene_error(*_core.nested_too_deep, path, value, NestingError) from None


_CLASS_OF_CODE: dict[int, type[Error]] = {1: SceneError, 2: UsageError, 3: RenderError, 4: Cancelled}


def in_python(message: str) -> str:
    """A message of the renderer whose options are called as Python has them: "--min-spp" is min_spp."""
    return re.sub(r"(?<![^\s(])--([a-z0-9][a-z0-9-]*)", lambda m: m.group(1).replace("-", "_"), message)


def from_core(message: str, code: int, file: str) -> Error:
    """The exception for an error of the renderer with that exit code, in that file if in any."""
    message = in_python(message)
    if code == UsageError.code:
        return UsageError(re.sub(r"^JOB\b", "job", message))  # as the command line calls it
    place = re.match(r"(.+?:\d+(?::\d+)?): ", message)
    return _CLASS_OF_CODE.get(code, RenderError)(message, place=place.group(1) if place else file)
