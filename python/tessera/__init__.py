"""Tessera, a ray-tracing renderer: scenes as values, pictures and ray queries as arrays."""
from . import compat
from ._core import Array
from .errors import (Cancelled, Error, FarmError, MissingFile, PrecisionWarning, Refused, RenderError,
                     SceneError, SceneWarning, UsageError)
from .rays import AllHits, Hits, Tracer

__all__ = ["AllHits", "Array", "Cancelled", "Error", "FarmError", "Hits", "MissingFile",
           "PrecisionWarning", "Refused", "RenderError", "SceneError", "SceneWarning", "Tracer",
           "UsageError", "compat"]
