"""Arrays of the extension module as numpy has them."""
from __future__ import annotations

from typing import Any


def as_ndarray(array: Any) -> Any:
    """The array as numpy sees it, without a copy; itself where numpy is not installed."""
    try:
        import numpy
    except ImportError:
        return array
    return numpy.asarray(array)
