"""The words of a classic toolbox for ray tracing that are no words of a scene."""
from __future__ import annotations

from typing import NoReturn, Optional, Union

from . import _messages
from ._arguments import refuse_unknown
from ._colors import color
from ._core import Vec
from ._messages import (ClassicDiffuseModel, ClassicTransmission, Material, MaterialAlpha,
                       MaterialSides, Texture)
from ._types import ColorLike, VectorLike
from ._value_types import ColorInputLike, FloatInputLike

#: Film responses (a, b, c) for `Scene(response=...)`: of light x in [0, 1] the picture shows
#: a x^2 + b x + c. The first brightens dark parts, the second hardly changes anything.
LIGHT_1 = (-1.2, 2.2, 0.0)
LIGHT_2 = (0.476, 0.5239, 0.0)


def reflect(v: VectorLike, n: VectorLike) -> Vec:
    """The vector `v`, a direction, mirrored in a surface with the normal `n`, which may have any length but 0.
    The result is as long as `v`. Raises UsageError for a normal of length 0.
    """
    normal = Vec(n).normalized()
    direction = Vec(v)
    return direction - normal * (2 * direction.dot(normal))


class Classic(_messages.Classic):
    """The local illumination model of the classic ray tracers.
    """

    __slots__ = ()

    @classmethod
    def toolbox(cls, *, diffuse: Optional[float] = None, ambient: float = 0, highlight: float = 0,
                colour: ColorLike = "white", roughness: float = 0, mirror: bool = False,
                emission: Optional[ColorInputLike] = None,
                transparency: Optional[FloatInputLike] = None,
                refractive_index: Optional[float] = None,
                transmission: Optional[ClassicTransmission] = None,
                absorption: Optional[ColorLike] = None,
                diffuse_model: Optional[ClassicDiffuseModel] = None,
                diffuse_exponent: Optional[float] = None, flat: Optional[bool] = None,
                name: Optional[str] = None, sides: Optional[MaterialSides] = None,
                back: Optional[Union[str, Material]] = None,
                normal_map: Optional[Union[str, Texture]] = None,
                bump: Optional[FloatInputLike] = None, alpha: Optional[MaterialAlpha] = None,
                alpha_cutoff: Optional[float] = None, opacity: Optional[FloatInputLike] = None,
                normal_scale: Optional[float] = None, **unknown: NoReturn) -> Classic:
        """The material of a brightness: the ambient light of the scene times `ambient`, and for each
        light that is not hidden `diffuse` times the cosine of its angle, and `highlight` times that
        of its angle to the mirrored view (Phong, exponent 1, white).

        The brightness multiplies the colour; in the toolbox it was its HSL lightness, which is the
        same for greys alone: half was the pure colour there, and full was white.

        :param diffuse: a share from 0 to 1; left out it is 1, or 0 for a mirror.
        :param roughness: takes up to .3 times this off the brightness, by lot at each point.
        :param mirror: adds all that is seen in an ideal mirror.

        Raises UsageError for a colour that is none; a render raises SceneError for numbers out of
        their range.
        """
        if unknown:
            refuse_unknown("toolbox", unknown, [*cls.toolbox.__func__.__kwdefaults__])  # type: ignore[attr-defined]
        if diffuse is None:
            diffuse = 0 if mirror else 1
        tint = Vec(color(colour))
        return cls(diffuse=tint * diffuse, ambient=tint * ambient, specular=(highlight,) * 3,
                   specular_model="phong", shininess=1, grain=roughness,
                   reflectivity=(1, 1, 1) if mirror else None, emission=emission,
                   transparency=transparency, refractive_index=refractive_index,
                   transmission=transmission, absorption=absorption, diffuse_model=diffuse_model,
                   diffuse_exponent=diffuse_exponent, flat=flat, name=name, sides=sides, back=back,
                   normal_map=normal_map, bump=bump, alpha=alpha, alpha_cutoff=alpha_cutoff,
                   opacity=opacity, normal_scale=normal_scale)
