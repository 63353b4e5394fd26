"""The examples run, and make the pictures that they made."""
import pathlib
import subprocess
import sys

import pytest

import tessera as ts

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
# Of the linear pixels. Change it with a change of the pictures alone, and look at them.
TOOLBOX_SHA256 = "1d66474cdbdc56a36050f69a1736e8673f823d3d27fa3eeb0f5bec89e7a75ac6"


def run(name, *arguments):
    """Runs an example; returns what it prints."""
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=300).stdout


def test_toolbox(tmp_path):
    file = tmp_path / "toolbox.png"
    assert run("toolbox.py", 140, file).split() == [f"{file}:", TOOLBOX_SHA256]
    picture = ts.read_image(file)
    assert (picture.width, picture.height) == (140, 140) and picture.linear.std() > .1


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.py")), ids=lambda file: file.name)
def test_examples_are_short(file):
    lines = file.read_text().splitlines()
    assert len(lines) <= 60 and max(map(len, lines)) <= 110
