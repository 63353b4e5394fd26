"""Cameras, lenses and backgrounds by the words that scripts have for them."""
from __future__ import annotations

import math
from typing import Any, Callable, Iterable, Literal, Optional, Tuple, Union

from . import _messages
from ._core import Vec
from ._messages import (BackgroundCube, BackgroundGradient, BackgroundPanorama, BackgroundRings,
                        BackgroundSunAndSky, Perspective, Texture)
from ._transforms import look_at
from ._types import ColorLike, VectorLike
from ._value import here

Axis = Literal["smaller", "vertical", "horizontal", "larger"]


class Camera(_messages.Camera):
    """Where the picture is taken from. Looks along its own -z, with +y up in the picture.

    The fields are those of the message; see `tessera._messages.Camera`.
    """

    __slots__ = ()

    @classmethod
    def screen(cls, eye: VectorLike, centre: VectorLike, width: float, **fields: Any) -> Camera:
        """A camera at `eye` that looks at `centre` through a screen half-way between them, `width`
        metres wide and as high as the picture's shape makes it; up is (0, 0, 1).
        """
        distance = (Vec(centre) - Vec(eye)).length
        angle = 2 * math.degrees(math.atan2(width, distance))
        camera = cls.look_at(eye, centre, (0, 0, 1), angle, "horizontal", **fields)
        camera._place = here()
        return camera

    @classmethod
    def look_at(cls, eye: VectorLike, target: VectorLike, up: VectorLike = (0, 1, 0),
                fov: Optional[float] = None, axis: Optional[Axis] = None, **fields: Any) -> Camera:
        """A camera at `eye` that looks at `target`; `fov` in degrees spans the picture's `axis`."""
        if fov is not None or axis is not None:
            fields.setdefault("perspective", Perspective(fov, axis))
        camera = cls(world_from_camera=look_at(eye, target, up), **fields)
        camera._place = here()
        return camera


class Lens(_messages.Lens):
    """A lens, whose radius blurs what is not in focus.

    The fields are those of the message, and two short ones: `radius` for both radii, `focus` for
    the focal distance.
    """

    __slots__ = ()

    def __init__(self, *arguments: Any, radius: Optional[float] = None,
                 focus: Optional[float] = None, **fields: Any) -> None:
        if radius is not None:
            fields.update(radius_x=radius, radius_y=radius)
        if focus is not None:
            fields["focal_distance"] = focus
        super().__init__(*arguments, **fields)
        self._place = here()


class _FieldOrMaker:
    """On a value the field of that name, on the class the function that makes a value with it."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self._make = make
        self._slot: Any = _messages.Background.__dict__[make.__name__]
        self.__doc__ = make.__doc__

    def __get__(self, background: Optional[Background], made: Any = None) -> Any:
        if background is None:
            return lambda *arguments, **fields: made(
                **{self._make.__name__: self._make(*arguments, **fields)})
        return self._slot.__get__(background)

    def __set__(self, background: Background, value: Any) -> None:
        self._slot.__set__(background, value)


def _solid(color: ColorLike) -> ColorLike:
    """One colour everywhere."""
    return color


def _named(name: str, make: Callable[..., Any]) -> Any:
    made: Any = lambda *arguments, **fields: make(*arguments, **fields)
    made.__name__, made.__doc__ = name, make.__doc__
    return _FieldOrMaker(made)


class Background(_messages.Background):
    """What rays see that meet nothing. `Background.solid("skyblue")`, `Background.gradient(...)` and
    the like make one; the fields are those of the message.
    """

    __slots__ = ()

    solid: Any = _named("solid", _solid)
    gradient: Any = _named("gradient", BackgroundGradient)
    rings: Any = _named("rings", BackgroundRings)
    panorama: Any = _named("panorama", BackgroundPanorama)
    cube: Any = _named("cube", BackgroundCube)
    sun_and_sky: Any = _named("sun_and_sky", BackgroundSunAndSky)
