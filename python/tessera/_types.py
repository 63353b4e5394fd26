"""The types of what is taken, for annotations."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Sequence, Union

from ._core import Array, Vec

if TYPE_CHECKING:
    from ._graph import Instances
    from ._messages import ColorInput, FloatInput, Light, Node, Object, Shape, Texture

# numpy is neither needed nor imported: its arrays are taken by the buffer protocol.
ArrayLike = Union[Array, Any]
VectorLike = Union[Vec, Sequence[float], Any]
ColorLike = Union[str, float, Sequence[float], Any]
ColorInputLike = Union["ColorInput", "Texture", ColorLike]
FloatInputLike = Union[float, "FloatInput", "Texture"]
NodeLike = Union["Node", "Shape", "Light", "Object", "Instances"]
