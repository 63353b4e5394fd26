"""Arrays between Python and Tessera."""
import subprocess
import sys

import tessera as ts


def test_import_brings_neither_numpy_nor_sockets():
    code = "import sys, tessera; print([m for m in ('numpy', 'socket') if m in sys.modules])"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"


def test_the_errors_are_what_python_has_for_them():
    assert issubclass(ts.SceneError, ValueError) and issubclass(ts.SceneError, ts.Error)
    assert issubclass(ts.MissingFile, FileNotFoundError)
    assert issubclass(ts.Refused, PermissionError)
