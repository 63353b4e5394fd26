"""Keywords as options of the command line."""
from __future__ import annotations

import os
from typing import Any, List, Mapping, Tuple, Union

Texts = List[Tuple[str, Union[bool, str]]]
_SEPARATORS = {"size": "x", "frames": "-"}


def option_texts(keywords: Mapping[str, Any]) -> Texts:
    """The options of keywords that are not None: a bool for a flag, else the text that one types."""
    texts: Texts = []
    for name, value in keywords.items():
        several = [value] if name != "place" or isinstance(value, str) else value
        texts += [(name.replace("_", "-"), _text(name, each)) for each in several
                  if each is not None and not (name == "aovs" and _is_empty(each))]
    return texts


def _is_empty(value: Any) -> bool:
    return hasattr(value, "__len__") and len(value) == 0 and not isinstance(value, str)


def _text(name: str, value: Any) -> Union[bool, str]:
    if isinstance(value, (bool, str)):
        return value
    if isinstance(value, os.PathLike):
        path: str = os.fspath(value)
        return path
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:  # a number of numpy
        return _text(name, value.item())
    if hasattr(value, "__iter__") and not isinstance(value, bytes):
        return _SEPARATORS.get(name, ",").join(str(_text(name, part)) for part in value)
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{name}: {value!r}; expected a number, text or several of them")
