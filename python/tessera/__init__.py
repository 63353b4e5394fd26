"""Tessera, a ray-tracing renderer: scenes as values, pictures and ray queries as arrays."""
from ._core import Array
from .errors import (Cancelled, Error, FarmError, MissingFile, PrecisionWarning, Refused, RenderError,
                     SceneError, SceneWarning, UsageError)
from .farm import Farm, Job
from .picture import Image, Metrics, Rect, compare, read_image
from .rendering import LocalFarm, Progress, Task, Threads, render

__all__ = ["Farm", "Image", "Job", "LocalFarm", "Metrics", "Progress", "Rect", "Task", "Threads", "compare",
           "read_image", "render", "Array", "Cancelled", "Error", "FarmError", "MissingFile", "PrecisionWarning", "Refused",
           "RenderError", "SceneError", "SceneWarning", "UsageError"]
