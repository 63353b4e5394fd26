"""Textures from arrays and from files."""
from __future__ import annotations

import os
import warnings
from typing import NoReturn, Optional, Union

from . import _core, _messages
from ._arguments import plain_text
from ._callers import level_of_caller
from ._messages import ImageTextureEncoding, ImageTextureFilter, ImageTextureWrap, TextureMapping
from ._transforms import Transform
from ._types import ArrayLike, Path
from .errors import MissingFile, SceneWarning, UsageError, in_python

class ImageTexture(_messages.ImageTexture):
    """A picture, from an array (h, w) or (h, w, channels) of uint8, uint16, float16 or float32, or
    from a file, which is read here and now. Smaller levels for the trilinear filter are made of it.

    `wrap` is both `wrap_s` and `wrap_t`. Where `encoding` is left out, integers of any depth are
    codes in sRGB and floats are linear light. `associated_alpha`: the colours of a given array are
    multiplied by alpha; a file tells itself.

    Raises MissingFile where there is no file, SceneError where it holds no picture, TypeError and
    UsageError for arrays of other types and shapes.
    """

    __slots__ = ()

    def __init__(self, picture: Optional[Union[Path, ArrayLike]] = None, *,
                 encoding: Optional[ImageTextureEncoding] = None,
                 wrap: Optional[ImageTextureWrap] = None,
                 filter: Optional[ImageTextureFilter] = None,
                 wrap_s: Optional[ImageTextureWrap] = None,
                 wrap_t: Optional[ImageTextureWrap] = None,
                 texels_at_corners: Optional[bool] = None,
                 associated_alpha: Optional[bool] = None, name: Optional[str] = None,
                 mapping: Optional[TextureMapping] = None, transform: Optional[Transform] = None,
                 texels: Optional[ArrayLike] = None, width: Optional[int] = None,
                 height: Optional[int] = None, channels: Optional[int] = None,
                 bits: Optional[int] = None, levels: Optional[int] = None,
                 file: Optional[str] = None, **unknown: NoReturn) -> None:
        super().__init__(texels=texels, width=width, height=height, channels=channels, bits=bits,
                         levels=levels, wrap_s=wrap_s or wrap, wrap_t=wrap_t or wrap,
                         encoding=encoding, filter=filter, file=file,
                         texels_at_corners=texels_at_corners, associated_alpha=associated_alpha,
                         name=name, mapping=mapping, transform=transform, **unknown)
        if isinstance(picture, (str, os.PathLike)):
            self.file = plain_text("picture", picture)
            if not os.path.exists(self.file):
                raise MissingFile.of(self.file, "a picture")
            texels, is_associated, told = _core.read_texture(self.file, encoding or "")
            for warning in told:
                warnings.warn(in_python(warning), SceneWarning, stacklevel=level_of_caller())
            if is_associated:
                self.associated_alpha = True
            self._take(texels, encoding)
        elif picture is not None:
            self._take(_core.take_texels(picture, encoding or "", bool(associated_alpha)), encoding)

    def _take(self, texels: _core.Array, encoding: Optional[str]) -> None:
        shape = texels.shape
        if len(shape) not in (2, 3) or 0 in shape or (len(shape) == 3 and not 1 <= shape[2] <= 4):
            raise UsageError(f"texels: shape {shape}; expected (h, w) or (h, w, c) with 1 to 4 channels")
        self.height, self.width = shape[:2]
        self.channels = shape[2] if len(shape) == 3 else 1
        self.bits = 8 * memoryview(texels).itemsize  # type: ignore[arg-type]
        if encoding is None and self.bits > 8:
            self.encoding = "linear"
        wants_levels = self.filter in (None, "trilinear") and not self.texels_at_corners
        if wants_levels:
            texels, self.levels = _core.with_mip_levels(texels, self.encoding != "linear",
                                                        bool(self.associated_alpha))
        self.texels = texels


def texture_from(picture: ArrayLike) -> ImageTexture:
    """The texture that an array stands for."""
    return ImageTexture(picture)


def normals_from(picture: ArrayLike) -> ImageTexture:
    """The same of normals, which are no colours."""
    return ImageTexture(picture, encoding="linear")
