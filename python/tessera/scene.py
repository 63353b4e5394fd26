"""Scenes: everything that a picture is made of."""
from __future__ import annotations

import json
import os
from typing import Any, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from . import _core, _messages
from ._graph import Instances, flat, with_material
from ._html import table
from ._messages import (Frames, Include, IntegratorSettings, Light, Material, Metadata, Object,
                        Output, Sampling, Settings, Shape, Texture, Fog)
from ._nodes import Node
from ._places import located
from ._transforms import Transform
from ._types import ArrayLike, ColorLike
from ._value import here
from ._view import Background, Camera
from .errors import SceneError


class Summary(NamedTuple):
    """What a scene holds, and what of it no picture can show."""

    counts: Dict[str, int]
    """How many there are, by what is counted."""
    unused: List[str]
    """What is defined and never used."""
    undefined: List[str]
    """What is used and never defined."""


class _Setting:
    """A field of Settings, or of a part of it, as an attribute of the scene."""

    def __init__(self, path: str, made: type = Settings) -> None:
        self._part, _, field = path.rpartition(".")
        self._field, self._made = field, made
        self.__doc__ = f"The field `{path}` of `settings`."

    def __get__(self, scene: Optional[Scene], _: Any = None) -> Any:
        if scene is None:
            return self
        owner = scene.settings
        if owner is not None and self._part:
            owner = getattr(owner, self._part)
        return None if owner is None else getattr(owner, self._field)

    def __set__(self, scene: Scene, value: Any) -> None:
        if scene.settings is None:
            scene.settings = Settings()
        owner: Any = scene.settings
        if self._part:
            if getattr(owner, self._part) is None:
                setattr(owner, self._part, self._made())
            owner = getattr(owner, self._part)
        setattr(owner, self._field, list(value) if self._field == "response" else value)


class Scene(_messages.Scene):
    """Everything that a picture is made of: a value, which is read when it is rendered or saved.

    Beside the fields of the message (`nodes`, `materials`, `cameras`, ...) it has those of its
    settings as attributes and keywords: `Scene(width=640, height=360, spp=64)`.
    """

    __slots__ = ()

    width: Optional[int] = _Setting("width")  # type: ignore[assignment]
    height: Optional[int] = _Setting("height")  # type: ignore[assignment]
    time: Optional[float] = _Setting("time")  # type: ignore[assignment]
    accel: Optional[str] = _Setting("accelerator")  # type: ignore[assignment]
    spp: Optional[int] = _Setting("sampling.samples_per_pixel", Sampling)  # type: ignore[assignment]
    min_spp: Optional[int] = _Setting("sampling.min_samples", Sampling)  # type: ignore[assignment]
    target_error: Optional[float] = _Setting("sampling.target_error", Sampling)  # type: ignore[assignment]
    pattern: Optional[str] = _Setting("sampling.pattern", Sampling)  # type: ignore[assignment]
    filter: Optional[str] = _Setting("sampling.filter", Sampling)  # type: ignore[assignment]
    filter_radius: Optional[float] = _Setting("sampling.filter_radius", Sampling)  # type: ignore[assignment]
    seed: Optional[int] = _Setting("sampling.seed", Sampling)  # type: ignore[assignment]
    integrator: Optional[str] = _Setting("integrator.kind", IntegratorSettings)  # type: ignore[assignment]
    max_depth: Optional[int] = _Setting("integrator.max_depth", IntegratorSettings)  # type: ignore[assignment]
    shadows: Optional[str] = _Setting("integrator.shadows", IntegratorSettings)  # type: ignore[assignment]
    background_at_max_depth: Optional[bool] = _Setting(  # type: ignore[assignment]
        "integrator.background_at_max_depth", IntegratorSettings)
    ambient: Optional[ColorLike] = _Setting("integrator.ambient", IntegratorSettings)
    tone_map: Optional[str] = _Setting("output.tone_map", Output)  # type: ignore[assignment]
    transfer: Optional[str] = _Setting("output.transfer", Output)  # type: ignore[assignment]
    gamma: Optional[float] = _Setting("output.gamma", Output)  # type: ignore[assignment]
    exposure: Optional[float] = _Setting("output.exposure", Output)  # type: ignore[assignment]
    quantization: Optional[str] = _Setting("output.quantization", Output)  # type: ignore[assignment]
    response: Optional[Sequence[float]] = _Setting("output.response", Output)  # type: ignore[assignment]

    def __init__(self, *, width: Optional[int] = None, height: Optional[int] = None,
                 spp: Optional[int] = None, min_spp: Optional[int] = None,
                 target_error: Optional[float] = None, pattern: Optional[str] = None,
                 filter: Optional[str] = None, filter_radius: Optional[float] = None,
                 seed: Optional[int] = None, integrator: Optional[str] = None,
                 max_depth: Optional[int] = None, shadows: Optional[str] = None,
                 background_at_max_depth: Optional[bool] = None, ambient: Optional[ColorLike] = None,
                 tone_map: Optional[str] = None, transfer: Optional[str] = None,
                 gamma: Optional[float] = None, exposure: Optional[float] = None,
                 quantization: Optional[str] = None, response: Optional[Sequence[float]] = None,
                 accel: Optional[str] = None, time: Optional[float] = None,
                 frames: Optional[Union[Frames, Tuple[int, int]]] = None,
                 camera: Optional[_messages.Camera] = None,
                 background: Optional[Union[_messages.Background, ColorLike]] = None,
                 **fields: Any) -> None:
        settings = {name: value for name, value in locals().items() if name in _SETTINGS}
        super().__init__(**fields)
        self._place = here()
        for name, value in settings.items():
            if value is not None:
                setattr(self, name, value)
        if frames is not None:
            if self.settings is None:
                self.settings = Settings()
            self.settings.frames = frames if isinstance(frames, Frames) else Frames(*frames)
        if camera is not None:
            self.camera = camera
        if background is not None:
            is_whole = isinstance(background, _messages.Background)
            self.background = background if is_whole else Background.solid(background)

    @property
    def camera(self) -> Optional[_messages.Camera]:
        """The first camera, which pictures are taken with unless another is asked for."""
        return self.cameras[0] if self.cameras else None

    @camera.setter
    def camera(self, camera: Optional[_messages.Camera]) -> None:
        self.cameras[:1] = [] if camera is None else [camera]

    def add(self, *things: Any, transform: Optional[Transform] = None,
            material: Optional[Union[str, Material]] = None, name: Optional[str] = None) -> Node:
        """Puts shapes, lights, objects, nodes, other scenes or sequences of them below a new node.

        :param material: of the shapes, in place of their own.
        :return: the node; a Node that is added by itself is returned as it is.
        """
        leaves = flat(things)
        is_alone = len(leaves) == 1
        if is_alone and isinstance(leaves[0], Node) and transform is None and name is None:
            node = leaves[0]
        elif is_alone:
            node = self._node_of(with_material(leaves[0], material))
            node.transform, node.name = transform, name
        else:
            children = [self._node_of(with_material(leaf, material)) for leaf in leaves]
            node = Node(children=children, transform=transform, name=name)
        self.nodes.append(node)
        return node

    def _node_of(self, thing: Any) -> Node:
        if isinstance(thing, Shape):
            return Node(shape=thing)
        if isinstance(thing, Light):
            return Node(light=thing)
        if isinstance(thing, Object):
            return Node(instance_of=thing)
        if isinstance(thing, (Node, Instances)):
            return Node(children=[thing])
        if isinstance(thing, _messages.Scene):
            self.materials += thing.materials
            self.textures += thing.textures
            self.objects += thing.objects
            return Node(children=thing.nodes)
        raise TypeError(f"a {type(thing).__name__}; expected a Shape, Light, Node, Object, Scene or a "
                        "sequence of them")

    def instances(self, object: Union[str, Object, Shape, Sequence[Any]], transforms: ArrayLike, *,
                  names: Optional[Sequence[str]] = None,
                  material: Optional[Union[str, Material]] = None) -> Instances:
        """Adds many instances of an object, which is stored and built once.

        :param transforms: an array (n, 3, 4) or (n, 4, 4), or a list of transforms.
        """
        added = Instances(object, transforms, names, material=material)
        self.nodes.append(added)
        return added

    @property
    def digest(self) -> str:
        """What names the scene: equal for equal scenes, whenever and wherever they are made."""
        digest: str = _core.digest(self)
        return digest

    def check(self) -> None:
        """Raises SceneError for names that are used and never defined, and for whatever of the scene
        a render would refuse: it builds all that one needs."""
        undefined = self.info().undefined
        if undefined and not self.includes:  # which may define it
            raise SceneError(f"{undefined[0]}: used and never defined")
        try:
            _core.check(self)
        except SceneError as error:
            raise located(self, error) from None

    def info(self) -> Summary:
        """Counts of what the scene holds, and names that are not used or not defined."""
        return Summary(*_core.summary(self))

    def _repr_html_(self) -> str:
        summary = self.info()
        rest = {"unused": summary.unused, "undefined": summary.undefined}
        return table({**summary.counts, **{what: ", ".join(names) for what, names in rest.items() if names}})

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the scene by the ending: .tessera (text), .tesserab (binary) or .json."""
        _core.save(self, os.fspath(path))

    def to_dict(self) -> Dict[str, Any]:
        """The scene in protobuf's JSON mapping, which `load_dict` reads."""
        made: Dict[str, Any] = json.loads(_core.to_json(self))
        return made

    def tracer(self, **options: Any) -> Any:
        """What answers questions about rays; see `tessera.rays`."""
        from . import rays
        try:
            return rays.tracer_from_scene(self, **options)
        except SceneError as error:
            raise located(self, error) from None

    def render(self, **options: Any) -> Any:
        """Renders the scene; see `tessera.render`."""
        from .rendering import render
        return render(self, **options)

    def frames(self, first: Optional[int] = None, last: Optional[int] = None,
               **options: Any) -> Iterator[Tuple[int, Any]]:
        """Renders frames one after the other: pairs of number and picture."""
        from .rendering import render
        asked = self.settings.frames if self.settings is not None else None
        begin = first if first is not None else (asked.first or 0) if asked else 0
        end = last if last is not None else (asked.last or 0) if asked else begin
        for frame in range(begin, end + 1):
            yield frame, render(self, frame=frame, **options)


_SETTINGS = [name for name, held in vars(Scene).items() if isinstance(held, _Setting)]
