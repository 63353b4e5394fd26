"""`python -m tessera ...` is the command line `tessera ...`."""
import os
import sys

from . import program

if __name__ == "__main__":
    try:
        _path = program()
    except ImportError as _error:
        sys.exit(f"tessera: {_error}")
    os.execv(_path, ["tessera", *sys.argv[1:]])
