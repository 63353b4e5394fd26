"""Stand-ins for classes of other packages."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NoReturn, Tuple, Union, overload

from ._arguments import refuse_attribute, tells_unknown
from ._types import ArrayLike
from ._mesh import Mesh
from .errors import UsageError

if TYPE_CHECKING:
    from ._types import Bools, Doubles, Integers

__all__ = ["MeshIntersector"]


def _check_rows(**arrays: Any) -> None:
    from ._numpy import numpy as np
    for name, array in arrays.items():
        shape = np.shape(array)
        if len(shape) != 2 or shape[1] != 3:
            raise UsageError(f"{name}: shape {shape}; expected (n, 3)")


class MeshIntersector:
    """Has the methods of `trimesh.Trimesh.ray`, with the same arguments, returns and dtypes: numbers
    of rays and triangles are int64, locations float64. Hits come by ray, then by distance. A ray
    through a shared edge or vertex hits each triangle there; a closed mesh contains what
    `Tracer.contains` says, so that where two closed parts overlap is inside. Points and directions are
    (n, 3), in the unit of the mesh. Raises UsageError for arrays of other shapes and for a wrong mesh."""

    @tells_unknown
    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        self._tracer = Mesh(vertices, faces).tracer()

    @overload
    def intersects_id(self, ray_origins: ArrayLike, ray_directions: ArrayLike,
                      return_locations: Literal[False] = False, multiple_hits: bool = True,
                      ) -> Tuple[Integers, Integers]: ...
    @overload
    def intersects_id(self, ray_origins: ArrayLike, ray_directions: ArrayLike,
                      return_locations: Literal[True], multiple_hits: bool = True,
                      ) -> Tuple[Integers, Integers, Doubles]: ...
    @tells_unknown
    def intersects_id(self, ray_origins: ArrayLike, ray_directions: ArrayLike,
                      return_locations: bool = False, multiple_hits: bool = True,
                      ) -> Union[Tuple[Integers, Integers], Tuple[Integers, Integers, Doubles]]:
        """The triangles that are hit, and the ray of each; with `return_locations` the points too.
        Raises UsageError for arrays of other shapes than (n, 3)."""
        from ._numpy import numpy as np
        _check_rows(ray_origins=ray_origins, ray_directions=ray_directions)
        if multiple_hits:
            hits = self._tracer.intersect_all(ray_origins, ray_directions)
            ray, triangle = hits.ray, hits.primitive
            points = hits.point.copy() if return_locations else None
        else:
            first = self._tracer.intersect(ray_origins, ray_directions)
            ray = np.flatnonzero(first.hit)
            triangle = first.primitive[ray]
            points = first.point[ray] if return_locations else None
        found = (triangle.astype(np.int64), ray.astype(np.int64))
        return found if points is None else found + (points,)

    @tells_unknown
    def intersects_location(self, ray_origins: ArrayLike, ray_directions: ArrayLike,
                            multiple_hits: bool = True) -> Tuple[Doubles, Integers, Integers]:
        """The points that are hit, the ray of each, and the triangle of each. Raises UsageError for arrays of
        other shapes than (n, 3)."""
        triangle, ray, points = self.intersects_id(ray_origins, ray_directions, True, multiple_hits)
        return points, ray, triangle

    @tells_unknown
    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> Integers:
        """The first triangle that each ray hits, (n,); -1 where there is none. Raises UsageError for arrays of
        other shapes than (n, 3)."""
        from ._numpy import numpy as np
        _check_rows(ray_origins=ray_origins, ray_directions=ray_directions)
        first = self._tracer.intersect(ray_origins, ray_directions, fields=("primitive",))
        return np.where(first.hit, first.primitive.astype(np.int64), -1)

    @tells_unknown
    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> Bools:
        """Whether each ray hits anything, (n,). Raises UsageError for arrays of other shapes than (n, 3)."""
        _check_rows(ray_origins=ray_origins, ray_directions=ray_directions)
        return self._tracer.occluded(ray_origins, ray_directions).copy()

    @tells_unknown
    def contains_points(self, points: ArrayLike) -> Bools:
        """Whether each point is inside the mesh, (n,); all False where it is not closed. Raises UsageError
        for arrays of other shapes than (n, 3)."""
        _check_rows(points=points)
        return self._tracer.contains(points).copy()


if not TYPE_CHECKING:  # for mypy a module that has this has every name
    def __getattr__(name: str) -> NoReturn:
        """Raises AttributeError that tells the nearest public name."""
        refuse_attribute(__name__, name, __all__)
