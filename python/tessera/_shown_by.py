"""Which instances of a tracer show a part of its scene."""
from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, Dict, List

from ._graph import Instances
from ._messages import Node, Shape
from .errors import UsageError

if TYPE_CHECKING:
    from .rays import Tracer
    from .scene import Scene

_MARK = "here"


def instances_of(part: Any, scene: "Scene", tracer: "Tracer") -> List[int]:
    """The numbers of the instances in and below a node, shape or Instances of the scene that `tracer` was
    made of. Raises UsageError where it shows none, and where the scene is another by now."""
    from .rays import Tracer  # here: it imports this
    copies: Dict[int, Any] = {}
    twin = copy.deepcopy(scene, copies)
    options = (*tracer._options[:2], "linear", tracer._options[3])  # no tree, for names alone
    if Tracer._of(twin, options)._core.digest() != tracer._core.digest():
        raise UsageError(f"shape: {part!r:.60}, of a scene that was changed after the tracer was made; "
                         "expected a name, a number or another tracer")
    marked = copies.get(id(part))
    for value in copies.values():
        if isinstance(value, (Node, Shape)):
            value.name = _MARK if value is marked else None
        elif isinstance(value, Instances):
            value.names = [_MARK] * len(value) if value is marked else None
    names = Tracer._of(twin, options).instances if marked is not None else []
    numbers = [number for number, name in enumerate(names) if name == _MARK]
    if not numbers:
        raise UsageError(f"shape: {part!r:.60}, which shows nothing in the tracer's scene; expected a "
                         "node that Scene.add() returned, or a shape in it")
    return numbers
