"""The keywords of render() are the options of the command line."""
import inspect
import re

import tessera as ts

# What the command line has for files and terminals, which Python has otherwise.
INSTEAD = {
    "output": "Image.save", "stats": "Image.stats", "quiet": "nothing is printed",
    "progressive": "Task.snapshot", "frames": "Scene.frames", "connect": "farm", "key": "Farm(key=)",
    "server-key": "Farm(server_key=)", "trace": "the command line", "tev": "on_tile",
    "help": "help()",
}
OUTPUT = {"exposure", "tone-map", "transfer", "gamma", "ocio-view", "ocio-display", "ocio-space",
          "ocio-input"}  # keywords of save() and to_srgb()
OF_PYTHON = {"scene", "unknown", "frame", "farm", "progress", "on_tile", "wait"}


def test_each_option_is_a_keyword(tessera):
    options = set(re.findall(r"^\s+(?:-\w,\s*)?--([a-z0-9-]+)", tessera("help", "render"), re.M))
    assert INSTEAD.keys() <= options and OUTPUT <= options
    wanted = {name.replace("-", "_") for name in options - INSTEAD.keys() - OUTPUT}
    assert set(inspect.signature(ts.render).parameters) - OF_PYTHON == wanted


def test_options_of_numbers_are_those_of_pictures():
    image = ts.Image.from_array([[.5]])
    for name in OUTPUT:
        try:
            image.to_srgb(**{name.replace("-", "_"): "?"})
        except ts.UsageError as error:
            assert "no option is called so" not in str(error)


def test_every_keyword_is_documented():
    text = inspect.getdoc(ts.render)
    assert all(f":param {name}:" in text for name in OF_PYTHON - {"scene", "unknown"})
