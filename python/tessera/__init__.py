"""Tessera, a ray-tracing renderer: scenes as values, pictures and ray queries as arrays."""
from . import _loading

_loading.check()  # Before anything else loads the extension module.
from ._core import Array, version as __version__
from ._program import program
from .errors import (Cancelled, Error, FarmError, MissingFile, PrecisionWarning, Refused, RenderError,
                     SceneError, SceneWarning, UsageError)

__all__ = ["Array", "Cancelled", "Error", "FarmError", "MissingFile", "PrecisionWarning", "Refused",
           "RenderError", "SceneError", "SceneWarning", "UsageError", "program"]
