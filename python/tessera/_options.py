"""Keywords as options of the command line."""
from __future__ import annotations

import os
from collections.abc import Mapping, Set
from typing import Any, List, Tuple, Union

from . import _core
from ._arguments import of_few_digits, plain_text, several
from .errors import UsageError

Texts = List[Tuple[str, Union[bool, str]]]
_LISTS = ("size", "crop", "aovs", "frames")  # keywords that take several numbers or words
_TEXTS = {"assets": "the path of a folder", "environment": "the path of a file", "place": "text or several of them"}  # keywords of text alone
_SEPARATORS = {"size": "x", "frames": "-"}


def option_texts(keywords: Mapping[str, Any]) -> Texts:
    """The options of keywords that are not None: a bool for a flag, else the text that one types."""
    texts: Texts = []
    for name, value in keywords.items():
        is_one = (name != "place" or isinstance(value, (str, bytes, os.PathLike))
                  or not hasattr(value, "__iter__"))
        given = [value] if is_one else several(value, name)
        texts += [(name.replace("_", "-"), _text(name, each)) for each in given
                  if each is not None and not (name == "aovs" and _is_empty(each))]
    return texts


def _is_empty(value: Any) -> bool:
    return hasattr(value, "__len__") and len(value) == 0 and not isinstance(value, str)


def _text(name: str, value: Any) -> Union[bool, str]:
    if isinstance(value, (str, os.PathLike)):
        return plain_text(name, value)  # the list of options refuses the empty one
    if name in _TEXTS:
        raise TypeError(f"{name}: {value!r:.100}; expected {_TEXTS[name]}")
    if isinstance(value, bool):
        return value
    _core.refuse_masked(value, name)
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:  # a number of numpy
        return _text(name, value.item())
    if isinstance(value, (int, float)):
        return repr(value if isinstance(value, float) else of_few_digits(name, value))
    if name == "frames" and isinstance(value, range) and value.step > 0 and value:
        return f"{value[0]}-{value[-1]}x{value.step}"
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


_IN_PYTHON = (("WIDTHxHEIGHT", "(width, height)"), ("1920x1080", "(1920, 1080)"),
              ("X0,Y0,X1,Y1", "(x0, y0, x1, y1)"), ("0,0,64,64", "(0, 0, 64, 64)"),
              ("X0 < X1 and 0 <= Y0 < Y1", "x0 < x1 and 0 <= y0 < y1"),
              ("FIRST-LAST with 0 <= FIRST <= LAST", "(first, last) with 0 <= first <= last"),
              ("such as 0-23", "such as (0, 23)"), ("expected true or false", "expected True or False"))


def core_options(keywords: dict[str, Any], of_jobs: bool = False) -> _core.Options:
    """Keywords as the options of `tessera render`, or of `tessera submit`."""
    options = _core.Options(of_jobs)
    for option, text in option_texts(keywords):
        try:
            options.assign(option, text)
        except UsageError as error:
            # What was given, where the text is ours, and what is expected as Python has it.
            given = keywords[option.replace("-", "_")]
            typed = str(text).lower() if isinstance(text, bool) else text
            message = error.message.replace(f"'{typed}'", repr(given), 1)
            for of_command_line, of_python in _IN_PYTHON:
                message = message.replace(of_command_line, of_python)
            raise UsageError(message) from None
    return options
