"""The program `tessera`, whose processes render for the module."""
from __future__ import annotations

import os
from typing import Optional

from . import _core

_NAME = "tessera"
_PATIENCE = 5  # seconds for an answer that takes some milliseconds
_is_checked = False


def find(chosen: Optional[str], beside: str, installed: str, search_path: str) -> str:
    """The program that is used: `chosen`, a program or its folder, or else the first one there is.

    The other folders are looked at in this order; those of `search_path` stand between colons. Where
    there is none, it is the path of what should be installed.
    """
    if chosen == "":  # as a script's unset variable leaves it; another program may not be meant
        raise ImportError(f"TESSERA_PROGRAM: ''; expected the program {_NAME}, or its folder")
    if chosen:
        return os.path.join(chosen, _NAME) if os.path.isdir(chosen) else chosen
    for folder in (beside, installed, *search_path.split(os.pathsep)):
        program = os.path.join(folder, _NAME)
        if folder and os.path.isfile(program) and os.access(program, os.X_OK):
            return program
    return os.path.join(installed, _NAME)


def check(program: str) -> None:
    """Raises ImportError where it is not the program of this very build."""
    import subprocess  # It takes longer to import than all else here.
    try:
        done = subprocess.run([program, "--version"], stdin=subprocess.DEVNULL, capture_output=True,
                              encoding="utf-8", errors="replace", timeout=_PATIENCE)
    except (OSError, subprocess.TimeoutExpired) as error:
        cause = getattr(error, "strerror", None) or f"no answer to --version in {_PATIENCE} s"
        raise ImportError(f"{program}: {cause}; expected the program {_NAME}. {_WHERE}") from None
    found, expected = done.stdout.strip()[:200], f"{_NAME} {_core.build}"
    if found != expected:
        raise ImportError(f"{program}: its version is '{found}'; expected '{expected}', "
                          f"that of {_core.__file__}")


def program() -> str:
    """The path of the program `tessera`, whose processes render for this module.

    It is found when the module is imported: what the environment variable TESSERA_PROGRAM names (a
    program or its folder), else the folder `_bin` of the package, lib/tessera where the package is below
    the same lib, else the folder that was configured when the module was built, and the folders of PATH. The first call here, which is that of the first
    render at the latest, runs it to compare its version with the module's. ImportError tells both
    versions where they differ, or that there is no such program. The import does not check that,
    since starting a process would take longer than all the rest of it.
    """
    global _is_checked
    if not _is_checked:
        check(_program)
        _is_checked = True
    return _program


def _installed_folder(package: str) -> str:
    """Of the program that was installed with the package, as Debian lays them out."""
    folder = os.path.normpath(os.path.join(package, "../../../tessera"))
    return folder if os.path.isfile(os.path.join(folder, _NAME)) else _core.installed_folder


_package = os.path.dirname(_core.__file__)
_installed = _installed_folder(_package)
_WHERE = ("It is looked for as TESSERA_PROGRAM, in the package's folder _bin, in "
          f"{_installed} and on PATH.")
_program = os.path.realpath(find(os.environ.get("TESSERA_PROGRAM"), os.path.join(_package, "_bin"),
                                 _installed, os.environ.get("PATH", "")))
_core.set_program(os.fsencode(_program))
