"""Transforms, written as on paper: `translate(...) @ rotate(...) @ scale(...)`."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterable, List, Literal, Optional, Tuple, Union, overload

from . import _core, _messages
from ._arguments import several
from ._array import as_ndarray, plain_array
from ._messages import AxisAngle, LookAt, Matrix, TransformKey, TransformStep
from ._types import ArrayLike, VectorLike
from .errors import UsageError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


class Transform(_messages.Transform):
    """A chain of steps; the first acts last. Transforms compose by `@`, which applies them to
    points as well: a Vec, or arrays of shape (..., 3)."""

    __slots__ = ()

    @overload
    def __matmul__(self, other: Transform) -> Transform: ...
    @overload
    def __matmul__(self, other: _core.Vec) -> _core.Vec: ...
    @overload
    def __matmul__(self, other: ArrayLike) -> npt.NDArray[np.float64]: ...
    def __matmul__(self, other: Any) -> Any:
        if isinstance(other, _messages.Transform):
            return Transform([*self.steps, *other.steps])
        if isinstance(other, (str, bytes)) or not hasattr(other, "__len__"):
            return NotImplemented
        from ._numpy import numpy
        points = plain_array("points", other)
        if not numpy.can_cast(points.dtype, numpy.float64):
            raise TypeError(f"points: dtype {points.dtype}; expected float64 or what fits into it")
        points = points.astype(numpy.float64, copy=False)
        if points.ndim == 0 or points.shape[-1] != 3:
            raise UsageError(f"points: shape {points.shape}; expected (..., 3)")
        rows = numpy.asarray(self.array)
        moved = points @ rows[:, :3].T + rows[:, 3]
        return _core.Vec(moved) if isinstance(other, _core.Vec) else moved

    @property
    def array(self) -> npt.NDArray[np.float64]:
        """The three upper rows of the matrix: a (3, 4) array of float64."""
        array: npt.NDArray[np.float64] = as_ndarray(_core.transform_matrix(self))
        return array

    def inverse(self) -> Transform:
        """The transform that undoes this one, as a matrix. Raises UsageError where there is none, as for
        a scale of 0."""
        return Transform([TransformStep(matrix=Matrix(_core.inverse_matrix(self)))])


def _is_one(function: str, y: Any, z: Any) -> bool:
    """Whether one argument was given; raises TypeError where it was two."""
    if (y is None) != (z is None):
        raise TypeError(f"{function}() of 2 numbers; expected 1 or 3")
    return y is None


@overload
def translate(x: VectorLike, y: None = None, z: None = None) -> Transform: ...
@overload
def translate(x: float, y: float, z: float) -> Transform: ...
def translate(x: Any, y: Any = None, z: Any = None) -> Transform:
    """Moves by (x, y, z), or by a vector, in metres. Raises TypeError for two numbers."""
    return Transform([TransformStep(translate=x if _is_one("translate", y, z) else (x, y, z))])


def rotate(axis: Union[Literal["x", "y", "z"], VectorLike], degrees: float) -> Transform:
    """Turns by so many `degrees` about an axis through the origin ("x", "y", "z" or a vector), by the
    right-hand rule. Raises UsageError for other text."""
    axes = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    if isinstance(axis, str) and axis not in axes:
        raise UsageError(f"axis: '{axis}'; expected 'x', 'y', 'z' or a vector")
    about = axes[axis] if isinstance(axis, str) else axis
    return Transform([TransformStep(rotate=AxisAngle(about, degrees))])


@overload
def scale(x: Union[float, VectorLike], y: None = None, z: None = None) -> Transform: ...
@overload
def scale(x: float, y: float, z: float) -> Transform: ...
def scale(x: Any, y: Any = None, z: Any = None) -> Transform:
    """Scales by one factor, a number without unit, or by one for each axis. Raises TypeError for two numbers."""
    if _is_one("scale", y, z):
        is_number = getattr(x, "ndim", None) == 0 or not hasattr(x, "__len__")
        factors = (x, x, x) if is_number else x
    else:
        factors = (x, y, z)
    return Transform([TransformStep(scale=factors)])


def matrix(rows: ArrayLike) -> Transform:
    """The transform of a (3, 4) or (4, 4) matrix that acts on columns; a fourth row is 0 0 0 1. Raises
    UsageError for others."""
    try:
        array = _core.take_matrices(rows, "matrix")
    except ValueError as error:
        raise UsageError(str(error).replace("(any, 3, 4) or (any, 4, 4)", "(3, 4) or (4, 4)")) from None
    if array.shape[0] != 1:
        raise UsageError(f"matrix: {array.shape[0]} matrices; expected one")
    numbers = memoryview(array).cast("B").cast("d").tolist()  # type: ignore[arg-type]
    return Transform([TransformStep(matrix=Matrix(numbers))])


def look_at(eye: VectorLike, target: VectorLike, up: Optional[VectorLike] = None) -> Transform:
    """Places a frame at the point `eye` whose -z axis points at the point `target`, both in metres, and whose
    y axis is as near to the direction `up` as can be. What uses it raises SceneError where there is no
    such frame."""
    return Transform([TransformStep(look_at=LookAt(eye, target, up))])


def keys(pairs: Iterable[Tuple[float, Transform]]) -> List[TransformKey]:
    """The keys of a motion, from pairs of time, in seconds, and transform. Raises UsageError for what is no
    pair."""
    made = []
    for pair in several(pairs, "pairs"):
        both: List[Any] = several(pair, "pairs")
        if len(both) != 2:
            raise UsageError(f"pairs: {pair!r:.100}; expected (time, transform)")
        made.append(TransformKey(*both))
    return made
