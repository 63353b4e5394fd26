"""Scenes: everything that a picture is made of."""
from __future__ import annotations

import copy
import json
from typing import (TYPE_CHECKING, Any, Dict, Generic, Iterable, Iterator, List, NamedTuple, NoReturn,
                    Optional, Sequence, Tuple, Type, TypeVar, Union, overload)

from . import _core, _messages, rendering
from ._arguments import (file_name, folder_text, frame_number, nearest, refuse_unknown, several,
                         tells_unknown, with_article)
from ._graph import Instances, flat, with_material
from ._html import table
from ._local_farms import BaseFarm
from ._log import logged_at_end
from ._messages import (Fog, Frames, Include, IntegratorSettings, IntegratorSettingsShadows, Light,
                        Material, Metadata, Object, Output, OutputQuantization, OutputToneMap,
                        OutputTransfer, Sampling, SamplingFilter, SamplingPattern, Settings, Texture)
from ._nodes import Node
from ._places import located_errors
from ._placing import Shape, everything_in
from ._progress import ProgressOption, TileCallback
from ._transforms import Transform
from ._types import (Accelerator, Aovs, ColorLike, Crop, Integrator, Path, Pattern, Shadows, Size, Up,
                     View)
from ._value import Value, words_of
from ._value_types import NodeLike, PartsLike, TransformsLike
from ._view import Background, Camera
from .errors import SceneError, UsageError
from .picture import Image

if TYPE_CHECKING:
    from .rays import Tracer

T = TypeVar("T")
V = TypeVar("V", bound=Value)
Corner = Tuple[float, float, float]


class Summary(NamedTuple):
    """What a scene holds, and what of it no picture can show."""

    counts: Dict[str, int]
    """How many there are, by what is counted."""
    unused: List[str]
    """What is defined and never used."""
    undefined: List[str]
    """What is used and never defined."""
    bounds: Optional[Tuple[Corner, Corner]]
    """The least and the largest corner around every surface at the scene's time, in metres on the axes
    of the world, rounded outward. None where there is no surface, as in an empty scene, or where a
    render would refuse the scene."""


class _Setting(Generic[T]):
    """A field of Settings, or of a part of it, as an attribute of the scene."""

    def __init__(self, path: str, made: type = Settings) -> None:
        self._part, _, field = path.rpartition(".")
        self._field, self._made = field, made
        self.__doc__ = f"`settings.{path}`: {words_of(made, field)}"

    @overload
    def __get__(self, scene: None, _: Any = None) -> _Setting[T]: ...
    @overload
    def __get__(self, scene: Scene, _: Any = None) -> Optional[T]: ...
    def __get__(self, scene: Optional[Scene], _: Any = None) -> Any:
        if scene is None:
            return self
        owner = scene.settings
        if owner is not None and self._part:
            owner = getattr(owner, self._part)
        return None if owner is None else getattr(owner, self._field)

    def __set__(self, scene: Scene, value: Optional[T]) -> None:
        if value is None:
            self._take_back(scene)
            return
        if scene.settings is None:
            scene.settings = Settings()
        owner: Any = scene.settings
        if self._part:
            if getattr(owner, self._part) is None:
                setattr(owner, self._part, self._made())
            owner = getattr(owner, self._part)
        held: Any = value
        if self._field == "response":
            if callable(held):
                raise TypeError("response: a function; expected (a, b, c) of a x^2 + b x + c; any "
                                "function is for Image.apply")
            held = several(held, "response")
        setattr(owner, self._field, held)

    def __delete__(self, scene: Scene) -> None:
        self._take_back(scene)

    def _take_back(self, scene: Scene) -> None:
        """Sets it to None, and with it the parts that held nothing else."""
        settings = scene.settings
        owner = getattr(settings, self._part) if settings is not None and self._part else settings
        if owner is None:
            return
        setattr(owner, self._field, None)
        if self._part and owner == self._made():
            setattr(settings, self._part, None)
        if settings == Settings():
            scene.settings = None


class _BackgroundField:
    """What rays see that meet nothing; a colour stands for the background that is it everywhere."""

    def __init__(self) -> None:
        self._slot: Any = _messages.Scene.__dict__["background"]

    @overload
    def __get__(self, scene: None, _: Any = None) -> _BackgroundField: ...
    @overload
    def __get__(self, scene: Scene, _: Any = None) -> Optional[Background]: ...
    def __get__(self, scene: Optional[Scene], _: Any = None) -> Any:
        return self if scene is None else self._slot.__get__(scene)

    def __set__(self, scene: Scene, given: Optional[Union[Background, ColorLike]]) -> None:
        is_color = given is not None and not isinstance(given, Value)
        self._slot.__set__(scene, Background.solid(given) if is_color else given)  # type: ignore[arg-type]


class Scene(_messages.Scene):
    """Everything that a picture is made of: a value, which is read when it is rendered or saved.

    Beside the fields of the message (`nodes`, `materials`, `cameras`, ...) it has those of its
    settings as attributes and keywords: `Scene(width=640, height=360, spp=64)`. What uses a scene
    raises SceneError, with the script's line, for values out of their range.
    """

    __slots__ = ()

    background: _BackgroundField = _BackgroundField()  # type: ignore[assignment]
    width: _Setting[int] = _Setting("width")
    height: _Setting[int] = _Setting("height")
    time: _Setting[float] = _Setting("time")
    accel: _Setting[Accelerator] = _Setting("accelerator")
    spp: _Setting[int] = _Setting("sampling.samples_per_pixel", Sampling)
    min_spp: _Setting[int] = _Setting("sampling.min_samples", Sampling)
    target_error: _Setting[float] = _Setting("sampling.target_error", Sampling)
    pattern: _Setting[SamplingPattern] = _Setting("sampling.pattern", Sampling)
    filter: _Setting[SamplingFilter] = _Setting("sampling.filter", Sampling)
    filter_radius: _Setting[float] = _Setting("sampling.filter_radius", Sampling)
    seed: _Setting[int] = _Setting("sampling.seed", Sampling)
    integrator: _Setting[Integrator] = _Setting("integrator.kind", IntegratorSettings)
    max_depth: _Setting[int] = _Setting("integrator.max_depth", IntegratorSettings)
    shadows: _Setting[IntegratorSettingsShadows] = _Setting("integrator.shadows", IntegratorSettings)
    background_at_max_depth: _Setting[bool] = _Setting(
        "integrator.background_at_max_depth", IntegratorSettings)
    ambient: _Setting[ColorLike] = _Setting("integrator.ambient", IntegratorSettings)
    tone_map: _Setting[OutputToneMap] = _Setting("output.tone_map", Output)
    transfer: _Setting[OutputTransfer] = _Setting("output.transfer", Output)
    gamma: _Setting[float] = _Setting("output.gamma", Output)
    exposure: _Setting[float] = _Setting("output.exposure", Output)
    quantization: _Setting[OutputQuantization] = _Setting("output.quantization", Output)
    response: _Setting[Sequence[float]] = _Setting("output.response", Output)

    def __init__(self, *, width: Optional[int] = None, height: Optional[int] = None,
                 spp: Optional[int] = None, min_spp: Optional[int] = None,
                 target_error: Optional[float] = None, pattern: Optional[SamplingPattern] = None,
                 filter: Optional[SamplingFilter] = None, filter_radius: Optional[float] = None,
                 seed: Optional[int] = None, integrator: Optional[Integrator] = None,
                 max_depth: Optional[int] = None,
                 shadows: Optional[IntegratorSettingsShadows] = None,
                 background_at_max_depth: Optional[bool] = None, ambient: Optional[ColorLike] = None,
                 tone_map: Optional[OutputToneMap] = None, transfer: Optional[OutputTransfer] = None,
                 gamma: Optional[float] = None, exposure: Optional[float] = None,
                 quantization: Optional[OutputQuantization] = None,
                 response: Optional[Sequence[float]] = None, accel: Optional[Accelerator] = None,
                 time: Optional[float] = None,
                 frames: Optional[Union[Frames, Tuple[int, int]]] = None,
                 camera: Optional[Camera] = None,
                 background: Optional[Union[Background, ColorLike]] = None,
                 metadata: Optional[Metadata] = None, settings: Optional[Settings] = None,
                 cameras: Optional[Iterable[Camera]] = None, fog: Optional[Fog] = None,
                 materials: Optional[Iterable[Material]] = None,
                 textures: Optional[Iterable[Texture]] = None,
                 objects: Optional[Iterable[Object]] = None,
                 nodes: Optional[Iterable[NodeLike]] = None,
                 includes: Optional[Iterable[Include]] = None, **unknown: NoReturn) -> None:
        flat_settings = {name: value for name, value in locals().items() if name in _SETTINGS}
        if camera is not None and cameras is not None:
            raise TypeError("camera beside cameras; expected one of them")
        if settings is not None and (frames is not None or any(v is not None for v in flat_settings.values())):
            settings = copy.deepcopy(settings)
        super().__init__(metadata=metadata, settings=settings, cameras=cameras, fog=fog,
                         materials=materials, textures=textures, objects=objects, nodes=nodes,
                         includes=includes, **unknown)
        for name, value in flat_settings.items():
            if value is not None:
                setattr(self, name, value)
        if frames is not None:
            if self.settings is None:
                self.settings = Settings()
            if not isinstance(frames, Frames):
                pair = several(frames, "frames", "Frames or (first, last)")
                if len(pair) != 2:
                    raise TypeError(f"frames: {frames!r:.100}; expected Frames or (first, last)")
                frames = Frames(*pair)
            self.settings.frames = frames
        if camera is not None:
            self.camera = camera
        if background is not None:
            self.background = background

    @property
    def camera(self) -> Optional[Camera]:
        """The first camera, which pictures are taken with unless another is asked for."""
        return self.cameras[0] if self.cameras else None

    @camera.setter
    def camera(self, camera: Optional[Camera]) -> None:
        self.cameras[:1] = [] if camera is None else [camera]

    @tells_unknown
    def add(self, *things: PartsLike, transform: Optional[Transform] = None,
            material: Optional[Union[str, Material]] = None, name: Optional[str] = None) -> Node:
        """Puts shapes, lights, objects, nodes, other scenes or sequences of them below a new node.

        :param material: of the shapes, in place of their own: the node holds copies of them. Nodes,
            objects and scenes keep theirs, so that they cannot be given one.
        :return: the node; a Node that is added by itself is returned as it is. One thing is its
            `shape`, `light` or `instance_of`, several are in nodes of their own, its `children`.

        Raises TypeError for what is no part of a scene.
        """
        if not things:
            raise TypeError("add() of nothing; expected a Shape, Light, Node, Object, Scene or a "
                            "sequence of them")
        leaves = flat(things)
        is_alone = len(leaves) == 1
        if (is_alone and isinstance(leaves[0], Node)
                and transform is None and material is None and name is None):
            node = leaves[0]
        elif is_alone:
            node = self._node_of(with_material(leaves[0], material))
            node.transform, node.name = transform, name
        else:
            children = [self._node_of(with_material(leaf, material)) for leaf in leaves]
            node = Node(children=children, transform=transform, name=name)
        self._take_definitions(leaves)
        self.nodes.append(node)
        return node

    def _take_definitions(self, parts: Iterable[Any]) -> None:
        """What nodes of other scenes name is from now on in this one."""
        for other in parts:
            if isinstance(other, _messages.Scene):
                self.materials += other.materials
                self.textures += other.textures
                self.objects += other.objects
                self.includes += other.includes

    @staticmethod
    def _node_of(thing: Any) -> Node:
        if isinstance(thing, Shape):
            return Node(shape=thing)
        if isinstance(thing, Light):
            return Node(light=thing)
        if isinstance(thing, Object):
            return Node(instance_of=thing)
        if isinstance(thing, (Node, Instances)):
            return Node(children=[thing])
        if isinstance(thing, _messages.Scene):
            return Node(children=thing.nodes)
        raise TypeError(f"{with_article(thing)}; expected a Shape, Light, Node, Object, Scene or a "
                        "sequence of them")

    @tells_unknown
    def instances(self, object: Union[str, PartsLike], transforms: TransformsLike, *,
                  names: Optional[Sequence[str]] = None,
                  material: Optional[Union[str, Material]] = None) -> Instances:
        """Adds many instances of an object, which is stored and built once.

        :param transforms: an array (n, 3, 4) or (n, 4, 4), or a list of transforms.

        Raises what `Instances` raises.
        """
        added = Instances(object, transforms, names, material=material)
        if not isinstance(object, str):
            self._take_definitions(flat(object))
        self.nodes.append(added)
        return added

    def find(self, name: str, kind: Type[V] = Value) -> V:  # type: ignore[assignment]
        """The first part of that name and class: `scene.find("ivory", ts.Classic).diffuse = "red"`.
        Finds whatever of the scene has a name. Raises UsageError where nothing is called so."""
        if not isinstance(name, str):
            raise TypeError(f"name: {name!r:.100}; expected text")
        if not isinstance(kind, type):
            raise TypeError(f"kind: {kind!r:.100}; expected a class")
        named: Dict[Any, V] = {}
        for part in everything_in(self):
            if isinstance(part, kind) and getattr(part, "name", None):
                named.setdefault(getattr(part, "name"), part)
        if name in named:
            return named[name]
        hint = nearest(name, list(named))
        raise UsageError(f"name: {name!r}; expected that of a {kind.__name__} of the scene{hint}")

    @property
    def digest(self) -> str:
        """What names the scene: equal for equal scenes, whenever and wherever they are made."""
        return _core.digest(self)

    @tells_unknown
    def check(self, *, assets: Optional[Path] = None) -> None:
        """Raises SceneError for whatever of the scene a render would refuse, as it builds all that one
        needs, and for names that are used and never defined.

        :param assets: where included files are, as of `render`.
        """
        with located_errors(self):
            undefined = _core.check(self, folder_text(assets))
        if undefined and not self.includes:  # which may define it
            what, mark, hint = undefined[0].partition(";")
            raise SceneError(f"scene: {what} is not defined{mark}{hint}")

    @tells_unknown
    def info(self, *, assets: Optional[Path] = None) -> Summary:
        """Counts of what the scene holds, names that are not used or not defined, and its bounds.

        :param assets: where included files are, as of `render`.
        """
        with logged_at_end():
            return Summary(*_core.summary(self, folder_text(assets)))

    def _repr_html_(self) -> str:
        summary = self.info()
        rest = {"unused": ", ".join(summary.unused), "undefined": ", ".join(summary.undefined)}
        if summary.bounds is not None:
            # They are rounded outward: the least number beside 0 was 0.
            rest["bounds"] = " to ".join(f"({', '.join(f'{x if abs(x) > 1e-300 else 0:.6g}' for x in corner)})"
                                         for corner in summary.bounds)
        return table({**summary.counts, **{what: text for what, text in rest.items() if text}})

    def save(self, path: Path) -> None:
        """Writes the scene by the ending: .tessera (text), .tesserab (binary) or .json. Raises SceneError, with
        the script's line, for what is no scene, UsageError for other endings, RenderError where the file
        cannot be written."""
        _core.save(self, file_name(path))

    def to_dict(self) -> Dict[str, Any]:
        """The scene in protobuf's JSON mapping, which `load_dict` reads."""
        # The hook does nothing, but calling it has Python look for Ctrl-C in between.
        made: Dict[str, Any] = json.loads(_core.to_json(self), object_hook=lambda part: part)
        return made

    @tells_unknown
    def tracer(self, *, time: Optional[float] = None, camera: Optional[str] = None,
               accel: Accelerator = "bvh", threads: Optional[int] = None,
               geometry_only: bool = True, assets: Optional[Path] = None) -> Tracer:
        """What answers questions about rays; see `tessera.rays`.

        :param time: the instant that it shows, in seconds; left out, that of the scene.
        :param camera: the name of the one whose rays `Tracer.camera_rays` makes; left out, the first.
        :param accel: what finds hits; all find the same.
        :param threads: how many build it and trace, from 1 to 1024; one a core if left out.
        :param geometry_only: True, since tracers know no light.
        :param assets: where included files are, as of `render`.

        Raises SceneError, with the script's line, for what cannot be built.
        """
        from . import rays
        with located_errors(self):
            return rays.tracer_from_scene(self, time=time, camera=camera, accel=accel, threads=threads,
                                          geometry_only=geometry_only, assets=assets)

    render = rendering.render

    def frames(self, first: Optional[int] = None, last: Optional[int] = None, *,
               size: Optional[Size] = None, crop: Optional[Crop] = None, camera: Optional[str] = None,
               view: Optional[View] = None, pinhole: bool = False, frame_all: bool = False,
               spp: Optional[int] = None, target_error: Optional[float] = None, min_spp: Optional[int] = None,
               filter: Optional[str] = None, pattern: Optional[Pattern] = None,
               seed: Optional[int] = None, integrator: Optional[Integrator] = None,
               max_depth: Optional[int] = None, shadows: Optional[Shadows] = None,
               accel: Optional[Accelerator] = None, aovs: Aovs = (),
               transparent_background: bool = False, denoise: bool = False,
               place: Union[str, Sequence[str]] = (), assets: Optional[Path] = None,
               environment: Optional[Path] = None, up: Optional[Up] = None, two_sided: bool = False,
               tile: Optional[int] = None, workers: Optional[int] = None, threads: Optional[int] = None,
               verify: Union[None, float, str] = None,
               farm: Optional[BaseFarm] = None, progress: ProgressOption = None,
               on_tile: Optional[TileCallback] = None, **unknown: NoReturn,
               ) -> Iterator[Tuple[int, Image]]:
        """Renders the frames of the numbers `first` to `last`, one after the other: pairs of number and
        picture. The options mean what those of `render` do. Without `farm` the same workers render all of
        them. Numbers left out are those of `settings.frames`, whose `per_second` tells at which time a
        frame is."""
        options = {name: value for name, value in locals().items()
                   if name not in ("self", "first", "last", "unknown")}
        if unknown:
            refuse_unknown("frames", unknown, ["first", "last", *options])
        asked = self.settings.frames if self.settings is not None else None
        if first is None and last is None and asked is None:
            raise UsageError("frames: the scene has none of its own; expected frames(first, last) or "
                             "Scene(frames=(first, last))")
        begin = frame_number("first", first) if first is not None else (asked.first or 0) if asked else 0
        end = frame_number("last", last) if last is not None else (asked.last or 0) if asked else begin
        if end < begin:
            raise UsageError(f"first: {begin}; expected at most {end}, the last frame")
        return self._frames(range(begin, end + 1), options)

    def _frames(self, numbers: range, options: Dict[str, Any]) -> Iterator[Tuple[int, Image]]:
        own = None
        if options["farm"] is None:
            own = rendering.started_farm(*(options.pop(name) for name in ("workers", "threads", "verify")))
            options["farm"] = own
        try:
            for frame in numbers:
                image: Image = self.render(frame=frame, **options)
                yield frame, image
        finally:
            if own is not None:
                own.close()


_SETTINGS = [name for name, held in vars(Scene).items() if isinstance(held, _Setting)]
