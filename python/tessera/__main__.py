"""`python -m tessera ...` is the command line `tessera ...`."""
import os
import sys
from typing import NoReturn

from . import program


def main() -> NoReturn:
    """Becomes the program, with the arguments of this one."""
    try:
        path = program()
    except ImportError as error:
        sys.exit(f"tessera: {error}")
    os.execv(path, ["tessera", *sys.argv[1:]])


if __name__ == "__main__":
    main()
