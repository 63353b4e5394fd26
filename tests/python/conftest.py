"""What the tests of the Python package share."""
import os
import subprocess

import pytest


@pytest.fixture
def tessera():
    """Runs the command line; returns what it prints."""
    def run(*arguments):
        command = [os.environ["TESSERA_PROGRAM"], *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return run
