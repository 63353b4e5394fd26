"""The exceptions of Tessera.

Messages read "place: what was found; what was expected". `except ValueError` catches wrong scenes
and wrong arguments, `except tessera.Error` everything that is not a bug.
"""
from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:
    from .picture import Image


class Error(Exception):
    """Base of what Tessera raises: the message, and what is known beside it."""

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


class MissingFile(SceneError, FileNotFoundError):
    """A file that is to be read is not there."""

    @classmethod
    def of(cls, path: str, expected: str) -> MissingFile:
        """That of a file at `path`."""
        missing = cls(f"{path}: there is no such file; expected {expected}", place=path)
        missing.filename = path
        return missing


class UsageError(Error, ValueError):
    """An argument has a value that it cannot have."""

    code = 2


class RenderError(Error, RuntimeError):
    """Rendering or writing failed. `image` is what was done of the picture, holes marked, and `stats`
    what is known of it, where there is one."""

    image: Optional["Image"] = None
    stats: Optional[dict[str, Any]] = None


class FarmError(RenderError, ConnectionError):
    """A farm cannot be reached, or fell silent."""


class Refused(FarmError, PermissionError):
    """A farm does not accept the key."""


class Cancelled(Error):
    """The task was cancelled before it was done. `image` is what was done of the picture, if any."""

    code = 4
    image: Optional["Image"] = None
    stats: Optional[dict[str, Any]] = None


class SceneWarning(UserWarning):
    """Something in a file was read otherwise than might be expected."""


class PrecisionWarning(UserWarning):
    """Numbers were rounded by more than their use bears."""


def scene_error(found: str, expected: str, path: str, value: object) -> SceneError:
    """The error of a value that is no part of a scene: where it was made and the way to it."""
    from ._value import where
    made = where(value)
    place = f"{made[0]}:{made[1]}" if made else ""
    beginning = "".join(f"{part}: " for part in (place, path) if part)
    message = f"{beginning}{found}{f'; expected {expected}' if expected else ''}"
    return SceneError(message, place=place, path=path)


_CLASS_OF_CODE: dict[int, type[Error]] = {1: SceneError, 2: UsageError, 3: RenderError, 4: Cancelled}


def from_core(message: str, code: int) -> Error:
    """The exception for an error of the renderer with that exit code. Options are called as Python
    has them: "--min-spp" is min_spp."""
    if code == UsageError.code:
        message = re.sub(r"--([a-z0-9][a-z0-9-]*)", lambda m: m.group(1).replace("-", "_"), message)
    place = re.match(r"(.+?:\d+(?::\d+)?): ", message)
    return _CLASS_OF_CODE.get(code, RenderError)(message, place=place.group(1) if place else "")
