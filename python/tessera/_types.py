"""The types of what is taken and given, for annotations."""
from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Sequence, Tuple, Union

if TYPE_CHECKING:
    import os
    from typing import Any, Protocol

    import numpy as np
    import numpy.typing as npt

    from ._core import Array, Vec

    class HasArray(Protocol):
        """What converts itself, such as a tensor."""

        def __array__(self) -> npt.NDArray[Any]: ...

    AnyArray = npt.NDArray[Any]
    Bools = npt.NDArray[np.bool_]
    Doubles = npt.NDArray[np.float64]
    Floats = npt.NDArray[np.float32]
    Integers = npt.NDArray[np.int64]
    Numbers = npt.NDArray[np.uint32]
    Rows = npt.NDArray[np.floating[Any]]  # (n, 3)
    ArrayShape = Tuple[int, ...]

# numpy is not imported to take its arrays, which have the buffer protocol.
Path = Union[str, "os.PathLike[str]"]
VectorLike = Union["Vec", Sequence[float], "npt.NDArray[Any]"]
ArrayLike = Union["Array", "npt.NDArray[Any]", "HasArray", memoryview,
                  Sequence[Union[float, VectorLike, Sequence[VectorLike]]]]
ColorLike = Union[str, float, VectorLike]

Size = Union[str, Tuple[int, int]]
Crop = Union[str, Tuple[int, int, int, int]]
Aovs = Union["Aov", Literal["all"], Sequence["Aov"]]

# Words of options and settings that are text in messages.
Accelerator = Literal["bvh", "bvh-splits", "octree", "nonuniform-octree", "embree", "linear"]
Integrator = Literal["auto", "whitted", "path", "normals", "depth", "albedo", "ids", "wireframe", "cost", "samples",
                     "error"]
Shadows = Literal["on", "by-light", "off"]
FloatAov = Literal["albedo", "normal", "depth", "position", "variance", "samples"]
Aov = Literal[FloatAov, "id", "origin", "primitive"]
Pattern = Literal["center", "owen-sobol", "centered-grid", "corner-grid", "independent", "blue-noise"]
Cull = Literal["none", "back", "front"]
InsideMethod = Literal["parity", "winding"]
OpenShapes = Literal["warn", "error"]
HitField = Literal["t", "instance", "primitive", "uv"]
ToneMap = Literal["clamp", "reinhard", "reinhard-luminance", "filmic", "linear"]
Transfer = Literal["srgb", "display", "gamma"]
View = Literal["front", "back", "left", "right", "side", "top", "bottom", "iso"]
Up = Literal["y", "z"]
X3dColor = Literal["display", "linear"]
X3dShadows = Literal["on", "file", "off"]
X3dTexture = Literal["version", "replace", "modulate"]
