"""Nodes of the scene graph, with what they can do."""
from __future__ import annotations

from . import _messages
from ._placing import Placed, apart, behind
from ._transforms import Transform

class Node(Placed, _messages.Node):
    """A place in the scene graph, with a shape, a light, an instance or other nodes in it.

    Lengths are metres.
    """

    __slots__ = ()

    def _place_by(self, outer: Transform) -> Node:
        if not self.keys:
            return super()._place_by(outer)
        self.keys = [_messages.TransformKey(key.time, behind(outer, key.transform))
                     for key in self.keys]
        return self

    def _instance(self) -> Node:
        if not self.children:
            return super()._instance()
        return Node(self.name, instance_of=_messages.Object(nodes=[apart(self)]))
