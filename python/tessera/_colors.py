"""Colours: linear RGB, as numbers or from text."""
from __future__ import annotations

import colorsys
import itertools
import math
from typing import Any, NamedTuple

from . import _core
from ._arguments import nearest, number
from ._core import Vec
from ._types import ColorLike
from .errors import SceneError, UsageError

class Color(NamedTuple):
    """A colour in linear RGB; 1 is full reflectance or unit radiance. Sums, differences and multiples
    are those of a Vec."""

    r: float
    g: float
    b: float

    def __add__(self, other: Any) -> Any:
        return _as_color(Vec(self).__add__(other))

    def __radd__(self, other: Any) -> Any:
        return _as_color(Vec(self).__radd__(other))

    def __sub__(self, other: Any) -> Any:
        return _as_color(Vec(self).__sub__(other))

    def __rsub__(self, other: Any) -> Any:
        return _as_color(Vec(self).__rsub__(other))

    def __mul__(self, factor: Any) -> Any:
        return _as_color(Vec(self).__mul__(factor))

    def __rmul__(self, factor: Any) -> Any:
        return _as_color(Vec(self).__rmul__(factor))

    def __truediv__(self, divisor: Any) -> Any:
        return _as_color(Vec(self).__truediv__(divisor))

    def __neg__(self) -> Color:
        return Color(-self.r, -self.g, -self.b)


def _as_color(result: Any) -> Any:
    """The colour of a Vec; arrays and NotImplemented as they are."""
    return Color(*result) if isinstance(result, Vec) else result


def color(given: ColorLike) -> Color:
    """The colour of a name ("red"), of "#c33" or "#cc3333" (sRGB, decoded), of three numbers, or grey
    of one. Raises SceneError for other text, UsageError for all else."""
    if isinstance(given, str):
        return _from_text(given)
    numbers: Any = given
    _core.refuse_masked(numbers, "color")
    if hasattr(numbers, "__float__") and not hasattr(numbers, "__iter__"):
        numbers = 3 * (numbers,)
    try:
        parts = [] if isinstance(numbers, bytes) else [number("color", part) for part in itertools.islice(numbers, 4)]
    except TypeError:
        parts = []
    if len(parts) != 3:
        raise UsageError(f"color: {given!r:.100}; expected a name, '#rrggbb', three numbers or one")
    return Color(*parts)


def hsl(hue: float, saturation: float, lightness: float) -> Color:
    """The colour of a hue in degrees, a saturation and a lightness from 0 to 1, decoded from sRGB.
    Raises UsageError for others."""
    for name, share in (("saturation", saturation), ("lightness", lightness)):
        if not 0 <= number(name, share) <= 1:
            raise UsageError(f"{name}: {share}; expected a number from 0 to 1")
    if not math.isfinite(number("hue", hue)):
        raise UsageError(f"hue: {hue}; expected a finite number of degrees")
    return Color(*map(_core.srgb_to_linear, colorsys.hls_to_rgb(hue / 360 % 1, lightness, saturation)))


def _from_text(text: str) -> Color:
    from ._color_names import COLORS
    word = text.strip().lower()
    digits = word[1:] if word.startswith("#") else COLORS.get(word.replace(" ", ""), "")
    if len(digits) == 3:
        digits = "".join(2 * digit for digit in digits)
    if len(digits) != 6 or not set(digits) <= set("0123456789abcdef"):
        hint = nearest(word, list(COLORS))
        raise SceneError(f"'{text}': no colour; expected a name or '#rrggbb'{hint}")
    r, g, b = (_core.srgb_to_linear(int(digits[i:i + 2], 16) / 255) for i in (0, 2, 4))
    return Color(r, g, b)
