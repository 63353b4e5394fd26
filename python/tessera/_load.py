"""Scenes from files and from dicts."""
from __future__ import annotations

import json
import os
import warnings
from typing import Any, Dict, Mapping, NoReturn, Optional, Sequence, Union

from . import _core
from ._options import option_texts, whole
from ._types import Path, X3dColor, X3dShadows, X3dTexture
from ._value import level_of_caller, refuse_unknown
from .errors import SceneWarning
from .rendering import checked_scene
from .scene import Scene


def load(path: Path, *, assets: Optional[Path] = None, frame: int = 0,
         place: Union[str, Sequence[str]] = (), x3d_color: Optional[X3dColor] = None,
         x3d_shadows: Optional[X3dShadows] = None, x3d_texture: Optional[X3dTexture] = None,
         x3d_weld: Optional[float] = None, x3d_strict: bool = False, x3d_two_sided: bool = False,
         **unknown: NoReturn) -> Scene:
    """Reads a scene from a file of any format that Tessera knows, by its ending.

    What was read otherwise than might be expected is told as `SceneWarning`.

    :param assets: the folder that holds all files which the scene names.
    :param frame: of an animation that has a script.
    :param place: "FILE:at=X,Y,Z:rotate=X,Y,Z:scale=S:mirror=AXES", other scenes placed into this one.
    :param x3d_color: how the numbers of X3D's colours are meant.
    :param x3d_shadows: which of X3D's lights cast shadows.
    :param x3d_texture: whether a coloured texture replaces the material's colour or multiplies it.
    :param x3d_weld: points this near share the normals that are made.
    :param x3d_strict: a picture or an Inline that is missing is an error.
    :param x3d_two_sided: shows back faces, which files that leave `solid` out hide.
    """
    options = {name: value for name, value in locals().items()
               if name not in ("path", "frame", "unknown")}
    if unknown:
        refuse_unknown("load", unknown, ["path", "frame", *options])
    name = checked_scene(os.fspath(path))
    assert isinstance(name, str)
    scene, told = _core.load(name, option_texts(options), whole("frame", frame))
    for warning in told:
        warnings.warn(warning, SceneWarning, stacklevel=level_of_caller())
    return scene


def load_dict(description: Mapping[str, Any]) -> Scene:
    """The scene of a dict in protobuf's JSON mapping, as `Scene.to_dict` makes it. Arrays may stand
    where it has references to blobs.
    """
    arrays: Dict[str, Any] = {}
    scene = _core.from_json(json.dumps(_without_arrays(description, arrays, "")), arrays)
    return scene


def _without_arrays(part: Any, arrays: Dict[str, Any], field: str) -> Any:
    """A copy in which references stand for arrays, which are put into `arrays`."""
    if isinstance(part, Mapping):
        return {key: _without_arrays(value, arrays, key) for key, value in part.items()}
    if isinstance(part, (list, tuple)):
        return [_without_arrays(value, arrays, field) for value in part]
    if field in _ARRAYS and not isinstance(part, (str, int, float)):
        array = _core.take_array(part, _ARRAYS[field])
        digest = _core.blob_digest(array)
        arrays[digest] = array
        size = memoryview(array).nbytes  # type: ignore[arg-type]
        return {"digest": digest, "size": str(size)}
    return part.item() if hasattr(part, "item") else part


_ARRAYS = {"positions": "positions", "triangles": "triangles", "normals": "normals", "uvs": "uvs",
           "colors": "colors", "faceMaterials": "face_materials", "face_materials": "face_materials",
           "texels": "texels"}
