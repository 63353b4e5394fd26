"""Cameras, lenses and backgrounds by the words that scripts have for them."""
from __future__ import annotations

import functools
import math
from typing import (TYPE_CHECKING, Any, Callable, Generic, Iterable, NoReturn, Optional, ParamSpec,
                    TypeVar, overload)

from . import _messages
from ._arguments import number, whole
from ._core import Vec
from ._messages import (BackgroundCube, BackgroundGradient, BackgroundPanorama, BackgroundRings,
                        BackgroundSunAndSky, LensFocalSurface, LensRadiusUnit, LensShape, Light,
                        Orthographic, Panoramic, Perspective, PerspectiveAxis, TransformKey)
from ._transforms import Transform, look_at, matrix
from ._types import ColorLike, VectorLike
from .errors import UsageError

if TYPE_CHECKING:
    from ._types import Doubles

Arguments = ParamSpec("Arguments")
Field = TypeVar("Field")


class Camera(_messages.Camera):
    """Where the picture is taken from. Looks along its own -z, with +y up in the picture.
    """

    __slots__ = ()

    @property
    def pose(self) -> Doubles:
        """world_from_camera as a 4x4 matrix of float64. The camera's x axis points right, y up and z
        backwards, as in OpenGL: `pose @ numpy.diag([1, -1, -1, 1])` is the pose in OpenCV's axes.
        UsageError where the camera moves by `keys`. Assigning a (3, 4) or (4, 4) matrix sets
        world_from_camera and ends the motion."""
        from ._numpy import numpy as np
        if self.keys:
            raise UsageError("pose: of a camera that moves; expected one without keys, whose transforms "
                             "are in camera.keys")
        pose: Doubles = np.eye(4)
        if self.world_from_camera is not None:
            pose[:3] = Transform(self.world_from_camera.steps).array
        return pose

    @pose.setter
    def pose(self, rows: Doubles) -> None:
        self.world_from_camera = matrix(rows)
        self.keys = []

    @classmethod
    def from_intrinsics(cls, fx: float, fy: float, cx: float, cy: float, width: int, height: int, *,
                        world_from_camera: Optional[Transform] = None,
                        name: Optional[str] = None, description: Optional[str] = None,
                        keys: Optional[Iterable[TransformKey]] = None, lens: Optional[Lens] = None,
                        headlight: Optional[Light] = None, near_distance: Optional[float] = None,
                        far_distance: Optional[float] = None, frame_all: Optional[bool] = None,
                        **unknown: NoReturn) -> Camera:
        """The camera of the intrinsic matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] of a calibration
        without distortion.

        Pixels are counted as OpenCV does: the middle of the top left one is (0, 0), so that a principal
        point in the middle of the picture is ((width - 1) / 2, (height - 1) / 2). Pictures rendered
        with `size=(width, height)` are those of the calibration; other sizes of that shape see the
        same. Raises UsageError for numbers out of their range.

        :param fx: the focal length in widths of a pixel, above 0; `fy` in heights of a pixel, from
            fx / 1000 to 1000 fx.
        :param cx: the principal point in pixels, `cx` to the right and `cy` down; it may lie outside.
        :param width: the picture's columns; `height` its rows.
        :param world_from_camera: the place, in the axes of `pose`.
        """
        numbers = {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
        fx, fy, cx, cy = (number(name, value) for name, value in numbers.items())
        for axis, length in (("fx", fx), ("fy", fy)):
            if not 0 < length < math.inf:
                raise UsageError(f"{axis}: {length}; expected a focal length above 0, in pixels")
        if not 1e-3 <= fy / fx <= 1e3:
            raise UsageError(f"fy: {fy}; expected a number from fx / 1000 to 1000 fx, which is {fx}")
        for side, count in (("width", width), ("height", height)):
            if whole(side, count) < 1:
                raise UsageError(f"{side}: {count}; expected at least 1 pixel")
        # Raster points have the top left corner of the picture at (0, 0).
        perspective = Perspective(2 * math.degrees(math.atan(width / (2 * fx))), "horizontal",
                                  shift_x=0.5 - (cx + 0.5) / width, shift_y=(cy + 0.5) / height - 0.5,
                                  pixel_aspect=fy / fx)
        return cls(name=name, description=description, world_from_camera=world_from_camera, keys=keys,
                   perspective=perspective, lens=lens, headlight=headlight,
                   near_distance=near_distance, far_distance=far_distance, frame_all=frame_all,
                   **unknown)

    @classmethod
    def screen(cls, eye: VectorLike, centre: VectorLike, width: float, *,
               name: Optional[str] = None, description: Optional[str] = None,
               keys: Optional[Iterable[TransformKey]] = None, lens: Optional[Lens] = None,
               headlight: Optional[Light] = None, near_distance: Optional[float] = None,
               far_distance: Optional[float] = None, frame_all: Optional[bool] = None,
               **unknown: NoReturn) -> Camera:
        """A camera at `eye` that looks at `centre` through a screen half-way between them, `width`
        metres wide and as high as the picture's shape makes it; up is (0, 0, 1). `eye` and `centre` are
        points in metres. Raises TypeError or UsageError for what is no vector of three numbers.
        """
        distance = (Vec(centre) - Vec(eye)).length
        angle = 2 * math.degrees(math.atan2(width, distance))
        return cls.look_at(eye, centre, (0, 0, 1), angle, "horizontal", name=name,
                           description=description, keys=keys, lens=lens, headlight=headlight,
                           near_distance=near_distance, far_distance=far_distance,
                           frame_all=frame_all, **unknown)

    @classmethod
    def look_at(cls, eye: VectorLike, target: VectorLike, up: VectorLike = (0, 1, 0),
                fov: Optional[float] = None, axis: Optional[PerspectiveAxis] = None, *,
                name: Optional[str] = None, description: Optional[str] = None,
                keys: Optional[Iterable[TransformKey]] = None,
                perspective: Optional[Perspective] = None,
                orthographic: Optional[Orthographic] = None, spherical: Optional[Panoramic] = None,
                cylindrical: Optional[Panoramic] = None, lens: Optional[Lens] = None,
                headlight: Optional[Light] = None, near_distance: Optional[float] = None,
                far_distance: Optional[float] = None, frame_all: Optional[bool] = None,
                **unknown: NoReturn) -> Camera:
        """A camera at the point `eye` that looks at the point `target`, both in metres, with the direction
        `up` upwards in the picture; `fov` in degrees, above 0 and below 180, spans the picture's `axis`.

        A render raises SceneError for values out of their range, and for a target at the eye."""
        if perspective is None and (fov is not None or axis is not None):
            perspective = Perspective(fov, axis)
        return cls(name=name, description=description, world_from_camera=look_at(eye, target, up),
                   keys=keys, perspective=perspective, orthographic=orthographic,
                   spherical=spherical, cylindrical=cylindrical, lens=lens, headlight=headlight,
                   near_distance=near_distance, far_distance=far_distance, frame_all=frame_all,
                   **unknown)


class Lens(_messages.Lens):
    """A lens, whose radius blurs what is not in focus.

    Two keywords are short: `radius` for both radii, `focus` for the focal distance. A render raises
    SceneError for numbers out of their range.
    """

    __slots__ = ()

    def __init__(self, radius_x: Optional[float] = None, radius_y: Optional[float] = None,
                 focal_distance: Optional[float] = None, shape: Optional[LensShape] = None,
                 blades: Optional[int] = None, focal_surface: Optional[LensFocalSurface] = None,
                 samples: Optional[int] = None, radius_unit: Optional[LensRadiusUnit] = None, *,
                 radius: Optional[float] = None, focus: Optional[float] = None,
                 **unknown: NoReturn) -> None:
        if radius is not None:
            radius_x = radius_y = radius
        if focus is not None:
            focal_distance = focus
        super().__init__(radius_x=radius_x, radius_y=radius_y, focal_distance=focal_distance,
                         shape=shape, blades=blades, focal_surface=focal_surface, samples=samples,
                         radius_unit=radius_unit, **unknown)


class _FieldOrMaker(Generic[Arguments, Field]):
    """On a value the field of that name, on the class the function that makes a value with it."""

    def __init__(self, name: str, make: Callable[Arguments, Field]) -> None:
        self._name, self._make = name, make
        self._slot: Any = _messages.Background.__dict__[name]
        self.__doc__ = make.__doc__

    @overload
    def __get__(self, background: None, made: Any) -> Callable[Arguments, Background]: ...
    @overload
    def __get__(self, background: _Makers, made: Any = None) -> Optional[Field]: ...
    def __get__(self, background: Optional[_Makers], made: Any = None) -> Any:
        if background is not None:
            return self._slot.__get__(background)

        @functools.wraps(self._make, updated=())
        def maker(*arguments: Arguments.args, **fields: Arguments.kwargs) -> Any:
            return made(**{self._name: self._make(*arguments, **fields)})

        return maker

    def __set__(self, background: _Makers, value: Optional[Field]) -> None:
        self._slot.__set__(background, value)


def _solid(color: ColorLike) -> ColorLike:
    """One colour everywhere."""
    return color


class _Makers:
    """`Background.solid("skyblue")`, `Background.gradient(...)` and the like."""

    __slots__ = ()

    solid = _FieldOrMaker("solid", _solid)
    gradient = _FieldOrMaker("gradient", BackgroundGradient)
    rings = _FieldOrMaker("rings", BackgroundRings)
    panorama = _FieldOrMaker("panorama", BackgroundPanorama)
    cube = _FieldOrMaker("cube", BackgroundCube)
    sun_and_sky = _FieldOrMaker("sun_and_sky", BackgroundSunAndSky)


# The attributes of the two bases differ on purpose: a maker has the field's type on values alone.
class Background(_Makers, _messages.Background):  # type: ignore[misc]
    """What rays see that meet nothing. `Background.solid("skyblue")`, `Background.gradient(...)` and
    the like make one.
    """

    __slots__ = ()
