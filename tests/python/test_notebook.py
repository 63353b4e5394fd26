"""examples/quickstart.ipynb, executed as Jupyter does it."""
import base64
import json
import os
import pathlib
import subprocess
import sys

import pytest

import tessera as ts
from test_pictures import decoded_png

NOTEBOOK = pathlib.Path(__file__).parents[2] / "examples" / "quickstart.ipynb"


def executed(notebook, folder):
    """The outputs of each code cell."""
    command = ["-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", folder, "--output", "done",
               "--ExecutePreprocessor.timeout=300", notebook]
    subprocess.run([sys.executable, *map(str, command)], cwd=folder, check=True, capture_output=True,
                   env={**os.environ, "HOME": str(folder), "JUPYTER_PREFER_ENV_PATH": "1"})
    done = json.loads((folder / "done.ipynb").read_text(encoding="utf-8"))
    return [cell["outputs"] for cell in done["cells"] if cell["cell_type"] == "code"]


@pytest.fixture(scope="module")
def cells(tmp_path_factory):
    return executed(NOTEBOOK, tmp_path_factory.mktemp("notebook"))


def tables(outputs):
    return [output["data"]["text/html"] for output in outputs if "text/html" in output.get("data", {})]


def pictures(outputs):
    found = [output["data"]["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    return [decoded_png(base64.b64decode(text)) for text in found]


def code_of(number):
    read = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    return "".join([cell["source"] for cell in read["cells"] if cell["cell_type"] == "code"][number])


def test_an_image_is_shown_by_the_bytes_of_its_png(cells):
    names = {}
    exec(code_of(0), names)
    shown, = pictures(cells[0])
    assert (shown == names["image"].to_srgb()).all()


def test_a_task_updates_one_output(cells):
    shown = pictures(cells[1])
    assert len(shown) == 1 and shown[0].any()


def test_a_task_on_the_last_line_is_shown_once(tmp_path):
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    cell = next(cell for cell in notebook["cells"] if cell["cell_type"] == "code")
    cell["source"] = ["import tessera as ts\n", "scene = ts.Scene(width=64, height=36, background='red')\n",
                      "scene.render(wait=False).show()"]
    notebook["cells"] = [cell]
    (tmp_path / "last.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    outputs, = executed(tmp_path / "last.ipynb", tmp_path)
    assert len(pictures(outputs)) == 1


def test_arrays_are_shown_as_pictures(cells):
    for outputs in cells[2:4]:
        shown, = pictures(outputs)
        assert shown.shape == (180, 320, 3) and shown.any()


def test_a_scene_is_shown_as_a_table_of_what_it_holds(cells):
    shown, = tables(cells[4])
    assert "<tr><th>shapes, sphere</th><td>1</td></tr>" in "".join(shown)


def test_names_in_tables_are_text():
    scene = ts.Scene(materials=[ts.Classic(name="<b>")])
    assert "<td>material &#x27;&lt;b&gt;&#x27;</td>" in scene._repr_html_()


def test_a_table_of_hits():
    tracer = ts.Scene(nodes=[ts.Sphere()]).tracer()
    hits = tracer.intersect([(0, 0, 5), (0, 5, 5)], (0, 0, -1))
    assert hits._repr_html_() == ("<table><tr><th>rays</th><td>2</td></tr><tr><th>hit</th><td>1</td></tr>"
                                  "<tr><th>nearest</th><td>4.0</td></tr><tr><th>farthest</th><td>4.0</td></tr></table>")
    assert "nearest" not in tracer.intersect((0, 5, 5), (0, 0, -1))._repr_html_()
