"""Pictures: what a render gives, as arrays, files and bytes to show."""
from __future__ import annotations

import functools
import json
import os
import warnings
from typing import (TYPE_CHECKING, Any, Callable, List, Literal, NamedTuple, NoReturn, Optional, Tuple,
                    Union, overload)

from . import _core
from ._arguments import boolean, file_name, named_text, refuse_unknown, with_article
from ._array import as_ndarray, plain_array
from ._callers import level_of_caller
from ._options import option_texts
from ._types import Aov, ArrayLike, FloatAov, Path, ToneMap, Transfer
from .errors import MissingFile, SceneWarning, UsageError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._types import Floats

_MOST_SHOWN = 2048  # columns of a picture in a notebook


class Rect(NamedTuple):
    """Pixels x0 <= x < x1 and y0 <= y < y1 of a frame, from its top left."""

    x0: int
    y0: int
    x1: int
    y1: int


class Metrics(NamedTuple):
    """How far a picture is from another, the reference, in linear light: what `tessera compare
    --metrics` tells. Means are over all channels. A value that is no finite number is infinitely far
    from others for `max`, `mean`, `rmse` and `max_of`, and counts as equal for the rest."""

    max: float
    """The greatest difference."""
    mean: float
    """The mean difference."""
    rmse: float
    """The root of the mean square difference."""
    rel_mse: float
    """The mean of d^2 / (reference^2 + .01)."""
    flip: float
    """The mean of FLIP (Andersson et al. 2020), 0 to 1."""
    ssim: float
    """The mean structural similarity (Wang et al. 2004) of what is shown: 1 for equal pictures."""
    trimmed_rel_mse: float
    """`rel_mse` without the largest thousandth of its terms."""
    smape: float
    """The mean of 2 |d| / (|value| + |reference| + .01), 0 to 2."""
    error_99_9: float
    """The difference that all but a thousandth of the values stay within."""
    mean_ratio: float
    """The mean of the picture over that of the reference."""
    not_finite: int
    """How many values of the picture are no finite number."""
    max_of: Tuple[float, float, float]
    """The greatest difference of red, green and blue."""
    differing: int
    """How many pixels differ."""
    where: Optional[Rect]
    """The part of the picture that they all lie in; None where none differs."""
    worst: Optional[Tuple[int, int]]
    """The column and row of the pixel that differs most; None where none differs."""


class Image:
    """A linear picture, and the AOVs that were asked for. Immutable; rows from the top. Two are
    equal that have the same bits in both.

    `stats` is what `tessera render --stats` writes; `holes` are tiles that nobody could trace.
    """

    __slots__ = ("_picture", "_has_16_bits", "__dict__")
    _picture: _core.Picture
    _has_16_bits: bool  # it was made of integers of 16 bits

    def __init__(self) -> None:
        raise TypeError("Image: made by render(), read_image() or Image.from_array()")

    @classmethod
    def _of(cls, picture: _core.Picture, has_16_bits: bool = False) -> "Image":
        image = cls.__new__(cls)
        object.__setattr__(image, "_picture", picture)
        object.__setattr__(image, "_has_16_bits", has_16_bits)
        return image

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        raise AttributeError(f"Image.{name} cannot be assigned to: a picture never changes")

    @classmethod
    def from_array(cls, array: ArrayLike, linear: Optional[bool] = None) -> "Image":
        """A picture of (h, w, 3) numbers, or (h, w) grey ones.

        :param linear: whether they are linear light, or codes in sRGB as most files hold. Left out:
            floats are light; uint8 and uint16, from 0 to their largest value, are codes.

        Raises UsageError for another shape or masked values, TypeError for other types.
        """
        values: npt.NDArray[Any] = plain_array("array", array)
        light = _light_of(values, None if linear is None else boolean("linear", linear))
        picture = _core.picture_from_values(light.shape[1], light.shape[0], light)
        return cls._of(picture, values.dtype.kind == "u" and values.dtype.itemsize == 2)

    @property
    def width(self) -> int:
        """Pixels a row, of the crop if there was one."""
        return self._picture.width

    @property
    def height(self) -> int:
        """Rows of pixels, of the crop if there was one."""
        return self._picture.height

    @property
    def size(self) -> Tuple[int, int]:
        """(width, height) in pixels, as `render` takes it."""
        return self.width, self.height

    @property
    def shape(self) -> Tuple[int, int, int]:
        """(height, width, 3), in pixels: that of `linear`."""
        return self.height, self.width, 3

    @functools.cached_property
    def linear(self) -> Floats:
        """Radiance as (h, w, 3) float32, read-only: a view of the film's own memory, in which the AOVs of a
        pixel follow its light."""
        values: Any = as_ndarray(self._picture.values)
        light: Floats = values[..., :3] if hasattr(values, "strides") else self._picture.light()
        return light

    @property
    def aovs(self) -> List[Aov]:
        """The names of the AOVs that it has."""
        return self._picture.aovs

    @overload
    def aov(self, name: Literal["id", "origin", "primitive"]) -> npt.NDArray[np.uint32]: ...
    @overload
    def aov(self, name: FloatAov) -> Floats: ...
    def aov(self, name: Aov) -> Any:
        """What was asked for by `aovs`, read-only: albedo, normal, position and variance are (h, w, 3)
        float32, depth and samples (h, w) float32, all views of the film's own memory; id and primitive
        are (h, w) uint32, origin (h, w, 8) uint32. Raises UsageError for one that was not rendered."""
        if not isinstance(name, str):
            raise TypeError(f"name: {name!r:.100}; expected the name of an AOV")
        return self._channels(named_text("name", name))

    @property
    def alpha(self) -> Optional[Floats]:
        """The share of each pixel that is not background, read-only: (h, w) float32, by which `linear` is
        multiplied. None of a picture without a transparent background."""
        alpha: Optional[Floats] = self._channels("alpha") if self._picture.has_alpha else None
        return alpha

    def _channels(self, name: str) -> Any:
        first, count, is_whole = self._picture.channels_of(name)
        values: Any = as_ndarray(self._picture.values)
        if is_whole or not hasattr(values, "strides"):
            return as_ndarray(self._picture.channels(name))
        return values[..., first] if count == 1 else values[..., first:first + count]

    def auto_exposure(self) -> float:
        """The stops that bring the picture to middle grey, by the log-average of its luminance without the
        brightest and darkest tenth; of surfaces alone where there is alpha or one of the AOVs depth and id."""
        return self._picture.auto_exposure()

    def to_srgb(self, *, exposure: Union[None, float, Literal["auto"]] = None,
                tone_map: Optional[ToneMap] = None,
                transfer: Optional[Transfer] = None, gamma: Optional[float] = None,
                ocio_view: Optional[str] = None, ocio_display: Optional[str] = None,
                ocio_space: Optional[str] = None, ocio_input: Optional[str] = None,
                **unknown: NoReturn) -> npt.NDArray[np.uint8]:
        """The bytes of the PNG as (h, w, 3) uint8. The keywords are those of `Image.save`. Raises UsageError for
        values that they cannot have."""
        output = {"exposure": exposure, "tone_map": tone_map, "transfer": transfer, "gamma": gamma,
                  "ocio_view": ocio_view, "ocio_display": ocio_display, "ocio_space": ocio_space,
                  "ocio_input": ocio_input}
        if unknown:
            refuse_unknown("to_srgb", unknown, list(output))
        values: npt.NDArray[np.uint8] = as_ndarray(self._picture.to_srgb(option_texts(output)))
        return values

    def save(self, *paths: Path, bits: Optional[Literal[8, 16]] = None,
             exposure: Union[None, float, Literal["auto"]] = None, tone_map: Optional[ToneMap] = None,
             transfer: Optional[Transfer] = None, gamma: Optional[float] = None,
             ocio_view: Optional[str] = None, ocio_display: Optional[str] = None,
             ocio_space: Optional[str] = None, ocio_input: Optional[str] = None,
             **unknown: NoReturn) -> None:
        """Writes files whose endings name their formats. Each appears whole or not at all; where some
        cannot be written, the others are all the same. What is left out is as the scene says.

        Raises UsageError for a picture made of uint16 whose values a file of 8 bits would round, unless
        `bits=8` asks for that. A SceneWarning tells of AOVs that none of the files can hold.

        :param bits: of a channel in files of integers, 8 or, for PNG and TIFF, 16; default 8. Files of
            floats (EXR, HDR, PFM) hold the light as it is.
        :param exposure: stops by which light is made brighter, before all else; "auto": those of
            `auto_exposure`; default 0.
        :param tone_map: how light above 1 is shown; default "clamp".
        :param transfer: how light becomes 8-bit numbers; default "srgb".
        :param gamma: of the transfer "gamma"; default 2.2.
        :param ocio_view: show by this view of $OCIO, with `ocio_display` and from the colour space
            `ocio_input`, in place of tone map and transfer.
        :param ocio_space: write in this colour space of $OCIO.
        """
        output = {"exposure": exposure, "tone_map": tone_map, "transfer": transfer, "gamma": gamma,
                  "ocio_view": ocio_view, "ocio_display": ocio_display, "ocio_space": ocio_space,
                  "ocio_input": ocio_input}
        if unknown:
            refuse_unknown("save", unknown, ["bits", *output])
        if not paths:
            raise TypeError("save: no path; expected at least one")
        names = [file_name(path) for path in paths]
        if bits is None and self._has_16_bits:
            self._refuse_rounding(names)
        self._picture.save(names, option_texts({"bits": bits, **output}))
        if self.aovs and not any(map(_core.holds_aovs, names)):
            warnings.warn(f"save: {os.fsdecode(names[0])!r} cannot hold {', '.join(self.aovs)}; expected "
                          "an EXR file among those saved", SceneWarning, stacklevel=level_of_caller())

    def _refuse_rounding(self, names: List[bytes]) -> None:
        """Raises UsageError where one of the files would hold fewer bits than the array did."""
        for name in names:
            if not _core.holds_floats(name):
                raise UsageError(f"bits: left out for {os.fsdecode(name)!r}, of a picture made of uint16; "
                                 "expected 16, which PNG and TIFF hold, or 8 to round it")

    def apply(self, f: Callable[[Floats], ArrayLike]) -> "Image":
        """The picture with other light: `f` of that of this one, an array (h, w, 3). All else is
        kept: what is beside light, what the scene asks of the numbers, holes and statistics. Raises
        UsageError where `f` returns another shape, and what `f` raises."""
        light = _light_of(f(self.linear), None)
        if light.shape != self.linear.shape:
            raise UsageError(f"apply: f makes an array of shape {light.shape}; expected "
                             f"{self.linear.shape}, that of the picture")
        return Image._of(self._picture.with_light(light), self._has_16_bits)

    @property
    def stats(self) -> dict[str, Any]:
        """A dict of what was done, counted and timed; empty where the picture was not rendered."""
        text = self._picture.statistics
        stats: dict[str, Any] = json.loads(text) if text else {}
        return stats

    @property
    def holes(self) -> List[Rect]:
        """Tiles that could not be traced, marked in the picture."""
        return [Rect(*hole) for hole in self._picture.holes]

    @functools.cached_property
    def sha256(self) -> str:
        """SHA-256 of the linear pixels, as `tessera render --stats` tells it of a picture."""
        return self._picture.sha256()

    def __array__(self, dtype: Optional[npt.DTypeLike] = None) -> npt.NDArray[Any]:
        return self.linear if dtype is None else self.linear.astype(dtype)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Image) and self._picture.equals(other._picture)

    def __hash__(self) -> int:
        return hash(self.sha256)

    def __repr__(self) -> str:
        beside = f" with {', '.join(self.aovs)}" if self.aovs else ""
        return f"<Image {self.width}x{self.height}{beside}>"

    def _repr_png_(self) -> bytes:
        step = -(-self.width // _MOST_SHOWN)
        shown = self if step == 1 else Image.from_array(self.to_srgb()[::step, ::step])
        return shown._picture.encode("shown.png", [])

    def __reduce__(self) -> Tuple[Any, ...]:
        return _unpickled, (_core.picture_state(self._picture), self._has_16_bits)

    def __copy__(self) -> Image:
        return self

    def __deepcopy__(self, _: object) -> Image:
        return self


def _unpickled(state: Any, has_16_bits: bool = False) -> Image:
    return Image._of(_core.picture_of_state(state), has_16_bits)


def _light_of(array: ArrayLike, linear: Optional[bool]) -> Floats:
    """The array as linear light, (h, w, 3)."""
    from ._numpy import numpy
    values: npt.NDArray[Any] = plain_array("array", array)
    if values.ndim == 2:
        values = numpy.repeat(values[:, :, None], 3, axis=2)
    if values.ndim == 3 and values.shape[2] == 4:
        raise UsageError(f"array: shape {values.shape}; expected (h, w, 3), as pictures have no alpha: "
                         "multiply it in, or leave it out by array[..., :3]")
    if values.ndim != 3 or values.shape[2] != 3 or 0 in values.shape:
        raise UsageError(f"array: shape {values.shape}; expected (h, w, 3) or (h, w)")
    is_code = values.dtype.kind == "u" and values.dtype.itemsize <= 2
    if values.dtype.kind != "f" and not is_code:
        raise TypeError(f"array: numbers of type {values.dtype}; expected floats, uint8 or uint16")
    if is_code if linear is None else not linear:
        values = as_ndarray(_core.linear_of_srgb(values))
    elif is_code:
        values = values / numpy.iinfo(values.dtype).max
    return numpy.ascontiguousarray(values, dtype=numpy.float32)


def read_image(path: Path) -> Image:
    """The picture in a file as linear light: whole numbers are taken for sRGB, as most files hold;
    floats are light, and those that are infinite or no number stay. Where there is alpha it is what the
    picture shows before black. Of EXR the pixels in the display window are read, those of the crop if it
    was one, of the first part that has colours.

    Other channels of the file, such as AOVs, are left out. Raises MissingFile where there is none, and
    SceneError for a file that holds no picture."""
    return _read(file_name(path))


def _read(name: bytes) -> Image:
    if not os.path.exists(name):
        raise MissingFile.of(os.fsdecode(name), "a picture")
    picture, told = _core.picture_from_file(name)
    if told:
        warnings.warn(f"{os.fsdecode(name)}: {told}", SceneWarning, stacklevel=level_of_caller())
    return Image._of(picture)


def compare(a: Union[Image, Path], b: Union[Image, Path]) -> Metrics:
    """How far picture a is from picture b, the reference, in linear light: images, or paths of files. AOVs
    are left out. Raises UsageError for pictures of different sizes, and what `read_image` raises."""
    first, second = _picture_of("a", a), _picture_of("b", b)
    if (first.width, first.height) != (second.width, second.height):
        raise UsageError(f"b: size {second.width}x{second.height}; expected {first.width}x"
                         f"{first.height}, that of a")
    told = _core.compare(first._picture, second._picture)
    differ = told["differing"] > 0
    told.update(where=Rect(*told["where"]) if differ else None, worst=told["worst"] if differ else None)
    return Metrics(**told)


def _picture_of(name: str, given: Union[Image, Path]) -> Image:
    if isinstance(given, Image):
        return given
    if not isinstance(given, (str, bytes, os.PathLike)):
        raise TypeError(f"{name}: {with_article(given)}; expected an Image or the path of a file")
    return _read(file_name(given, name))
