"""Shapes by other means than their fields."""
from __future__ import annotations

from typing import Any

from . import _messages
from ._core import Vec
from ._types import VectorLike


class Plane(_messages.Plane):
    """An endless plane: the points p with normal . p = offset, the normal being of length 1."""

    __slots__ = ()

    @classmethod
    def through(cls, a: VectorLike, b: VectorLike, c: VectorLike, **fields: Any) -> Plane:
        """The plane through three points; its normal is (b - a) x (c - a)."""
        corner = Vec(a)
        normal = (Vec(b) - corner).cross(Vec(c) - corner).normalized()
        return cls(normal, normal.dot(corner), **fields)
