"""Shapes by other means than their fields."""
from __future__ import annotations

from typing import Any, Dict, Iterable, Mapping, NoReturn, Optional, Sequence, Union

from . import _messages
from ._core import Vec
from ._mesh import Mesh
from ._messages import Material
from ._placing import Shape
from ._transforms import Transform, matrix
from ._types import VectorLike
from .errors import SceneError


class Sphere(_messages.Sphere, Shape):
    __slots__ = ()


class HalfPlane(_messages.HalfPlane, Shape):
    __slots__ = ()


class Disc(_messages.Disc, Shape):
    __slots__ = ()


class Polygon(_messages.Polygon, Shape):
    __slots__ = ()


class Cylinder(_messages.Cylinder, Shape):
    __slots__ = ()


class Cone(_messages.Cone, Shape):
    __slots__ = ()


class Torus(_messages.Torus, Shape):
    __slots__ = ()


class Plane(_messages.Plane, Shape):
    """An endless plane: the points p with normal . p = offset, the normal being of length 1."""

    __slots__ = ()

    @classmethod
    def through(cls, a: VectorLike, b: VectorLike, c: VectorLike, *, name: Optional[str] = None,
                materials: Optional[Iterable[Union[str, Material]]] = None,
                flip_normals: Optional[bool] = None, transform: Optional[Transform] = None,
                material: Optional[Union[str, Material]] = None, **unknown: NoReturn) -> Plane:
        """The plane through three points, in metres; its normal is (b - a) x (c - a). Raises SceneError for
        points on one line."""
        fields = _common_fields(locals())
        corner = Vec(a)
        normal = (Vec(b) - corner).cross(Vec(c) - corner)
        if normal.length == 0:
            raise SceneError("through: points on one line; expected three that span a plane")
        normal = normal.normalized()
        return cls(normal, normal.dot(corner), **fields)


class Rectangle(_messages.Rectangle, Shape):
    """A parallelogram: corner + u edge_u + v edge_v, u and v in [0, 1].

    Lengths are metres.
    """

    __slots__ = ()

    @classmethod
    def from_corners(cls, a: VectorLike, b: VectorLike, c: VectorLike, d: VectorLike, *,
                     name: Optional[str] = None,
                     materials: Optional[Iterable[Union[str, Material]]] = None,
                     flip_normals: Optional[bool] = None, transform: Optional[Transform] = None,
                     material: Optional[Union[str, Material]] = None, **unknown: NoReturn,
                     ) -> Union[Rectangle, Polygon]:
        """The flat convex shape with four corners, which go round counter-clockwise seen from its
        front: a Rectangle if they make a parallelogram, or else a Polygon. Each is a vector in metres.

        Raises SceneError for corners that do not lie in one plane, or enclose no area.
        """
        fields = _common_fields(locals())
        corners = [Vec(corner) for corner in (a, b, c, d)]
        _check_flat(corners)
        a, b, c, d = corners
        if (a + c - b - d).length <= _ROUNDING * max(p.length for p in corners):
            return cls(a, b - a, d - a, **fields)
        return Polygon(corners, **fields)


class Box(_messages.Box, Shape):
    """All points between the corners `min` and `max`.

    Lengths are metres.
    """

    __slots__ = ()

    @classmethod
    def from_corners(cls, corners: Sequence[VectorLike], *, name: Optional[str] = None,
                     materials: Optional[Iterable[Union[str, Material]]] = None,
                     flip_normals: Optional[bool] = None, transform: Optional[Transform] = None,
                     material: Optional[Union[str, Material]] = None, **unknown: NoReturn,
                     ) -> Union[Box, Mesh]:
        """The solid with eight corners: four that go round one face, and opposite to each, in the
        same order, those of the other face. A Box if they make a parallelepiped, or else a closed
        Mesh in which each face is two triangles. `corners` are (8, 3), in metres.

        Raises SceneError for another number of corners, or for a body of no volume.
        """
        fields = _common_fields(locals())
        points = [Vec(corner) for corner in corners]
        if len(points) != 8:
            raise SceneError(f"corners: {len(points)}; expected 8")
        a, b, c, d, e, f, g, h = points
        u, v, w = b - a, d - a, e - a
        size = max(p.length for p in points)
        off = max((found - a - expected).length for found, expected in
                  ((c, u + v), (f, u + w), (h, v + w), (g, u + v + w)))
        # Six times the volume, of the pyramids over all faces to a.
        volume = sum((points[i] - a).dot((points[j] - a).cross(points[k] - a))
                     for i, j, k in _FACES)
        extent = max((p - a).length for p in points)
        if not abs(volume) > _ROUNDING * extent ** 3:
            raise SceneError("corners: a body of no volume; expected two faces, one over the other")
        if off > _ROUNDING * size:
            faces = _FACES if volume > 0 else [(i, k, j) for i, j, k in _FACES]
            return Mesh([tuple(p) for p in points], faces, closed=True, **fields)
        if all(sum(x != 0 for x in edge) == 1 for edge in (u, v, w)):
            return cls([min(xs) for xs in zip(a, g)], [max(xs) for xs in zip(a, g)], **fields)
        rows = [[u[i], v[i], w[i], a[i]] for i in range(3)]
        made = cls((0, 0, 0), (1, 1, 1), **fields)
        made.transform = matrix(rows) if made.transform is None else made.transform @ matrix(rows)
        return made


def Triangle(a: VectorLike, b: VectorLike, c: VectorLike, *, name: Optional[str] = None,
             materials: Optional[Iterable[Union[str, Material]]] = None,
             flip_normals: Optional[bool] = None, transform: Optional[Transform] = None,
             material: Optional[Union[str, Material]] = None, **unknown: NoReturn,
             ) -> Polygon:
    """The triangle with these corners, in metres, which go round counter-clockwise seen from its
    front. Its edges belong to it. Many triangles are better one `Mesh`. Raises TypeError or UsageError
    for what is no vector of three numbers.
    """
    fields = _common_fields(locals())
    return Polygon([Vec(a), Vec(b), Vec(c)], **fields)


_COMMON = ("name", "materials", "material", "flip_normals", "transform")
# Of a coordinate: what sums and differences of a few coordinates may be off by rounding.
_ROUNDING = 2.0 ** -48
# How far off its plane a polygon's corner may lie, of its extent: as the renderer has it.
_FLATNESS = 1e-6
# The faces of a box of eight corners, each as two triangles, counter-clockwise from outside where
# (b - a, d - a, e - a) is right-handed.
_FACES = [triangle for i, j, k, l in ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5),
                                      (2, 3, 7, 6), (3, 0, 4, 7))
          for triangle in ((i, j, k), (i, k, l))]


def _common_fields(arguments: Mapping[str, Any]) -> Dict[str, Any]:
    """The keywords that every shape takes, and unknown ones, of the arguments of a function."""
    return {**arguments["unknown"], **{name: arguments[name] for name in _COMMON}}


def _check_flat(corners: Sequence[Vec]) -> None:
    """Raises SceneError where a corner lies off the plane of the others."""
    a, b, c, d = corners
    area = (c - a).cross(d - b)
    if area.length == 0:
        raise SceneError("corners: they enclose no area; expected four that go round a flat one")
    distance = abs(area.normalized().dot(b - a))
    if distance > _FLATNESS * max((c - a).length, (d - b).length):
        raise SceneError(f"corners: {distance:.3g} m off their plane; expected four in one plane")
