"""Hits of rays, in arrays."""
from __future__ import annotations

import math
from typing import (TYPE_CHECKING, Any, Dict, List, NamedTuple, Optional, SupportsIndex, Tuple, Type,
                    TypeVar, Union)

from ._html import table
from ._types import HitField
from .errors import UsageError

if TYPE_CHECKING:
    from ._types import AnyArray, ArrayShape, Bools, Doubles, Integers, Numbers, Rows
    from .rays import Tracer

A = TypeVar("A", bound="AnyArray")
F = TypeVar("F", bound="Located")

_NONE = 0xFFFFFFFF
#: The numbers that each attribute of a hit has, and their type.
_ATTRIBUTES = {"point": (3, "f8"), "point_error": (3, "f8"), "normal": (3, "f8"),
               "shading_normal": (3, "f8"), "texcoord": (2, "f8"), "material": (1, "u4")}


def frozen(array: A) -> A:
    """A read-only view of an array of ours, which cannot be made writable again."""
    memory: Any = array
    while hasattr(memory, "flags"):
        memory.flags.writeable = False
        memory = memory.base
    return array.view()


class Located:
    """What `Hits` and `AllHits` share: hits in arrays, and what lies there."""

    __slots__ = ("_tracer", "_rays", "_threads", "_arrays", "_shape", "_known")

    def __init__(self, tracer: Union[Tracer, _Names], rays: Optional[Tuple[Rows, Rows]],
                 threads: Optional[int], arrays: Dict[str, AnyArray], shape: ArrayShape,
                 known: Optional[Dict[str, AnyArray]] = None) -> None:
        self._tracer, self._rays, self._threads = tracer, rays, threads
        self._arrays, self._shape, self._known = arrays, shape, known or {}

    def _field(self, name: HitField) -> AnyArray:
        if name not in self._arrays:
            raise UsageError(f"{name}: not among the fields that were asked for; expected one of "
                             f"{', '.join(self._arrays)}")
        return self._arrays[name]

    def _per_hit(self) -> Tuple[Rows, Rows]:
        """The ray of each hit."""
        if self._rays is None:
            raise UsageError(f"fields: {', '.join(self._arrays)}; expected all, as without fields=, for what lies "
                             "at the hits")
        return self._rays

    def _flat(self) -> Tuple[Doubles, Numbers, Numbers, Doubles]:
        """The four arrays as `_core` takes them."""
        count = math.prod(self._shape)
        return (self.t.reshape(count), self.instance.reshape(count), self.primitive.reshape(count),
                self.uv.reshape(count, 2))

    def _attribute(self, name: str) -> AnyArray:
        if name not in self._known:
            from ._numpy import numpy as np
            width, code = _ATTRIBUTES[name]
            shape = self._shape if width == 1 else self._shape + (width,)
            out = np.empty(shape, code)
            origins, directions = self._per_hit()
            tracer: Any = self._tracer
            tracer._core.attributes(origins, directions, self._flat(),
                                    tracer._threads(self._threads), {name: out})
            self._known[name] = frozen(out)
        return self._known[name]

    @property
    def t(self) -> Doubles:
        """Lengths of the direction, float64 in the shape of the hits; infinite: no hit."""
        return self._field("t")

    @property
    def instance(self) -> Numbers:
        """Indices into `tracer.instances`, uint32 in the shape of the hits; 0xFFFFFFFF: no hit."""
        return self._field("instance")

    @property
    def primitive(self) -> Numbers:
        """Of a mesh the row of its triangles, of a box its face: uint32 in the shape of the hits; 0xFFFFFFFF: no hit."""
        return self._field("primitive")

    @property
    def uv(self) -> Doubles:
        """Barycentric weights of a triangle's vertices 1 and 2, not `texcoord`; of other shapes the place on
        their surface. float64 (..., 2); 0: no hit."""
        return self._field("uv")

    @property
    def point(self) -> Doubles:
        """Where the surface was hit: metres on the axes of the world, float64 (..., 3); NaN: no hit."""
        return self._attribute("point")

    @property
    def point_error(self) -> Doubles:
        """How far off `point` the surface is at most: it passes through the box around `point` that reaches
        so far on each axis. Metres, float64 (..., 3); NaN: no hit. No bound on the distance along the ray,
        which is larger the flatter the ray meets the surface."""
        return self._attribute("point_error")

    @property
    def normal(self) -> Doubles:
        """Unit normals of the surface's front on the axes of the world, float64 (..., 3); NaN: no hit."""
        return self._attribute("normal")

    @property
    def shading_normal(self) -> Doubles:
        """Unit normals, smoothed by those of vertices, float64 (..., 3); NaN: no hit."""
        return self._attribute("shading_normal")

    @property
    def texcoord(self) -> Doubles:
        """Texture coordinates, float64 (..., 2); NaN: no hit."""
        return self._attribute("texcoord")

    @property
    def material(self) -> Numbers:
        """Indices into `tracer.materials`, uint32 in the shape of the hits; 0xFFFFFFFF: no hit."""
        return self._attribute("material")

    def name(self, index: Union[SupportsIndex, Tuple[SupportsIndex, ...]] = ()) -> Optional[str]:
        """The name of the instance that was hit at that index, a number for each axis: none for a single
        ray. None where none was. Raises IndexError beyond the shape of the hits."""
        number = int(self.instance[index])
        return None if number == _NONE else self._tracer.instances[number]

    def __reduce__(self) -> Tuple[Any, ...]:
        """Without the tracer, and so without its scene: with all that it could tell of the hits."""
        from ._numpy import numpy as np
        known = {} if self._rays is None else {name: self._attribute(name) for name in _ATTRIBUTES}
        state = {name: getattr(self, name) for name in self._slots()}
        # What was given once for all rays is a row for each here: a view without a step is no buffer.
        rays = None if self._rays is None else tuple(map(np.ascontiguousarray, self._rays))
        state.update(_tracer=_Names(self._tracer.instances), _known=known, _rays=rays)
        return _unpickled, (type(self), state)

    def __copy__(self: F) -> F:
        return self

    def __deepcopy__(self: F, _: object) -> F:
        return self

    @classmethod
    def _slots(cls) -> List[str]:
        return [name for base in reversed(cls.__mro__) for name in getattr(base, "__slots__", ())]


class _Names(NamedTuple):
    """What hits that were pickled keep of their tracer."""

    instances: List[str]


def _unpickled(made: Type[F], state: Dict[str, Any]) -> F:
    hits = made.__new__(made)
    for name, value in state.items():
        setattr(hits, name, frozen(value) if hasattr(value, "flags") else value)
    for arrays in (hits._arrays, hits._known):
        arrays.update({name: frozen(array) for name, array in arrays.items()})
    return hits


class Hits(Located):
    """The closest hit of each ray, in arrays of the rays' shape. Attributes beside the fields are
    computed when first asked for. An index or mask, as numpy takes them, gives the hits of some."""

    __slots__ = ()

    @property
    def hit(self) -> Bools:
        """Whether anything was hit: bool in the rays' shape."""
        from ._numpy import numpy as np
        for name in ("instance", "primitive"):
            if name in self._arrays:
                return frozen(np.asarray(self._arrays[name] != _NONE))
        return frozen(np.asarray(np.isfinite(self.t)))

    @property
    def shape(self) -> ArrayShape:
        """The shape of the rays."""
        return self._shape

    def __len__(self) -> int:
        if not self._shape:
            raise TypeError("hits of a single ray have no length")
        return self._shape[0]

    def __bool__(self) -> bool:
        if math.prod(self._shape) != 1:
            raise ValueError(f"the truth of {self._shape} hits is ambiguous; expected hits.hit.any() or "
                             "hits.hit.all()")
        return bool(self.hit.all())

    def __getitem__(self, key: Any) -> Hits:
        from ._numpy import numpy as np
        count = math.prod(self._shape)
        chosen = np.arange(count).reshape(self._shape)[key]
        shape, rows = np.shape(chosen), np.reshape(chosen, -1)

        def of(array: AnyArray) -> AnyArray:
            rest = array.shape[len(self._shape):]
            return frozen(array.reshape((count,) + rest)[rows].reshape(shape + rest))

        rays = None if self._rays is None else (self._rays[0][rows], self._rays[1][rows])
        return Hits(self._tracer, rays, self._threads,
                    {name: of(array) for name, array in self._arrays.items()}, shape,
                    {name: of(array) for name, array in self._known.items()})

    def _tells_hits(self) -> bool:
        return any(name in self._arrays for name in ("t", "instance", "primitive"))

    def __repr__(self) -> str:
        if not self._tells_hits():
            return f"<Hits {self._shape}>"
        return f"<Hits {self._shape}: {int(self.hit.sum())} hit>"

    def _repr_html_(self) -> str:
        rows: Dict[str, float] = {"rays": math.prod(self._shape)}
        if self._tells_hits():
            rows["hit"] = int(self.hit.sum())
        if "t" in self._arrays and rows["hit"]:
            rows["nearest"], rows["farthest"] = self.t.min(), self.t[self.hit].max()
        return table(rows)


class AllHits(Located):
    """All hits of rays: those of ray `i`, in the order of C, are entries `offsets[i]` to
    `offsets[i + 1]` of the other arrays, sorted by (t, instance, primitive)."""

    __slots__ = ("offsets", "ray_shape")

    def __init__(self, offsets: Integers, ray_shape: ArrayShape, tracer: Tracer,
                 rays: Tuple[Rows, Rows], threads: Optional[int], arrays: Dict[str, AnyArray]) -> None:
        super().__init__(tracer, rays, threads, arrays, (len(arrays["t"]),))
        self.offsets, self.ray_shape = offsets, ray_shape

    @property
    def counts(self) -> Integers:
        """How many hits each ray has, in the rays' shape."""
        from ._numpy import numpy as np
        return frozen(np.diff(self.offsets).reshape(self.ray_shape))

    @property
    def ray(self) -> Integers:
        """The number of each hit's ray, int64 (n,)."""
        from ._numpy import numpy as np
        count, at_once = len(self.offsets) - 1, 1 << 16  # numpy keeps the interpreter's lock meanwhile
        rays = np.empty(len(self), np.int64)
        for begin in range(0, count, at_once):
            ends = self.offsets[begin:begin + at_once + 1]
            rays[ends[0]:ends[-1]] = np.repeat(np.arange(begin, begin + len(ends) - 1), np.diff(ends))
        return frozen(rays)

    def _per_hit(self) -> Tuple[Rows, Rows]:
        origins, directions = super()._per_hit()
        return origins[self.ray], directions[self.ray]

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        return f"<AllHits of {len(self.offsets) - 1} rays: {len(self)}>"
