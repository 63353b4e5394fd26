"""Ray queries on arrays: closest hits, all hits, crossings, insides and what lies at hits."""
from __future__ import annotations

import operator
import warnings
from typing import (TYPE_CHECKING, Any, Dict, Iterable, List, Optional, Sequence, Set, SupportsIndex,
                    Tuple, Union, get_args)

from . import _core
from ._arguments import (boolean, folder_text, named_text, nearest, number, several, tells_unknown,
                         whole, whole_count)
from ._array import plain_array
from ._callers import level_of_caller
from ._hits import AllHits, Hits, Located, frozen
from ._log import logged_at_end
from ._options import core_options
from ._types import Accelerator, ArrayLike, Cull, HitField, InsideMethod, OpenShapes, Path
from .errors import SceneWarning, UsageError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._types import AnyArray, ArrayShape, Bools, Doubles, Rows

    # Time, camera, accelerator and threads.
    Options = Tuple[Optional[float], str, Accelerator, Optional[int]]

__all__ = ["AllHits", "Hits", "Tracer", "tracer_from_scene"]

_CULLS: Tuple[Cull, ...] = get_args(Cull)
_FIELDS: Tuple[HitField, ...] = get_args(HitField)
_SOME_FIELDS = f"some of {', '.join(_FIELDS)}"


def _choice(keyword: str, found: str, known: Sequence[str]) -> str:
    if found in known:
        return found
    kind, hint = (UsageError, nearest(found, list(known))) if isinstance(found, str) else (TypeError, "")
    raise kind(f"{keyword}: {found!r:.100}; expected one of {', '.join(known)}{hint}")


def _camera_name(camera: Optional[str]) -> str:
    return "" if camera is None else named_text("camera", camera)


def _thread_count(threads: Optional[int]) -> int:
    if threads is None:
        return _core.core_count()
    return whole_count("threads", threads)


def _real(name: str, value: Union[float, ArrayLike]) -> Rows:
    """`value` as an array of float64, or of float32 where it is that."""
    from ._numpy import numpy as np
    array: AnyArray = plain_array(name, value)
    if array.dtype == object or not np.can_cast(array.dtype, np.float64, "safe"):
        raise UsageError(f"{name}: dtype {array.dtype}; expected float64 or what fits into it")
    single = array.dtype.kind == "f" and array.dtype.itemsize == 4
    wanted = np.float32 if single else np.float64
    # A view, since arrays of ctypes tell their byte order even where it is this machine's.
    return np.require(array.astype(wanted, copy=False).view(wanted), requirements=["ALIGNED"])


def _vectors(name: str, value: ArrayLike) -> Rows:
    array = _real(name, value)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise UsageError(f"{name}: shape {array.shape}; expected (..., 3)")
    return array


def _broadcast(named: Sequence[Tuple[str, ArrayShape]]) -> ArrayShape:
    """The leading shape that all broadcast to."""
    from ._numpy import numpy as np
    try:
        return np.broadcast_shapes(*(shape for _, shape in named))
    except ValueError:
        told = ", ".join(f"{name} {shape}" for name, shape in named)
        raise UsageError(f"leading shapes: {told}; expected shapes that broadcast") from None


def _rows(array: Rows, shape: ArrayShape) -> Rows:
    """(n, 3), without a copy wherever one stride leads from row to row."""
    from ._numpy import numpy as np
    return np.broadcast_to(array, shape + (3,)).reshape(-1, 3)


def _can_change(array: Rows) -> bool:
    """Whether somebody could write to its memory."""
    # Not by flags, which of arrays of numpy.broadcast_arrays warn when they are read.
    base: Any = array
    while hasattr(base, "__array_interface__") and base.__array_interface__["data"][1]:
        base = base.base
    return not (base is None or isinstance(base, bytes))


class _Rays:
    """Rays of one call: their leading shape, and arrays as `_core` takes them."""

    def __init__(self, origins: ArrayLike, directions: ArrayLike, t_min: Union[float, ArrayLike],
                 t_max: Union[float, ArrayLike]) -> None:
        self.given = o, d = _vectors("origins", origins), _vectors("directions", directions)
        ends = {name: _real(name, value) for name, value in (("t_min", t_min), ("t_max", t_max))}
        self.shape = _broadcast([("origins", o.shape[:-1]), ("directions", d.shape[:-1]),
                                 *((name, end.shape) for name, end in ends.items())])
        self.origins, self.directions = _rows(o, self.shape), _rows(d, self.shape)
        self.ends = self._end(ends["t_min"]), self._end(ends["t_max"])

    def to_keep(self) -> Tuple[Tuple[Rows, Rows], Tuple[Optional[Doubles], Optional[Doubles]]]:
        """Origins and directions, whatever becomes of the arrays given, and those of them which the
        query has yet to fill."""
        origins, empty_origins = self._to_keep(self.given[0], self.origins)
        directions, empty_directions = self._to_keep(self.given[1], self.directions)
        return (origins, directions), (empty_origins, empty_directions)

    def _to_keep(self, given: Rows, rows: Rows) -> Tuple[Rows, Optional[Doubles]]:
        from ._numpy import numpy as np
        if not (_can_change(given) and np.may_share_memory(given, rows)):
            return rows, None
        if given.size < rows.size:  # one row for all rays
            return _rows(given.copy(), self.shape), None
        empty: Doubles = np.empty(rows.shape)
        return empty, empty

    def _end(self, end: Rows) -> Union[float, Doubles]:
        """One number, or one for each ray."""
        from ._numpy import numpy as np
        if end.ndim == 0:
            return float(end)
        return np.ascontiguousarray(np.broadcast_to(end, self.shape), np.float64).reshape(-1)


class Tracer:
    """The geometry of a scene for ray queries, made by `Scene.tracer`. It never changes: any number
    of threads may use it at once. Results have the same bits for any number of threads.

    Arrays that it gives are read-only. Points are metres on the axes of the world. Rays start at
    `origins` and go along `directions`, arrays of shape (..., 3) that broadcast. The point at t is
    origin + t * direction, and hits lie at t_min < t < t_max. A t_min below 0 is a UsageError: what lies behind an
    origin is hit along the opposite direction. Surfaces are hit whatever their material lets through;
    hidden nodes are not there. A ray whose numbers are not all finite, or without a direction, hits
    nothing."""

    __slots__ = ("_core", "_options", "_names", "_open", "_told_of")

    def __init__(self, core: _core.Tracer, options: Options) -> None:
        self._core, self._options = core, options
        self._names: Optional[List[str]] = None
        self._open: Optional[List[Tuple[int, bool, int, int, int]]] = None  # shapes, see _core
        self._told_of: Set[bool] = set()  # by winding or not: for which methods open shapes were told of

    @classmethod
    def _of(cls, scene: Union[_core.ValueBase, _core.Array, str, bytes], options: Options, assets: str = "") -> Tracer:
        """Of a Scene, of its text form (str) or of its binary form (bytes)."""
        time, camera, accel, threads = options
        with logged_at_end():
            return cls(_core.Tracer(scene, time, camera, accel, _thread_count(threads), assets), options)

    def _threads(self, threads: Optional[int]) -> int:
        return _thread_count(threads if threads is not None else self._options[-1])

    @tells_unknown
    def intersect(self, origins: ArrayLike, directions: ArrayLike, *,
                  t_min: Union[float, ArrayLike] = 0.0, t_max: Union[float, ArrayLike] = float("inf"),
                  cull: Cull = "none", threads: Optional[int] = None,
                  fields: Union[None, HitField, Iterable[HitField]] = None) -> Hits:
        """The closest hit of each ray. `fields` names what is wanted of t, instance, primitive and
        uv; all, if it is left out.

        :param origins: points in metres, (..., 3).
        :param directions: (..., 3), which broadcasts with the origins.
        :param t_min: from where on a ray is looked at, in lengths of its direction, >= 0: one number, or
            one for each ray.
        :param t_max: up to where, in the same unit.
        :param cull: "back": the backs of surfaces are not hit; "front": their fronts are not.
        :param threads: how many trace, from 1 to 1024; those of the tracer if left out.

        Raises UsageError for other shapes, words and numbers."""
        from ._numpy import numpy as np
        wanted: Sequence[HitField] = (_FIELDS if fields is None else [fields] if isinstance(fields, str)
                                      else several(fields, "fields", _SOME_FIELDS))
        if not wanted:
            raise UsageError(f"fields: {fields!r}; expected {_SOME_FIELDS}")
        for name in wanted:
            _choice("fields", name, _FIELDS)
        rays = _Rays(origins, directions, t_min, t_max)
        types = {"t": "f8", "instance": "u4", "primitive": "u4", "uv": "f8"}
        arrays: Dict[str, AnyArray] = {
            name: np.empty(rays.shape + ((2,) if name == "uv" else ()), types[name]) for name in wanted}
        # What lies at hits needs all fields, and the rays.
        kept, empty = (rays.to_keep() if len(arrays) == len(_FIELDS) else (None, (None, None)))
        self._core.intersect(rays.origins, rays.directions, *rays.ends,
                             _CULLS.index(_choice("cull", cull, _CULLS)), self._threads(threads),
                             *empty, *(arrays.get(name) for name in _FIELDS))
        return Hits(self, kept, threads, {name: frozen(array) for name, array in arrays.items()},
                    rays.shape)

    @tells_unknown
    def occluded(self, origins: ArrayLike, directions: ArrayLike, *,
                 t_min: Union[float, ArrayLike] = 0.0,
                 t_max: Union[float, ArrayLike] = float("inf"), cull: Cull = "none",
                 threads: Optional[int] = None) -> Bools:
        """Whether each ray hits anything: bool in the rays' shape. Takes the arguments of
        `Tracer.intersect` but for `fields`, and raises what that raises."""
        from ._numpy import numpy as np
        rays = _Rays(origins, directions, t_min, t_max)
        out = np.empty(rays.shape, bool)
        self._core.occluded(rays.origins, rays.directions, *rays.ends,
                            _CULLS.index(_choice("cull", cull, _CULLS)), self._threads(threads),
                            out)
        return frozen(out)

    @tells_unknown
    def intersect_all(self, origins: ArrayLike, directions: ArrayLike, *,
                      t_min: Union[float, ArrayLike] = 0.0,
                      t_max: Union[float, ArrayLike] = float("inf"), cull: Cull = "none",
                      threads: Optional[int] = None) -> AllHits:
        """All hits of each ray, each once. Takes the arguments of `Tracer.intersect` but for `fields`, and
        raises what that raises."""
        from ._numpy import numpy as np
        rays = _Rays(origins, directions, t_min, t_max)
        kept, empty = rays.to_keep()
        offsets, *arrays = (np.asarray(a) for a in self._core.intersect_all(
            rays.origins, rays.directions, *rays.ends,
            _CULLS.index(_choice("cull", cull, _CULLS)), self._threads(threads), *empty))
        return AllHits(offsets, rays.shape, self, kept, threads, dict(zip(_FIELDS, arrays)))

    @tells_unknown
    def crossings(self, origins: ArrayLike, directions: ArrayLike, *,
                  t_min: Union[float, ArrayLike] = 0.0, t_max: Union[float, ArrayLike] = float("inf"),
                  threads: Optional[int] = None) -> npt.NDArray[np.int32]:
        """How often each ray passes from front to back, less how often from back to front. Through
        an edge or vertex of a mesh it passes once. int32 in the rays' shape. Takes the arguments of
        `Tracer.intersect` but for `cull` and `fields`, and raises what that raises."""
        from ._numpy import numpy as np
        rays = _Rays(origins, directions, t_min, t_max)
        out = np.empty(rays.shape, np.int32)
        self._core.crossings(rays.origins, rays.directions, *rays.ends, self._threads(threads), out)
        return frozen(out)

    @tells_unknown
    def contains(self, points: ArrayLike, shape: Union[None, int, str] = None, *,
                 method: InsideMethod = "parity", closed: OpenShapes = "warn",
                 threads: Optional[int] = None) -> Bools:
        """Whether each of the points, (..., 3) in metres on the axes of the world, is inside some solid
        or closed mesh; with `shape` inside the instances of that name or number. bool (...); False for
        a point whose numbers are not all finite. Points on a surface are on either side. A plane is a
        solid: what is behind it is inside. Discs, rectangles and polygons have no inside.

        :param method: of meshes that are not closed. "parity": they have no inside. "winding": what they
            go around more than half is inside, by the generalised winding number (Jacobson 2013), to some
            hundredths. Of closed meshes and solids both say the same: inside is what they go around, so
            that where two closed parts of a mesh overlap is inside too.
        :param closed: what is done about shapes without an inside: meshes that are not closed, by
            "parity", and solids with parts left out. "warn": SceneWarning tells of the first, once for
            each method, and nothing is inside. "error": UsageError.
        :param threads: how many trace, from 1 to 1024; those of the tracer if left out.

        Raises UsageError for other shapes and words, and for a `shape` that is unknown or has no inside."""
        from ._numpy import numpy as np
        by_winding = _choice("method", method, get_args(InsideMethod)) == "winding"
        refuses = _choice("closed", closed, get_args(OpenShapes)) == "error"
        among = self._numbers(shape)
        self._tell_open(refuses or among is not None, by_winding, among)
        at = _vectors("points", points)
        inside = np.empty(at.shape[:-1], bool)
        self._core.contains(at.reshape(-1, 3), among, by_winding, self._threads(threads), inside)
        return frozen(inside)

    def _tell_open(self, refuses: bool, by_winding: bool, among: Optional[Sequence[int]]) -> None:
        """Tells of shapes that are not closed and so have no inside: once, or by UsageError."""
        if self._open is None:
            self._open = self._core.open_shapes()
        # Those without an inside, by the method.
        meant = None if among is None else set(among)
        found = [each for each in self._open
                 if not (by_winding and each[1]) and (meant is None or each[0] in meant)]
        if not found or (by_winding in self._told_of and not refuses):
            return
        number, is_mesh, count, begin, end = found[0]
        more = f", nor are {len(found) - 1} more" if len(found) > 1 else ""
        where = f" at {count} edge{'s' * (count > 1)}, as that between vertices {begin} and {end}" if count else ""
        expected = ("each edge between two triangles that wind the same way, or method='winding'" if is_mesh else
                    "a solid with no part left out")
        name = self._instance_names()[number]
        which = f"the {'mesh' if is_mesh else 'solid'} {repr(name) if name else number}"
        text = f"{which} is not closed{where}{more}, so that nothing is inside; expected {expected}"
        if refuses:
            raise UsageError(f"contains: {text}")
        warnings.warn(f"contains: {text}", SceneWarning, stacklevel=level_of_caller())
        self._told_of.add(by_winding)  # not where the warning was an error

    def _numbers(self, shape: Union[None, int, str]) -> Optional[List[int]]:
        """The instances that `shape` means; None: all."""
        if shape is None:
            return None
        if isinstance(shape, str):
            wanted, names = named_text("shape", shape), self._instance_names()
            found = [i for i, name in enumerate(names) if name == wanted]
            if not found:
                raise UsageError(f"shape: {shape!r:.100}; expected one of `instances`"
                                 f"{nearest(shape, sorted(set(names)))}")
            return found
        if isinstance(shape, bool) or not hasattr(shape, "__index__"):
            raise TypeError(f"shape: {shape!r:.60}; expected the name or number of an instance")
        number = operator.index(shape)
        count = len(self._instance_names())
        if not 0 <= number < count:
            raise UsageError(f"shape: {shape}; expected a name or a number below {count}")
        return [number]

    @tells_unknown
    def camera_rays(self, size: Optional[Tuple[int, int]] = None, camera: Optional[str] = None,
                    ) -> Tuple[Doubles, Doubles]:
        """Origins, in metres, and unit directions, both float64 (height, width, 3) on the axes of the
        world, of the rays through the middles of the pixels of a frame; row 0 is the top. They are
        those of a pinhole without bounds: the camera's lens, `near_distance` and `far_distance` have no
        part in them; give the distances to queries as `t_min` and `t_max`.

        :param size: (width, height), each from 1 to 65536 pixels; left out, that of the scene.
        :param camera: the name of one; left out, the tracer's.

        Raises UsageError for other sizes, and for the name of no camera.
        """
        from ._numpy import numpy as np
        sides = several(self._core.size() if size is None else size, "size")
        if len(sides) != 2 or not all(0 < whole("size", side) <= 65536 for side in sides):
            raise UsageError(f"size: {size}; expected (width, height), whole numbers from 1 to 65536")
        width, height = map(operator.index, sides)
        origins, directions = (np.empty((height, width, 3)) for _ in range(2))
        self._core.camera_rays(_camera_name(camera), width, height, self._threads(None), origins,
                               directions)
        return frozen(origins), frozen(directions)

    @tells_unknown
    def spawn(self, hits: Located, directions: ArrayLike) -> Doubles:
        """Where rays start that leave the surfaces of `hits` along `directions`: moved off by the
        bound on the error, so that they do not meet those surfaces there. Metres on the axes of the
        world, float64 in the shape of the hits, (..., 3); NaN where there is no hit.

        :param directions: one for each hit, or one for all; of any length.

        Raises UsageError for directions of another shape.
        """
        from ._numpy import numpy as np
        if not isinstance(hits, Located):
            raise TypeError(f"hits: {hits!r:.100}; expected Hits or AllHits")
        away = _vectors("directions", directions)
        shape = hits._shape
        if _broadcast([("hits", shape), ("directions", away.shape[:-1])]) != shape:
            raise UsageError(f"directions: shape {away.shape}; expected one for each of the hits "
                             f"{shape}")
        out = np.empty(shape + (3,))
        self._core.spawn(*hits._per_hit(), hits._flat(), _rows(away, shape), self._threads(None),
                         out)
        return frozen(out)

    @property
    def bounds(self) -> Doubles:
        """The least and the largest corner of the bounds of all instances that are bounded, float64 (2, 3):
        metres on the axes of the world. Infinite, the least above the largest, where there are none."""
        from ._numpy import numpy as np
        return np.asarray(self._core.bounds())

    @property
    def instances(self) -> List[str]:
        """The names of instances, by number: of the node, or else of the shape."""
        return list(self._instance_names())

    def _instance_names(self) -> List[str]:
        if self._names is None:
            self._names = self._core.instances()
        return self._names

    @property
    def materials(self) -> List[str]:
        """The names of materials, by number; '' is the default one."""
        return self._core.materials()

    @property
    def statistics(self) -> Dict[str, float]:
        """How many primitives, nodes and the like are held, in how many bytes, and the seconds that building took."""
        return self._core.statistics()

    def __reduce_ex__(self, protocol: SupportsIndex) -> Tuple[Any, ...]:
        from pickle import PickleBuffer
        scene: Any = self._core.scene()
        return _rebuilt, (PickleBuffer(scene) if int(protocol) >= 5 else scene, self._options)

    def __repr__(self) -> str:
        return f"<Tracer of {len(self._instance_names())} instances>"


def _rebuilt(scene: Any, options: Options) -> Tracer:
    """A tracer that was pickled, whose scene may come in any buffer."""
    return Tracer._of(scene, options)


@tells_unknown
def tracer_from_scene(scene: Union[_core.ValueBase, str, bytes], *, time: Optional[float] = None,
                      camera: Optional[str] = None, accel: Accelerator = "bvh",
                      threads: Optional[int] = None, geometry_only: bool = True,
                      assets: Optional[Path] = None) -> Tracer:
    """A tracer of a `Scene`, of its text form (str) or of its binary form (bytes), as it is now.
    Files that a Scene includes are looked for in `assets`, as by `render`."""
    if not boolean("geometry_only", geometry_only):
        raise UsageError("geometry_only: False; expected True, as tracers know no light")
    when = None if time is None else number("time", time)
    core_options({"time": when, "accel": accel})  # which refuses what render does
    name: Any = named_text("accel", accel)
    return Tracer._of(scene, (when, _camera_name(camera), name, threads), folder_text(assets))
