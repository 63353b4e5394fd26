"""Keywords as options of the command line."""
from __future__ import annotations

import operator
import os
from collections.abc import Mapping, Set
from typing import Any, List, Tuple, Union

from ._types import Path
from ._value import several
from .errors import UsageError

Texts = List[Tuple[str, Union[bool, str]]]
_LISTS = ("size", "crop", "aovs", "frames")  # keywords that take several numbers or words
_SEPARATORS = {"size": "x", "frames": "-"}


def option_texts(keywords: Mapping[str, Any]) -> Texts:
    """The options of keywords that are not None: a bool for a flag, else the text that one types."""
    texts: Texts = []
    for name, value in keywords.items():
        given = [value] if name != "place" or isinstance(value, str) else several(value, name)
        texts += [(name.replace("_", "-"), _text(name, each)) for each in given
                  if each is not None and not (name == "aovs" and _is_empty(each))]
    return texts


def _is_empty(value: Any) -> bool:
    return hasattr(value, "__len__") and len(value) == 0 and not isinstance(value, str)


def _text(name: str, value: Any) -> Union[bool, str]:
    if isinstance(value, bool):
        return value
    if isinstance(value, (str, os.PathLike)):
        return plain_text(name, value)
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:  # a number of numpy
        return _text(name, value.item())
    if isinstance(value, (int, float)):
        return repr(value)
    if name in _LISTS and hasattr(value, "__iter__") and not isinstance(value, (bytes, Mapping)) and (
            name == "aovs" or not isinstance(value, Set)):  # which has no order
        return _SEPARATORS.get(name, ",").join(_part(name, part) for part in several(value, name))
    expected = "a number, text or several of them" if name in _LISTS else "a number or text"
    raise TypeError(f"{name}: {value!r:.100}; expected {expected}")


def _part(name: str, value: Any) -> str:
    """A number or text of several."""
    if hasattr(value, "__iter__") and not isinstance(value, str) and getattr(value, "ndim", 1) > 0:
        raise TypeError(f"{name}: {value!r:.100} among several; expected numbers or text")
    return str(_text(name, value))


def plain_text(name: str, given: Union[str, os.PathLike[str]]) -> str:
    """Text, or the path of a file, as options and scenes hold it: UTF-8 without a NUL.

    Raises UsageError for other text, `name` being the keyword's."""
    if not isinstance(given, (str, os.PathLike)):
        raise TypeError(f"{name}: {given!r:.100}; expected text")
    text = os.fspath(given)
    if isinstance(text, bytes):
        text = os.fsdecode(text)
    try:
        text.encode()
    except UnicodeEncodeError:
        raise UsageError(f"{name}: {text!r:.200}; expected text that is UTF-8") from None
    return _without_nul(name, text)


def file_name(path: Path) -> bytes:
    """The name of a file to C++, whose names need not be UTF-8."""
    try:
        name = os.fsencode(path)
    except UnicodeEncodeError:
        raise UsageError(f"path: {os.fspath(path)!r:.200}; expected the name of a file") from None
    _without_nul("path", os.fsdecode(name))
    return name


def _without_nul(name: str, text: str) -> str:
    if "\0" in text:
        raise UsageError(f"{name}: {text!r:.200} with a NUL; expected text without one")
    return text


def number(name: str, value: Any) -> float:
    """Any number that has a float's value; TypeError for all else."""
    if not isinstance(value, bool) and (hasattr(value, "__float__") or hasattr(value, "__index__")):
        return float(value)
    raise TypeError(f"{name}: {value!r:.100}; expected a number")


def whole(name: str, value: Any) -> int:
    """A whole number; TypeError for all else, True and 2.0 among it."""
    try:
        if not isinstance(value, bool):
            return operator.index(value)
    except TypeError:
        pass
    raise TypeError(f"{name}: {value!r:.100}; expected a whole number")
