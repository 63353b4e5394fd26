"""What shapes and nodes can both do: be moved, copied, mirrored, turned inside out, combined and hit."""
from __future__ import annotations

from typing import (TYPE_CHECKING, Any, Dict, Iterable, Iterator, List, Optional, Set, Tuple,
                    TypeVar, Union)

from . import _messages
from ._core import Vec, transform_matrix
from ._messages import Classic, CsgOperation, Material, Node, Object, Plane, Scene
from ._places import located_errors
from ._transforms import Transform, matrix, scale, translate
from ._types import Accelerator, ArrayLike, Cull, HitField, InsideMethod, OpenShapes, VectorLike
from .errors import UsageError, nesting_ends
from .rays import Hits, Tracer, tracer_from_scene

if TYPE_CHECKING:
    from ._types import Bools

T = TypeVar("T", bound="Placed")

_PARTS = ("shape", "children", "nodes", "operands", "instance_of", "object")


class Placed:
    """Methods of every Shape and Node. Those that move it change it in place and return it."""

    __slots__ = ()
    if TYPE_CHECKING:
        transform: Optional[Transform]

    def shift(self: T, v: VectorLike) -> T:
        """Moves it by the vector `v`, in metres. Raises TypeError or UsageError for what is no vector of
        three numbers."""
        return self._place_by(translate(v))

    def reflect(self: T, point: VectorLike) -> T:
        """Mirrors it through a point, a vector in metres: p goes to 2 point - p. Its front stays its front.
        Raises TypeError or UsageError for what is no vector of three numbers."""
        return self._place_by(translate(Vec(point) * 2) @ scale(-1))

    def mirror(self: T, plane: Plane) -> T:
        """Mirrors it in a Plane. Its front stays its front. Raises TypeError for another shape."""
        if not isinstance(plane, Plane):
            raise TypeError(f"plane: {plane!r:.100}; expected a Plane")
        normal, offset = _in_parent(plane)
        rows = [[float(i == j) - 2 * normal[i] * normal[j] for j in range(3)] + [2 * offset * normal[i]]
                for i in range(3)]
        return self._place_by(matrix(rows))

    def copy(self: T, v: VectorLike = (0, 0, 0)) -> T:
        """Another one, moved by the vector `v`, in metres. Its parts are copies too: those of a node
        with children are below `instance_of` of the new one. Materials are shared, and what takes
        memory is stored once for both. Raises SceneError for parts that lie in themselves."""
        with nesting_ends(self):
            made = self._instance()
        return made.shift(v)

    def flip(self: T) -> T:
        """Turns its normals to the other side, so that its front becomes its back."""
        with nesting_ends(self):
            turned = _turned(self, {})
        for name, held in turned.items():
            setattr(self, name, held)
        return self

    def intersect(self, origin: ArrayLike, direction: ArrayLike, *,
                  t_min: Union[float, ArrayLike] = 0.0, t_max: Union[float, ArrayLike] = float("inf"),
                  cull: Cull = "none", threads: Optional[int] = None,
                  fields: Union[None, HitField, Iterable[HitField]] = None) -> Hits:
        """The closest hits of rays with this alone; t counts lengths of the direction.

        Each call builds what it needs anew: many rays are better given at once, as arrays
        (..., 3). The options are those of `Tracer.intersect`; on one thread where `threads` is left
        out. Raises what that raises, and SceneError for what cannot be built.
        """
        return self.tracer(threads=1).intersect(origin, direction, t_min=t_min, t_max=t_max, cull=cull,
                                                threads=threads, fields=fields)

    def contains(self, points: ArrayLike, *, method: InsideMethod = "parity", closed: OpenShapes = "warn",
                 threads: Optional[int] = None) -> Bools:
        """Whether points, (..., 3) in metres, are inside it: bool (...). Each call builds what it needs
        anew, on one thread where `threads` is left out; see `Tracer.contains`, whose errors it raises."""
        return self.tracer(threads=1).contains(points, method=method, closed=closed, threads=threads)

    def tracer(self, *, accel: Accelerator = "bvh", threads: Optional[int] = None) -> Tracer:
        """What answers any number of ray queries about this alone, where its own transform puts it. The
        options are those of `Scene.tracer`. Raises SceneError, with the script's line, for what cannot
        be built."""
        materials = [material for shape in _shapes(self) for material in shape.materials]
        own = {getattr(material, "name", None) for material in materials}
        names = {material for material in materials if isinstance(material, str)} - own
        alone: Any = self
        scene = Scene(nodes=[alone], materials=[Classic(name=name) for name in sorted(names)])
        with located_errors(scene):
            return tracer_from_scene(scene, accel=accel, threads=threads)

    def __or__(self, other: Placed) -> Csg:
        return _combined("union", self, other)

    def __and__(self, other: Placed) -> Csg:
        return _combined("intersection", self, other)

    def __sub__(self, other: Placed) -> Csg:
        return _combined("difference", self, other)

    def _instance(self: T) -> T:
        made: T = apart(self)
        return made

    def _place_by(self: T, outer: Transform) -> T:
        """Puts `outer` behind its transforms."""
        self.transform = behind(outer, self.transform)
        return self


class Shape(Placed, _messages.Shape):
    """What rays hit."""

    __slots__ = ()

    @property
    def material(self) -> Optional[Union[str, Material]]:
        """The first material, or its name."""
        return self.materials[0] if self.materials else None

    @material.setter
    def material(self, material: Optional[Union[str, Material]]) -> None:
        self.materials = [] if material is None else [material]


class Csg(_messages.Csg, Shape):
    __slots__ = ()


def behind(outer: Transform, inner: Optional[Transform]) -> Transform:
    return outer if inner is None else outer @ inner


def _combined(operation: CsgOperation, a: Placed, b: Placed) -> Csg:
    if not isinstance(b, Placed):
        return NotImplemented
    operands: List[Any] = [a, b]
    return Csg(operation, operands)


def _in_parent(plane: Plane) -> Tuple[Vec, float]:
    """The unit normal of a plane and its distance from the origin, with its own transform."""
    normal = Vec((0, 1, 0) if plane.normal is None else plane.normal).normalized()
    offset = plane.offset or 0.0
    if plane.transform is not None:
        array = transform_matrix(plane.transform)
        numbers = memoryview(array).cast("B").cast("d").tolist()  # type: ignore[arg-type]
        x, y, z = (Vec(numbers[i:i + 3]) for i in (0, 4, 8))
        foot = normal * offset
        moved = Vec(x.dot(foot), y.dot(foot), z.dot(foot)) + numbers[3::4]
        # Normals go by the inverse transposed, which is the matrix of cofactors but for a factor.
        columns = zip(y.cross(z), z.cross(x), x.cross(y))
        normal = Vec(*(Vec(column).dot(normal) for column in zip(*columns))).normalized()
        offset = normal.dot(moved)
    return normal, offset


def _parts(thing: Any) -> Iterator[Any]:
    """The shapes, nodes, objects and instances in a node, an object or a Csg."""
    for name in _PARTS:
        held = getattr(thing, name) if name in getattr(thing, "_FIELDS", ()) else None
        yield from held if isinstance(held, list) else [] if held is None else [held]


def everything_in(thing: Any) -> Iterator[Any]:
    """The thing, and all values in it, each once."""
    seen: Set[int] = set()
    pending = [thing]
    while pending:
        part = pending.pop()
        if id(part) in seen:
            continue
        seen.add(id(part))
        yield part
        for name in reversed(part._FIELDS):
            held = getattr(part, name)
            inside = held if isinstance(held, list) else [held]
            pending += [each for each in reversed(inside) if hasattr(each, "_FIELDS")]


def apart(thing: Any, copies: Optional[Dict[int, Any]] = None) -> Any:
    """A copy of it and of all parts in it; materials and arrays are shared.

    :param copies: those made so far, by the id of what they are copies of: a part that stands in
        several places is copied once, and its copy stands in all of them.
    """
    if isinstance(thing, str):
        return thing
    copies = {} if copies is None else copies
    if id(thing) in copies:
        return copies[id(thing)]
    made = thing.__copy__()
    for name in _PARTS:
        held = getattr(made, name) if name in made._FIELDS else None
        if held is not None:
            setattr(made, name, [apart(part, copies) for part in held] if isinstance(held, list)
                    else apart(held, copies))
    copies[id(thing)] = made
    return made


def _shapes(thing: Any) -> Iterator[Any]:
    """All shapes in it, each once."""
    seen, pending = set(), [thing]
    while pending:
        part = pending.pop()
        if id(part) in seen:
            continue
        seen.add(id(part))
        if isinstance(part, Shape):
            yield part
        pending += _parts(part)


def _turned(thing: Any, copies: Dict[int, Any]) -> Dict[str, Any]:
    """The fields that are others once its normals are turned. What other things share is copied,
    once; `copies` are as in `apart`."""
    if isinstance(thing, Shape):
        return {"flip_normals": not thing.flip_normals}
    if isinstance(thing, Node):
        fields = {"shape": thing.shape, "children": thing.children, "instance_of": thing.instance_of}
    elif isinstance(thing, Object):
        fields = {"nodes": thing.nodes, "name": None}
    else:
        fields = {"object": thing.object} if hasattr(thing, "transforms") else {}  # of Instances
    return {name: [_flipped(part, copies) for part in held] if isinstance(held, list)
            else _flipped(held, copies) for name, held in fields.items()}


def _flipped(thing: Any, copies: Dict[int, Any]) -> Any:
    if thing is None:
        return None
    if isinstance(thing, str):
        raise UsageError(f"flip: an instance of '{thing}'; expected one of an Object, not of a name")
    if id(thing) not in copies:
        made = thing.__copy__()
        for name, held in _turned(thing, copies).items():
            setattr(made, name, held)
        copies[id(thing)] = made
    return copies[id(thing)]
