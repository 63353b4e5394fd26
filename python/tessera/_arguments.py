"""What calls are given: checks whose errors name the keyword, and the nearest name for a wrong one."""
from __future__ import annotations

import functools
import math
import operator
import os
from typing import Any, Callable, Iterable, List, Mapping, NoReturn, Optional, SupportsIndex, TypeVar, Union

from . import _core
from ._types import Path
from .errors import UsageError

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])


def refuse_attribute(module: str, name: str, public: List[str]) -> NoReturn:
    """Says that a module has no such attribute, and which public one is nearest."""
    hint = "" if name.startswith("_") else nearest(name, public)
    raise AttributeError(f"module '{module}' has no attribute '{name}'{hint}")


def refuse_unknown(function: str, unknown: Mapping[str, Any], known: List[str]) -> NoReturn:
    """Says that a function has no such keyword, and which is nearest, or else which it has."""
    name = next(iter(unknown))
    hint = nearest(name, known) or f"; expected one of {', '.join(each for each in known if each != 'unknown')}"
    raise TypeError(f"{function}() has no keyword '{name}'{hint}")


def tells_unknown(function: F) -> F:
    """Has a function tell which keyword is nearest to one that it lacks."""
    code = function.__code__
    known = [name for name in code.co_varnames[:code.co_argcount + code.co_kwonlyargcount] if name != "self"]
    called = function.__qualname__.replace(".__init__", "").rpartition(".")[2]

    @functools.wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        for name in named:
            if name not in known:
                refuse_unknown(called, {name: None}, known)
        return function(*args, **named)

    return call  # type: ignore[return-value]


def nearest(name: str, known: List[str]) -> str:
    """"; did you mean 'x'?" for the name that is most like one; or nothing."""
    near = _core.nearest_name(name.encode(errors="replace").decode(), known)
    word = name.rpartition("_")[2]
    begun = [each for each in known if name.startswith(each + "_")]
    if begun and near and not _core.nearest_name(word, [near.rpartition("_")[2]]):
        near = max(begun, key=len)  # 'diffuse' for 'diffuse_color', and not 'diffuse_model'
    return f"; did you mean '{near}'?" if near else ""


def with_article(value: object) -> str:
    """What a value is, for messages: "an int"."""
    name = type(value).__name__
    return f"{'an' if name[:1] in 'AEIOaeio' else 'a'} {name}"


def several(items: Iterable[T], name: str, expected: str = "a sequence") -> List[T]:
    """A list of what was given as `name`."""
    if not (hasattr(items, "__iter__") or hasattr(items, "__getitem__")):
        raise TypeError(f"{name}: {items!r:.100}; expected {expected}")
    try:
        return list(items)
    except NotImplementedError:
        view: object = items
        if not isinstance(view, memoryview):
            raise
    raise TypeError(f"{name}: a memoryview of shape {view.shape}; expected {expected}")


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


def file_name(path: Path, keyword: str = "path") -> bytes:
    """The name of a file to C++, whose names need not be UTF-8."""
    if not isinstance(path, (str, bytes, os.PathLike)):
        raise TypeError(f"{keyword}: {path!r:.100}; expected the name of a file")
    try:
        name = os.fsencode(path)
    except UnicodeEncodeError:
        raise UsageError(f"{keyword}: {os.fspath(path)!r:.200}; expected the name of a file") from None
    _without_nul(keyword, os.fsdecode(name))
    return name


def _without_nul(name: str, text: str) -> str:
    if "\0" in text:
        raise UsageError(f"{name}: {text!r:.200} with a NUL; expected text without one")
    return text


def number(name: str, value: Any) -> float:
    """Any number that has a float's value; TypeError for all else. Refuses masked values."""
    _core.refuse_masked(value, name)
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
            return of_few_digits(name, operator.index(value))
    except TypeError:
        pass
    raise TypeError(f"{name}: {value!r:.100}; expected a whole number")


def whole_count(name: str, value: SupportsIndex, least: int = 1) -> int:
    """A number of processes or threads, which the keyword `name` has."""
    most = _core.most_threads
    count = whole(name, value)
    if not least <= count <= most:
        raise UsageError(f"{name}: {count}; expected a whole number from {least} to {most}")
    return count


def of_few_digits(name: str, value: int) -> int:
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
    if isinstance(value, bool) or (getattr(value, "dtype", None) == bool and value.ndim == 0):
        return bool(value)
    raise TypeError(f"{name}: {value!r:.100}; expected True or False")
