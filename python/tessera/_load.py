"""Scenes from files and from dicts."""
from __future__ import annotations

import io
import json
import math
import os
import re
import warnings
from typing import Any, Callable, Dict, Mapping, NoReturn, Optional, Sequence, Union

from . import _core
from ._arguments import frame_number, refuse_unknown, with_article
from ._callers import level_of_caller
from ._options import option_texts
from ._places import located_errors
from ._types import Path, Up, X3dColor, X3dShadows, X3dTexture
from .errors import (Error, SceneError, SceneWarning, UsageError, in_python, nesting_ends,
                     scene_error)
from .rendering import checked_scene
from .scene import Scene

def load(path: Path, *, assets: Optional[Path] = None, environment: Optional[Path] = None, frame: int = 0,
         place: Union[str, Sequence[str]] = (), strict: bool = False, two_sided: bool = False, up: Optional[Up] = None,
         x3d_color: Optional[X3dColor] = None, x3d_shadows: Optional[X3dShadows] = None,
         x3d_texture: Optional[X3dTexture] = None, x3d_weld: Optional[float] = None,
         x3d_strict: bool = False, x3d_two_sided: bool = False, **unknown: NoReturn) -> Scene:
    """Reads a scene from a file of any format that Tessera knows, by its ending.

    What was read otherwise than might be expected is told as `SceneWarning`.

    :param assets: the folder that holds all files which the scene names.
    :param environment: a panorama in place of the background; it alone lights a model that brings no lights.
    :param frame: of an animation that has a script.
    :param place: "FILE:at=X,Y,Z:rotate=X,Y,Z:scale=S:mirror=AXES", other scenes placed into this one.
    :param strict: what is wrong in a file, and would be mended or done without, with a warning, is an error.
    :param two_sided: shows back faces, which glTF's one-sided materials and X3D's `solid` hide.
    :param up: which axis points up in a model that comes without a view; coordinates stay as they are.
    :param x3d_color: how the numbers of X3D's colours are meant: "display" codes or "linear" light.
    :param x3d_shadows: which of X3D's lights cast shadows: all ("on"), as the "file" says, or none ("off").
    :param x3d_texture: whether a coloured texture replaces the material's colour ("replace") or multiplies
        it ("modulate"), or what the file's "version" of X3D has it do.
    :param x3d_weld: points this near share the normals that are made; in the file's unit, > 0.
    :param x3d_strict: a picture or an Inline of X3D that is missing is an error.
    :param x3d_two_sided: the same as `two_sided`.

    Raises MissingFile for files that are not there, SceneError for what is wrong in them, and UsageError for
    other words and numbers.
    """
    options = {name: value for name, value in locals().items()
               if name not in ("path", "frame", "unknown")}
    if unknown:
        refuse_unknown("load", unknown, ["path", "frame", *options])
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"path: {path!r:.100}; expected the path of a file")
    name = checked_scene(os.fspath(path), "path")
    assert isinstance(name, str)
    with located_errors(name):
        scene: Scene
        scene, told = _core.load(name, option_texts(options), frame_number("frame", frame))
    for warning in told:
        warnings.warn(in_python(warning), SceneWarning, stacklevel=level_of_caller())
    return scene


def load_dict(description: Mapping[str, Any]) -> Scene:
    """The scene of a dict in protobuf's JSON mapping, as `Scene.to_dict` makes it. Arrays may stand
    where it has references to blobs. Raises SceneError for what is no scene, TypeError for what is no
    dict.
    """
    if not isinstance(description, Mapping):
        raise TypeError(f"description: {description!r:.100}; expected a dict")
    arrays: Dict[str, Any] = {}
    text = io.StringIO()
    with nesting_ends(description, "description"):
        try:
            _write(description, text.write, arrays)
        except ValueError as error:
            if isinstance(error, Error):
                raise
            # Python prints no number of more than some thousand digits.
            raise UsageError("description: a whole number of too many digits; expected a smaller one") from error
    try:
        scene: Scene = _core.from_json(text.getvalue(), arrays)
    except SceneError as error:
        error.path, error.place = error.place, ""  # of what is no file
        raise
    return scene


_printed = json.JSONEncoder().encode


def _write(part: Any, write: Callable[[str], object], arrays: Dict[str, Any], field: str = "", path: str = "") -> None:
    """Writes the JSON of a part, in which references stand for arrays, which are put into `arrays`. Of `json` it uses
    only what prints a name or a number: that keeps the interpreter's lock while it joins a hundred thousand of them.
    """
    between = ""
    if isinstance(part, Mapping):
        write("{")
        for key, value in part.items():
            if not isinstance(key, str):
                raise _wrong(path, f"the key {key!r:.100}", "text")
            write(f"{between}{_printed(key)}:")
            _write(value, write, arrays, key, f"{path}.{key}" if path else key)
            between = ","
        write("}")
    elif isinstance(part, (list, tuple)):
        write("[")
        for i, value in enumerate(part):
            write(between)
            _write(value, write, arrays, field, f"{path}[{i}]")
            between = ","
        write("]")
    elif isinstance(part, (str, int, float)):
        if isinstance(part, float) and not math.isfinite(part):
            raise _wrong(path, repr(part), "a finite number")
        write(_printed(part))
    # JSON has both "faceMaterials" and "face_materials".
    elif (name := re.sub("([A-Z])", r"_\1", field).lower()) in _core.array_fields:
        array = _core.take_array(part, name)
        digest = _core.blob_digest(array)
        arrays[digest] = array
        size = memoryview(array).nbytes  # type: ignore[arg-type]
        write(_printed({"digest": digest, "size": str(size)}))
    elif hasattr(part, "tolist"):  # numbers of numpy
        _write(part.tolist(), write, arrays, field, path)
    elif part is None:
        write("null")
    else:
        raise _wrong(path, with_article(part), "a number, text, a list or a dict")


def _wrong(path: str, found: str, expected: str) -> SceneError:
    return scene_error(found, expected, path or "description", None)
