"""Tessera, a ray-tracing renderer: scenes as values, pictures and ray queries as arrays.

The guide is docs/python.md of the sources. Start from `Scene`, `render`, `load` and `Tracer`.
"""
from typing import TYPE_CHECKING as _TYPE_CHECKING, NoReturn as _NoReturn

from . import _loading

_loading.check()  # Before anything else loads the extension module.
from . import compat
from ._messages import (Attenuation, AxisAngle, BackgroundCube, BackgroundGradient,
                        BackgroundPanorama, BackgroundRings, BackgroundSunAndSky, BeamLight,
                        CheckerTexture, ColorInput, Conductor, Dielectric, DirectionalLight, FloatInput,
                        Fog, Frames, GradientTexture, Include, IntegratorSettings, Light, LookAt,
                        Material, Matrix, Metadata, NoiseTexture, Object, Orthographic, Output,
                        Panoramic, Perspective, Physical, PointLight, Sampling, Settings, SpotLight,
                        Texture, TransformKey, TransformStep, Unlit)
from ._arguments import refuse_attribute as _refuse_attribute
from ._colors import Color, color, hsl
from ._core import Array, Vec, solve_quadratic, version as __version__
from ._graph import Instances
from ._load import load, load_dict
from ._mesh import Mesh
from ._nodes import Node
from ._placing import Csg, Shape
from ._program import program
from ._shapes import (Box, Cone, Cylinder, Disc, HalfPlane, Plane, Polygon, Rectangle, Sphere, Torus,
                      Triangle)
from ._textures import ImageTexture
from ._toolbox import LIGHT_1, LIGHT_2, Classic, reflect
from ._transforms import Transform, keys, look_at, matrix, rotate, scale, translate
from ._value import Value
from ._view import Background, Camera, Lens
from .errors import (Cancelled, Error, FarmError, MissingFile, PrecisionWarning, Refused, RenderError,
                     SceneError, SceneWarning, UsageError)
from .farm import Farm, Job
from .picture import Image, Metrics, Rect, compare, read_image
from .rays import AllHits, Hits, Tracer
from ._local_farms import LocalFarm, Threads
from ._progress import Progress
from .rendering import Task, render
from .scene import Scene, Summary

__all__ = [
    "AllHits",
    "Array",
    "Attenuation",
    "AxisAngle",
    "Background",
    "BackgroundCube",
    "BackgroundGradient",
    "BackgroundPanorama",
    "BackgroundRings",
    "BackgroundSunAndSky",
    "BeamLight",
    "Box",
    "Camera",
    "Cancelled",
    "CheckerTexture",
    "Classic",
    "Color",
    "ColorInput",
    "Conductor",
    "Cone",
    "Csg",
    "Cylinder",
    "Dielectric",
    "DirectionalLight",
    "Disc",
    "Error",
    "Farm",
    "FarmError",
    "FloatInput",
    "Fog",
    "Frames",
    "GradientTexture",
    "HalfPlane",
    "Hits",
    "Image",
    "ImageTexture",
    "Include",
    "Instances",
    "IntegratorSettings",
    "Job",
    "LIGHT_1",
    "LIGHT_2",
    "Lens",
    "Light",
    "LocalFarm",
    "LookAt",
    "Material",
    "Matrix",
    "Mesh",
    "Metadata",
    "Metrics",
    "MissingFile",
    "Node",
    "NoiseTexture",
    "Object",
    "Orthographic",
    "Output",
    "Panoramic",
    "Perspective",
    "Physical",
    "Plane",
    "PointLight",
    "Polygon",
    "PrecisionWarning",
    "Progress",
    "Rect",
    "Rectangle",
    "Refused",
    "RenderError",
    "Sampling",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Settings",
    "Shape",
    "Sphere",
    "SpotLight",
    "Summary",
    "Task",
    "Texture",
    "Threads",
    "Torus",
    "Tracer",
    "Transform",
    "TransformKey",
    "TransformStep",
    "Triangle",
    "Unlit",
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
    "reflect",
    "render",
    "rotate",
    "scale",
    "solve_quadratic",
    "translate",
]

if not _TYPE_CHECKING:  # for mypy a module that has this has every name
    def __getattr__(name: str) -> _NoReturn:
        """Raises AttributeError that tells the nearest public name."""
        _refuse_attribute(__name__, name, __all__)
