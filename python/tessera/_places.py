"""Which line of a script made the part of a scene that an error of the renderer names."""
from __future__ import annotations

import contextlib
import re
from typing import Any, Iterator, List, Optional, Tuple, Union

from . import _core
from ._callers import where
from ._log import logged_at_end
from ._messages import Light, Scene, Shape
from .errors import SceneError

_SEGMENT = re.compile(r"(\w+)(?: '(.*?)'(?= > |$)| (\d+))?(?: > |$)")
_BEGINNING = re.compile(r"((?:\w+(?: '.*?'| \d+)? > )*\w+(?: '.*?'| \d+)?): ", re.DOTALL)
_LISTS = {"node": ("nodes", "children", "operands"), "operand": ("operands",),
          "camera": ("cameras",)}
_ALONE = {"shape": Shape, "light": Light}
_NAMED = ("material", "texture", "object")


def _step(value: Any, kind: str, name: Optional[str], number: Optional[str]) -> Optional[Tuple[Any, str]]:
    """The part of a value that "node 'hall'", "node 3" or "shape" means, and its name in Python."""
    if isinstance(value, _ALONE.get(kind, ())):
        return value, ""  # which stands in a list of nodes by itself
    for attribute in _LISTS.get(kind, ()):
        count = 0  # of nodes before
        for index, part in enumerate(getattr(value, attribute, None) or []):
            if _is_meant(part, name, None if number is None else int(number) - count):
                return part, f"{attribute}[{index}]"
            count += _node_count(part)
        if attribute == "children" and number is not None and int(number) == count + 1:
            return value, ""  # the shape of a billboard, which lies one node deeper
    part = getattr(value, kind, None) if name is None and number is None else None
    return None if part is None else (part, kind)


def _is_several(part: Any) -> bool:
    """Whether the part is Instances, which stand for several nodes."""
    return hasattr(part, "transforms")


def _node_count(part: Any) -> int:
    return len(part) if _is_several(part) else 1


def _is_meant(part: Any, name: Optional[str], number: Optional[int]) -> bool:
    """Whether a name, or a number from that of the part's first node on, means the part; where
    neither is told, it is the only one."""
    if number is not None:
        return 1 <= number <= _node_count(part)
    if name is None:
        return True
    if _is_several(part):
        return name in (part.names or ())
    return getattr(part, "name", None) == name


def _named_part(scene: Scene, kind: str, name: str) -> Optional[Tuple[Any, str]]:
    """The material, texture or object of that name, or that got it by its digest, and its path."""
    for of_kind, of_name, path, value in _core.named_parts(scene):
        if (of_kind, of_name) == (kind, name):
            return value, path
    return None


@contextlib.contextmanager
def located_errors(scene: Union[Scene, str]) -> Iterator[None]:
    """Errors of a scene that was made in Python tell where; those of a file do so themselves. Passes on
    what is logged meanwhile."""
    try:
        with logged_at_end():
            yield
    except SceneError as error:
        raise error if isinstance(scene, str) else _located(scene, error) from None


def _located(scene: Scene, error: SceneError) -> SceneError:
    """The error with the script's line and the path of what it names; itself where those are not
    known. Errors of the renderer read "node 'hall' > node 3 > shape: sphere.radius is -1; ..."."""
    text = error.message[len("scene: "):] if error.message.startswith("scene: ") else error.message
    beginning = _BEGINNING.match(text)
    if beginning is None:
        return error
    rest = text[beginning.end():]
    value: Any = scene
    path: List[str] = []
    for kind, name, number in (found.groups() for found in _SEGMENT.finditer(beginning.group(1))):
        if kind in _NAMED:  # which may stand anywhere in the scene
            path.clear()
            step = _named_part(scene, kind, name or "")
        else:
            step = _step(value, kind, name, number)
        if step is None:
            return error
        value = step[0]
        path.append(step[1])
    place = where(value)
    for field in re.split(" is | has ", rest)[0].split("."):
        if not (field.isidentifier() and hasattr(value, field)):
            continue
        path.append(field)
        value = getattr(value, field)
        if value is None:  # the zeros are none of the script's
            rest = rest.replace(" is (0, 0, 0)", " is not set", 1)
        place = where(value) or place
    line = "" if place is None else f"{place[0]}:{place[1]}"  # none where it was loaded
    whole = ".".join(filter(None, path))
    return SceneError(": ".join(filter(None, (line, whole, rest))), place=line, path=whole)
