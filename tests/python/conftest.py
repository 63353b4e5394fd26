"""What the tests of the Python package share."""
import os
import subprocess
import sys

import pytest

# A sanitizer's runtime is for interpreters; the programs that they start have their own.
SANITIZER = os.environ.pop("LD_PRELOAD", None)


@pytest.fixture
def tessera():
    """Runs the command line; returns what it prints."""
    def run(*arguments, check=True):
        command = [os.environ["TESSERA_PROGRAM"], *map(str, arguments)]
        return subprocess.run(command, check=check, capture_output=True, text=True).stdout
    return run


@pytest.fixture
def script():
    """Runs a text in an interpreter of its own; returns what it prints."""
    preload = {"LD_PRELOAD": SANITIZER} if SANITIZER else {}

    def run(code):
        done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True,
                              timeout=300, env={**os.environ, **preload})
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()
    return run
