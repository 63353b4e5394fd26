"""The types of what stands for a part of a scene, for annotations."""
from __future__ import annotations

from typing import TYPE_CHECKING, Iterable, Sequence, Union

from ._types import ArrayLike, ColorLike

if TYPE_CHECKING:
    from typing import Any

    import numpy.typing as npt

    from ._core import Array
    from ._graph import Instances
    from ._messages import ColorInput, FloatInput, Light, Object, Scene, Texture
    from ._nodes import Node
    from ._placing import Shape
    from ._transforms import Transform

TextureLike = Union[str, "Texture", "Array", "npt.NDArray[Any]"]
ColorInputLike = Union["ColorInput", "Texture", ColorLike, "Array", "npt.NDArray[Any]"]
FloatInputLike = Union[float, "FloatInput", "Texture", "Array", "npt.NDArray[Any]"]
NodeLike = Union["Node", "Shape", "Light", "Object", "Instances"]
PartLike = Union[NodeLike, "Scene"]
PartsLike = Union[PartLike, Iterable[Union[PartLike, Iterable[PartLike]]]]
TransformsLike = Union[ArrayLike, Sequence["Transform"]]
