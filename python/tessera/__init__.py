"""Tessera, a ray-tracing renderer: scenes as values, pictures and ray queries as arrays."""
from ._core import Array
from .errors import (Cancelled, Error, FarmError, MissingFile, PrecisionWarning, Refused, RenderError,
                     SceneError, SceneWarning, UsageError)

__all__ = ["Array", "Cancelled", "Error", "FarmError", "MissingFile", "PrecisionWarning", "Refused",
           "RenderError", "SceneError", "SceneWarning", "UsageError"]
