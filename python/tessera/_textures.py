"""Textures from arrays and from files."""
from __future__ import annotations

import os
from typing import Any, Literal, Optional, Tuple, Union

from . import _core, _messages
from .errors import MissingFile
from ._transforms import as_ndarray
from ._types import ArrayLike
from ._value import here, slot_of

Wrap = Literal["repeat", "clamp", "mirror", "black"]
Filter = Literal["trilinear", "bilinear", "nearest"]
_BITS = {"B": 8, "e": 16, "f": 32}


class ImageTexture(_messages.ImageTexture):
    """A picture, from an array (h, w) or (h, w, channels) of uint8, float16 or float32, or from a
    file, which is read here and now. Smaller levels for the trilinear filter are made of it.

    The fields are those of the message; see `tessera._messages.ImageTexture`.
    """

    __slots__ = ()

    def __init__(self, picture: Optional[Union[str, "os.PathLike[str]", ArrayLike]] = None, *,
                 encoding: Optional[Literal["srgb", "linear"]] = None,
                 wrap: Optional[Wrap] = None, filter: Optional[Filter] = None,
                 **fields: Any) -> None:
        if wrap is not None:
            fields = {"wrap_s": wrap, "wrap_t": wrap, **fields}
        super().__init__(encoding=encoding, filter=filter, **fields)
        self._place = here()
        if isinstance(picture, (str, os.PathLike)):
            self.file = os.fspath(picture)
            if not os.path.exists(self.file):
                missing = MissingFile(f"{self.file}: there is no such file; expected a picture",
                                      place=self.file)
                missing.filename = self.file
                raise missing
            self._take(_core.read_texture(self.file), encoding)
        elif picture is not None:
            self._take(_core.take_array(picture, "texels"), encoding)

    def _take(self, texels: Any, encoding: Optional[str]) -> None:
        shape = texels.shape
        if len(shape) not in (2, 3) or 0 in shape or (len(shape) == 3 and not 1 <= shape[2] <= 4):
            raise ValueError(f"texels: shape {shape}; expected (h, w) or (h, w, c) with 1 to 4 channels")
        if texels.dtype not in _BITS:
            raise TypeError(f"texels: numbers of type {texels.dtype!r}; expected uint8, float16 or "
                            "float32")
        self.height, self.width = shape[:2]
        self.channels = shape[2] if len(shape) == 3 else 1
        self.bits = _BITS[texels.dtype]
        if encoding is None and self.bits > 8:
            self.encoding = "linear"
        wants_levels = self.filter in (None, "trilinear") and not self.texels_at_corners
        if wants_levels:
            texels, self.levels = _core.with_mip_levels(texels, self.encoding != "linear")
        self.texels = texels


def texture_from(picture: Any) -> ImageTexture:
    """The texture that an array stands for, where a colour or number is wanted."""
    return ImageTexture(picture)
