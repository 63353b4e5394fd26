"""Keywords as options of the command line."""
from __future__ import annotations

import math
import operator
import os
from collections.abc import Mapping, Set
from typing import Any, List, Optional, Tuple, Union

from ._types import Path
from ._value import several
from .errors import UsageError

Texts = List[Tuple[str, Union[bool, str]]]
_LISTS = ("size", "crop", "aovs", "frames")  # keywords that take several numbers or words
_TEXTS = {"assets": "the path of a folder", "place": "text or several of them"}  # keywords of text alone
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
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:  # a number of numpy
        return _text(name, value.item())
    if isinstance(value, (int, float)):
        return repr(value if isinstance(value, float) else _of_few_digits(name, value))
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


def named_text(name: str, given: Union[str, os.PathLike[str]]) -> str:
    """`plain_text` that is not empty: None, not an empty text, is what is not given."""
    text = plain_text(name, given)
    if not text:
        raise UsageError(f"{name}: ''; expected text that is not empty")
    return text


def fraction_text(name: str, given: Union[float, str]) -> str:
    """A share, such as .01 or "1%", as the command line takes it."""
    return named_text(name, given) if isinstance(given, str) else repr(number(name, given))


def folder_text(assets: Optional[Path]) -> str:
    """The folder that `assets` names, which is to be there; empty where none is given."""
    return "" if assets is None else named_text("assets", assets)


def file_name(path: Path) -> bytes:
    """The name of a file to C++, whose names need not be UTF-8."""
    if not isinstance(path, (str, bytes, os.PathLike)):
        raise TypeError(f"path: {path!r:.100}; expected the name of a file")
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
        try:
            return float(value)
        except OverflowError:
            raise UsageError(f"{name}: a number above all that a float has; expected a smaller one") from None
        except TypeError:  # as an array of several
            pass
    raise TypeError(f"{name}: {value!r:.100}; expected a number")


def whole(name: str, value: Any) -> int:
    """A whole number; TypeError for all else, True and 2.0 among it."""
    try:
        if not isinstance(value, bool):
            return _of_few_digits(name, operator.index(value))
    except TypeError:
        pass
    raise TypeError(f"{name}: {value!r:.100}; expected a whole number")


def _of_few_digits(name: str, value: int) -> int:
    """The number. Refuses one with too many digits to print."""
    if value.bit_length() > 256:
        raise UsageError(f"{name}: a whole number of {value.bit_length()} bits; expected a smaller one")
    return value


def frame_number(name: str, value: Any) -> int:
    """The number of an animation's frame."""
    frame, least, most = whole(name, value), -2**31, 2**31 - 1
    if not least <= frame <= most:
        raise UsageError(f"{name}: {frame}; expected a whole number from {least} to {most}")
    return frame


def seconds(name: str, value: Any) -> float:
    """How long to wait; infinite: without end."""
    found = number(name, value)
    if math.isnan(found):
        raise UsageError(f"{name}: {found}; expected seconds")
    return found


def boolean(name: str, value: Any) -> bool:
    """True or False, of numpy too; TypeError for all else."""
    if isinstance(value, bool) or getattr(value, "dtype", None) == bool:
        return bool(value)
    raise TypeError(f"{name}: {value!r:.100}; expected True or False")
