"""Tessera, a ray-tracing renderer: scenes as values, pictures and ray queries as arrays."""
from . import _loading

_loading.check()  # Before anything else loads the extension module.
from . import _messages, compat
from ._messages import *  # Before what stands over some of its classes.
from ._colors import Color, color, hsl
from ._core import Array, Vec, version as __version__
from ._graph import Instances
from ._load import load, load_dict
from ._mesh import Mesh
from ._program import program
from ._shapes import Plane
from ._textures import ImageTexture
from ._transforms import Transform, keys, look_at, matrix, rotate, scale, translate
from ._value import Value
from ._view import Background, Camera, Lens
from .errors import (Cancelled, Error, FarmError, MissingFile, PrecisionWarning, Refused, RenderError,
                     SceneError, SceneWarning, UsageError)
from .farm import Farm, Job
from .picture import Image, Metrics, Rect, compare, read_image
from .rays import AllHits, Hits, Tracer
from .rendering import LocalFarm, Progress, Task, Threads, render
from .scene import Scene, Summary

__all__ = [
    *_messages.__all__,
    "AllHits",
    "Array",
    "Background",
    "Camera",
    "Cancelled",
    "Color",
    "Error",
    "Farm",
    "FarmError",
    "Hits",
    "Image",
    "ImageTexture",
    "Instances",
    "Job",
    "Lens",
    "LocalFarm",
    "Mesh",
    "Metrics",
    "MissingFile",
    "Plane",
    "PrecisionWarning",
    "Progress",
    "Rect",
    "Refused",
    "RenderError",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Summary",
    "Task",
    "Threads",
    "Tracer",
    "Transform",
    "UsageError",
    "Value",
    "Vec",
    "color",
    "compare",
    "compat",
    "hsl",
    "keys",
    "load",
    "load_dict",
    "look_at",
    "matrix",
    "program",
    "read_image",
    "render",
    "rotate",
    "scale",
    "translate",
]
