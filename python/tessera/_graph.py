"""The graph of a scene beyond what its messages have: many instances in one value."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, List, Optional, Sequence, TypeVar, Union

from . import _core, _messages
from ._arguments import several, with_article
from ._array import as_ndarray
from ._callers import here
from ._messages import Object
from ._nodes import Node
from ._value import Value
from ._value_types import PartsLike, TransformsLike
from .errors import UsageError, nesting_ends

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

T = TypeVar("T")


class Instances(Value):
    """Many instances of one object, stored as one array; a node each in the scene.

    Attributes:
        object: The object, or its name.
        transforms: An array (n, 3, 4) of float64, parent from instance.
        names: The names of the nodes, if they have any.

    Raises TypeError and UsageError for arrays of other types and shapes, and for another number of names.
    """

    __slots__ = ("object", "_transforms", "names")
    _FIELDS = ("object", "transforms", "names")
    object: Union[str, Object]
    _transforms: _core.Array
    names: Optional[List[str]]

    def __init__(self, object: Union[str, PartsLike], transforms: TransformsLike,
                 names: Optional[Sequence[str]] = None, *,
                 material: Optional[Union[str, _messages.Material]] = None) -> None:
        self._place = here()
        if material is None and isinstance(object, (str, Object)):
            self.object = object
        else:
            self.object = to_object(object, material)
        self.transforms = transforms  # type: ignore[assignment]
        self.names = None if names is None else [str(name) for name in several(names, "names")]
        if self.names is not None and len(self.names) != len(self):
            raise UsageError(f"names: {len(self.names)}; expected {len(self)}, one an instance")

    @property
    def transforms(self) -> npt.NDArray[np.float64]:
        """Parent from instance, (n, 3, 4) of float64. Any array (n, 3, 4) or (n, 4, 4) and lists of
        transforms are taken."""
        array: npt.NDArray[np.float64] = as_ndarray(self._transforms)
        return array

    @transforms.setter
    def transforms(self, given: TransformsLike) -> None:
        matrices: Any = given
        if isinstance(given, (list, tuple)) and given and all(
                isinstance(each, _messages.Transform) for each in given):
            matrices = [_core.transform_matrix(each) for each in given]
        self._transforms = _core.take_matrices(matrices, "transforms")

    def __len__(self) -> int:
        return len(self._transforms)

    def __eq__(self, other: Any) -> bool:
        if not isinstance(other, Instances):
            return NotImplemented
        return bool((self.object, self._transforms, self.names) ==
                    (other.object, other._transforms, other.names))


def to_object(things: Union[str, PartsLike],
              material: Optional[Union[str, _messages.Material]] = None) -> Object:
    """An object without a name, which gets one by its digest, of shapes and nodes."""
    parts = (with_material(thing, material) for thing in flat(things))
    return Object(nodes=[Node(children=part.nodes) if isinstance(part, _messages.Scene) else part
                         for part in parts])


def flat(things: Any) -> List[Any]:
    """The shapes, lights, nodes and the like in sequences inside sequences."""
    with nesting_ends(things, "nodes"):
        return _leaves(things)


def _leaves(things: Any) -> List[Any]:
    if isinstance(things, Value):
        return [things]
    if isinstance(things, str) or not hasattr(things, "__iter__"):
        raise TypeError(f"{with_article(things)}; expected a Shape, Light, Node, Object, Scene or a "
                        "sequence of them")
    return [leaf for thing in several(things, "nodes") for leaf in _leaves(thing)]


def with_material(thing: T, material: Optional[Union[str, _messages.Material]]) -> T:
    """The thing; a copy of a shape with that material where one is given. Lights need none."""
    if material is None or isinstance(thing, _messages.Light):
        return thing
    if not isinstance(thing, _messages.Shape):
        raise TypeError(f"material: for {with_article(thing)}, whose shapes have their own; expected "
                        "shapes and lights")
    copy: Any = thing.__copy__()
    copy.material = material
    return copy  # type: ignore[no-any-return]
