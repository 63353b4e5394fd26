"""What all shapes can do."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, List, Optional, Union

if TYPE_CHECKING:
    from ._messages import Csg, Material, Shape


class ShapeMethods:
    """Operators and properties of every Shape."""

    __slots__ = ()
    if TYPE_CHECKING:
        materials: List[Union[str, Material]]

    @property
    def material(self) -> Optional[Union[str, Material]]:
        """The first material, or its name."""
        return self.materials[0] if self.materials else None

    @material.setter
    def material(self, material: Optional[Union[str, Material]]) -> None:
        self.materials = [] if material is None else [material]

    def __or__(self, other: Shape) -> Csg:
        return _combined("union", self, other)

    def __and__(self, other: Shape) -> Csg:
        return _combined("intersection", self, other)

    def __sub__(self, other: Shape) -> Csg:
        return _combined("difference", self, other)


def _combined(operation: Any, a: Any, b: Any) -> Any:
    from ._messages import Csg, Shape
    return Csg(operation, [a, b]) if isinstance(b, Shape) else NotImplemented
