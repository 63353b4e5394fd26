"""What the tests of the Python package share."""
import os
import subprocess

import pytest

# A sanitizer's runtime is for this process; the programs that it starts have their own.
os.environ.pop("LD_PRELOAD", None)


@pytest.fixture
def tessera():
    """Runs the command line; returns what it prints."""
    def run(*arguments, check=True):
        command = [os.environ["TESSERA_PROGRAM"], *map(str, arguments)]
        return subprocess.run(command, check=check, capture_output=True, text=True).stdout
    return run
