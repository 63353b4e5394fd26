"""What has to be true before `tessera._core` is loaded."""
from __future__ import annotations

import importlib.machinery
import os
import sys


def check() -> None:
    """Raises ImportError where this process or interpreter cannot load the extension module.

    libprotobuf ends a process that registers the messages of Tessera twice, which a second copy of
    the module would do.
    """
    ours = os.path.realpath(os.path.dirname(__file__))
    for loaded in _loaded_cores():
        if os.path.dirname(loaded) != ours or loaded.endswith(" (deleted)"):
            raise ImportError(f"{ours}: this process has loaded {loaded}; expected one copy of tessera")
    try:
        from . import _core
    except ImportError:
        built = [name.split(".")[1] for name in os.listdir(ours)
                 if name.startswith("_core.") and name.endswith(".so")]
        here = importlib.machinery.EXTENSION_SUFFIXES[0].split(".")[1]
        if built and here not in built:
            raise ImportError(f"tessera is built for {built[0]}, and this is {here}: {sys.executable}; "
                              "expected the Python that it is built for, on Debian /usr/bin/python3") from None
        raise
    # A sub-interpreter gets the module that the main one has loaded without a question.
    if not _core.is_main_interpreter():
        raise ImportError("a sub-interpreter imports tessera; expected the main one")


def _loaded_cores() -> list[str]:
    """The files of every `tessera._core` in this process; Linux marks a removed one "(deleted)"."""
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as maps:
            mapped = {line[line.index("/"):].rstrip("\n") for line in maps if "/tessera/_core." in line}
    except OSError:
        return []
    return [path for path in mapped if os.path.dirname(path).endswith("/tessera")]
