"""Tessera, a ray-tracing renderer: scenes as values, pictures and ray queries as arrays."""
from . import _loading

_loading.check()  # Before anything else loads the extension module.
from . import compat
from ._core import Array, version as __version__
from ._program import program
from .errors import (Cancelled, Error, FarmError, MissingFile, PrecisionWarning, Refused, RenderError,
                     SceneError, SceneWarning, UsageError)
from .farm import Farm, Job
from .picture import Image, Metrics, Rect, compare, read_image
from .rays import AllHits, Hits, Tracer
from .rendering import LocalFarm, Progress, Task, Threads, render

__all__ = [
    "AllHits",
    "Array",
    "Cancelled",
    "Error",
    "Farm",
    "FarmError",
    "Hits",
    "Image",
    "Job",
    "LocalFarm",
    "Metrics",
    "MissingFile",
    "PrecisionWarning",
    "Progress",
    "Rect",
    "Refused",
    "RenderError",
    "SceneError",
    "SceneWarning",
    "Task",
    "Threads",
    "Tracer",
    "UsageError",
    "compare",
    "compat",
    "program",
    "read_image",
    "render",
]
