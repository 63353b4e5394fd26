"""Triangle meshes from arrays."""
from __future__ import annotations

import math
import warnings
from typing import (TYPE_CHECKING, Any, Generic, Iterable, Mapping, NoReturn, Optional, TypeVar, Union,
                    overload)

from . import _core, _messages
from ._arguments import boolean, number, with_article
from ._array import as_ndarray
from ._callers import level_of_caller
from ._placing import Shape
from ._transforms import Transform
from ._types import ArrayLike
from .errors import PrecisionWarning, UsageError

if TYPE_CHECKING:
    from ._types import Floats, Numbers

Given = TypeVar("Given")  # the array that a field hands out


class _ArrayField(Generic[Given]):
    """A field that takes any array, checks it at once and hands out a read-only view."""

    def __init__(self, name: str, doc: str) -> None:
        self._name = name
        self._slot: Any = _messages.Mesh.__dict__[name]
        self.__doc__ = doc

    @overload
    def __get__(self, mesh: None, _: Any = None) -> _ArrayField[Given]: ...
    @overload
    def __get__(self, mesh: Mesh, _: Any = None) -> Optional[Given]: ...
    def __get__(self, mesh: Optional[Mesh], _: Any = None) -> Any:
        if mesh is None:
            return self
        held = self._slot.__get__(mesh)
        return None if held is None else as_ndarray(held)

    def __set__(self, mesh: Mesh, given: Optional[ArrayLike]) -> None:
        if self._name == "positions" and given is not None:
            mesh._take_positions(given, None, False)
        else:
            self.put(mesh, given, None)

    def put(self, mesh: Mesh, given: Optional[ArrayLike], copy: Optional[bool]) -> None:
        """Takes an array; see `Mesh` about `copy`."""
        taken = None if given is None else _core.take_array(given, self._name, copy,
                                                            self._rows(mesh))
        self._slot.__set__(mesh, taken)

    def _rows(self, mesh: Mesh) -> int:
        if self._name == "positions":
            return -1
        counted = "triangles" if self._name == "face_materials" else "positions"
        held = _messages.Mesh.__dict__[counted].__get__(mesh)
        return -1 if held is None else len(held)


def _triangles_of(cells: Mapping[str, Any]) -> Optional[ArrayLike]:
    """The triangles of meshio's cells, by their kinds; points and lines beside them are left out."""
    from ._numpy import numpy as np
    halves = {"triangle": [0, 1, 2], "quad": [0, 1, 2, 0, 2, 3]}
    for kind, rows in cells.items():
        if kind not in halves and kind not in ("vertex", "line"):
            raise UsageError(f"cells: {len(rows)} of kind '{kind}'; expected those of kinds 'triangle' and 'quad', "
                             "beside them 'vertex' and 'line'")
    parts = [np.asarray(rows)[:, halves[kind]].reshape(-1, 3) for kind, rows in cells.items() if kind in halves]
    return np.concatenate(parts) if parts else None


class Mesh(_messages.Mesh, Shape):
    """Triangles by index into shared vertices, counter-clockwise seen from the front.

    :param positions: of the vertices, (v, 3).
    :param triangles: of vertices, (t, 3); without it each three vertices are one.
    :param normals: (v, 3); without them triangles are flat.
    :param uvs: texture coordinates, (v, 2).
    :param second_uvs: (v, 2), of textures whose `mapping` is "SECOND_UV".
    :param colors: (v, 3) or (v, 4), linear RGB and alpha.
    :param tangents: (v, 4), along which normal maps' x lies, and 1 or -1 for the side of their y;
        without them along u and v.
    :param face_materials: (t,), which of `materials` each triangle has.
    :param closed: bounds a solid, so that it can be part of a Csg.
    :param recenter: puts the middle of the vertices into `transform`, in double precision.
    :param copy: None shares read-only arrays of the right type and copies others; False refuses to
        copy; True copies always.

    Numbers of files' own arrays are `inline_positions`, `inline_triangles`, `inline_normals` and
    `inline_uvs`. Raises TypeError and UsageError that tell the argument, for arrays of other types or
    shapes, masked values, and indices of no vertex.
    """

    __slots__ = ("_is_told",)
    _is_told: bool  # of rounded positions

    positions: _ArrayField[Floats] = _ArrayField(  # type: ignore[assignment]
        "positions", "Of the vertices, (v, 3) float32.")
    triangles: _ArrayField[Numbers] = _ArrayField(  # type: ignore[assignment]
        "triangles", "Of vertices, (t, 3) uint32.")
    normals: _ArrayField[Floats] = _ArrayField(  # type: ignore[assignment]
        "normals", "Of the vertices, (v, 3) float32.")
    uvs: _ArrayField[Floats] = _ArrayField(  # type: ignore[assignment]
        "uvs", "Texture coordinates of the vertices, (v, 2) float32.")
    second_uvs: _ArrayField[Floats] = _ArrayField(  # type: ignore[assignment]
        "second_uvs", "Second texture coordinates of the vertices, (v, 2) float32.")
    colors: _ArrayField[Floats] = _ArrayField(  # type: ignore[assignment]
        "colors", "Of the vertices, (v, 4) float32.")
    tangents: _ArrayField[Floats] = _ArrayField(  # type: ignore[assignment]
        "tangents", "Of the vertices, (v, 4) float32.")
    face_materials: _ArrayField[Numbers] = _ArrayField(  # type: ignore[assignment]
        "face_materials", "Of the triangles, (t,) uint32.")

    def __init__(self, positions: Optional[ArrayLike] = None, triangles: Optional[ArrayLike] = None, *,
                 normals: Optional[ArrayLike] = None, uvs: Optional[ArrayLike] = None,
                 colors: Optional[ArrayLike] = None, face_materials: Optional[ArrayLike] = None,
                 tangents: Optional[ArrayLike] = None, second_uvs: Optional[ArrayLike] = None,
                 materials: Iterable[Union[str, _messages.Material]] = (), closed: bool = False,
                 recenter: bool = False, copy: Optional[bool] = None, name: Optional[str] = None,
                 material: Optional[Union[str, _messages.Material]] = None,
                 flip_normals: Optional[bool] = None, transform: Optional[Transform] = None,
                 inline_positions: Optional[Iterable[float]] = None,
                 inline_triangles: Optional[Iterable[int]] = None,
                 inline_normals: Optional[Iterable[float]] = None,
                 inline_uvs: Optional[Iterable[float]] = None, **unknown: NoReturn) -> None:
        if face_materials is not None:
            self._check_material(material)
        super().__init__(materials=materials, closed=closed or None, name=name, material=material,
                         flip_normals=flip_normals, transform=transform,
                         inline_positions=inline_positions, inline_triangles=inline_triangles,
                         inline_normals=inline_normals, inline_uvs=inline_uvs, **unknown)
        self._is_told = False
        if positions is not None:
            count = self._take_positions(positions, copy, recenter)
            if triangles is None:
                if count % 3:
                    raise UsageError(f"positions: {count} without triangles; expected a multiple of 3")
                triangles = [(i, i + 1, i + 2) for i in range(0, count, 3)]
        for field, given in (("triangles", triangles), ("normals", normals), ("uvs", uvs),
                             ("second_uvs", second_uvs),
                             ("colors", colors), ("tangents", tangents),
                             ("face_materials", face_materials)):
            Mesh.__dict__[field].put(self, given, copy)

    @property
    def is_closed(self) -> bool:
        """Whether there is a triangle, and each edge lies between two that wind the same way. Vertices at
        one place count as one."""
        return bool(self._held("triangles")) and not self.open_edges().shape[0]

    def open_edges(self) -> Numbers:
        """The edges at which the mesh is open, as they lack a triangle on one side, or one of the two is
        the wrong way round: rows of `positions` in the direction in which triangles pass them, (n, 2)
        uint32. An edge comes as often as it lacks one."""
        positions, triangles = self._held("positions"), self._held("triangles")
        if positions is None or triangles is None:
            positions, triangles = _core.take_array([], "positions"), _core.take_array([], "triangles")
        edges: Numbers = as_ndarray(_core.open_edges(positions, triangles))
        return edges

    def merge_vertices(self, distance: float) -> Mesh:
        """A copy in which each vertex lies at the first within that distance in metres, > 0, that stays
        itself, so that they count as one: slits close. Rows stay what they are, with their normals, uvs
        and colors; the renderer leaves out triangles whose corners coincide. Raises UsageError for other
        distances."""
        distance = number("distance", distance)
        if not 0 < distance < math.inf:
            raise UsageError(f"distance: {distance}; expected a length in metres, above 0")
        merged = self.__copy__()
        positions = self._held("positions")
        if positions is not None:
            Mesh.__dict__["positions"].put(merged, _core.merged_positions(positions, distance), None)
        return merged

    def _held(self, field: str) -> Optional[_core.Array]:
        """The array of that field as the renderer has it."""
        held: Optional[_core.Array] = _messages.Mesh.__dict__[field].__get__(self)
        return held

    @property
    def material(self) -> Optional[Union[str, _messages.Material]]:
        """The first material, or its name."""
        return super().material

    @material.setter
    def material(self, material: Optional[Union[str, _messages.Material]]) -> None:
        if self.face_materials is not None:
            self._check_material(material)
        self.materials = [] if material is None else [material]

    @staticmethod
    def _check_material(material: Optional[Union[str, _messages.Material]]) -> None:
        """Refuses one material for a mesh whose triangles choose among several."""
        if material is not None:
            raise UsageError("material: for a Mesh with face_materials, whose triangles have their own; "
                             "expected materials, one for each index")

    def _take_positions(self, given: ArrayLike, copy: Optional[bool], recenter: bool) -> int:
        """Returns how many there are."""
        taken, middle, moved = _core.take_positions(given, copy, boolean("recenter", recenter))
        Mesh.__dict__["positions"].put(self, taken, None)
        if moved > 0 and not self._is_told:
            self._is_told = True
            warnings.warn(f"positions: rounded by up to {moved:.3g} m; expected a mesh nearer to its "
                          "origin, as with recenter=True", PrecisionWarning, stacklevel=level_of_caller())
        if middle is not None:
            step = _messages.TransformStep(translate=middle)
            self.transform = Transform([*(self.transform.steps if self.transform else []), step])
        return len(taken)

    @classmethod
    def from_(cls, source: Any, *, normals: Optional[ArrayLike] = None,
              uvs: Optional[ArrayLike] = None, colors: Optional[ArrayLike] = None,
              face_materials: Optional[ArrayLike] = None, tangents: Optional[ArrayLike] = None,
              second_uvs: Optional[ArrayLike] = None,
              materials: Iterable[Union[str, _messages.Material]] = (), closed: bool = False,
              recenter: bool = False, copy: Optional[bool] = None, name: Optional[str] = None,
              material: Optional[Union[str, _messages.Material]] = None,
              flip_normals: Optional[bool] = None, transform: Optional[Transform] = None,
              **unknown: NoReturn) -> Mesh:
        """The mesh of an object that has `vertices` or `points`, and `faces`, `triangles` or `cells`:
        those of trimesh, Open3D and meshio. Cells of meshio that are quads become two triangles each.
        Raises TypeError for another object, UsageError for other cells, and what `Mesh` raises.
        """
        positions = next((getattr(source, name) for name in ("vertices", "points")
                          if getattr(source, name, None) is not None), None)
        triangles = next((getattr(source, name) for name in ("faces", "triangles")
                          if getattr(source, name, None) is not None), None)
        if triangles is None and hasattr(source, "cells_dict"):
            triangles = _triangles_of(source.cells_dict)
        elif triangles is None:
            triangles = getattr(source, "cells", None)
        if positions is None or triangles is None:
            raise TypeError(f"{with_article(source)}; expected vertices or points, and faces, "
                            "triangles or cells")
        return cls(positions, triangles, normals=normals, uvs=uvs, colors=colors,
                   face_materials=face_materials, tangents=tangents, second_uvs=second_uvs,
                   materials=materials, closed=closed, recenter=recenter, copy=copy, name=name, material=material,
                   flip_normals=flip_normals, transform=transform, **unknown)
