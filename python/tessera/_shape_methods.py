"""Properties of every Shape, beside what `Placed` has."""
from __future__ import annotations

from typing import TYPE_CHECKING, List, Optional, Union

from ._placing import Placed

if TYPE_CHECKING:
    from ._messages import Material


class ShapeMethods(Placed):
    """Properties of every Shape; what Nodes have too is in `Placed`."""

    if TYPE_CHECKING:
        materials: List[Union[str, Material]]
    else:
        __slots__ = ()

    @property
    def material(self) -> Optional[Union[str, Material]]:
        """The first material, or its name."""
        return self.materials[0] if self.materials else None

    @material.setter
    def material(self, material: Optional[Union[str, Material]]) -> None:
        self.materials = [] if material is None else [material]
