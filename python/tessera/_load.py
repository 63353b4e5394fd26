"""Scenes from files and from dicts."""
from __future__ import annotations

import json
import os
import warnings
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

from . import _core
from ._types import Path, X3dColor, X3dShadows, X3dTexture
from .errors import SceneWarning
from .rendering import checked_scene
from .scene import Scene


def load(path: Path, *, assets: Optional[Path] = None, frame: int = 0,
         place: Union[str, Sequence[str]] = (), strict: bool = False,
         x3d_color: X3dColor = "display", x3d_shadows: X3dShadows = "on",
         x3d_texture: X3dTexture = "version",
         x3d_weld: Optional[float] = None, x3d_two_sided: bool = False) -> Scene:
    """Reads a scene from a file of any format that Tessera knows, by its ending.

    What was read otherwise than might be expected is told as `SceneWarning`.

    :param assets: the folder that holds all files which the scene names.
    :param frame: of an animation that has a script.
    :param place: "FILE:at=X,Y,Z:rotate=X,Y,Z:scale=S:mirror=AXES", other scenes placed into this one.
    :param strict: a picture or an Inline of X3D that is missing is an error.
    :param x3d_color: how the numbers of X3D's colours are meant.
    :param x3d_shadows: which of X3D's lights cast shadows.
    :param x3d_texture: whether a coloured texture replaces the material's colour or multiplies it.
    :param x3d_weld: points this near share the normals that are made.
    :param x3d_two_sided: shows back faces, which files that leave `solid` out hide.
    """
    name = os.fspath(path)
    checked_scene(name)
    places = [place] if isinstance(place, str) else list(place)
    given: List[Tuple[str, Any]] = [("place", text) for text in places]
    given += [("assets", assets if assets is None else os.fspath(assets)), ("x3d-color", x3d_color),
              ("x3d-shadows", x3d_shadows), ("x3d-texture", x3d_texture), ("x3d-weld", x3d_weld)]
    texts = [(option, str(value)) for option, value in given if value is not None]
    texts += [(option, "") for option, is_set in (("x3d-strict", strict),
                                                  ("x3d-two-sided", x3d_two_sided)) if is_set]
    scene, told = _core.load(name, texts, frame)
    for warning in told:
        warnings.warn(warning, SceneWarning, stacklevel=2)
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
