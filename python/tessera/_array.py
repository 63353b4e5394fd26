"""Arrays of the extension module as numpy has them."""
from __future__ import annotations

from typing import Any

from . import _core
from .errors import UsageError


def plain_array(name: str, value: Any) -> Any:
    """What was given as `name` as an array of numpy. Refuses masked values."""
    from ._numpy import numpy
    try:
        array = numpy.asarray(value)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name}: {value!r:.100}; expected an array of numbers") from error
    _core.refuse_masked(value, name)
    return array


def as_ndarray(array: Any) -> Any:
    """The array as numpy sees it, without a copy; itself where numpy is not installed."""
    try:
        import numpy
    except ImportError:
        return array
    return numpy.asarray(array)
