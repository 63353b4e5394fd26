"""The files of the package import each other one way: by the layers that docs/architecture.md lists."""
import ast
import pathlib
import re
import typing

import pytest
import tessera as ts
from test_docs import ROOT

PACKAGE = pathlib.Path(ts.__file__).parent
#: Imports from a higher layer, and why each is for types alone.
UPWARD = {("errors", "picture"): "an error of a render carries the picture, whose layer raises errors itself"}


class Import(typing.NamedTuple):
    importer: str
    imported: str
    runs: bool  # not for types alone


def imports_of(folder):
    """Every import of one file of the package by another, at the top, in functions and for types."""
    names = {path.stem for path in [*folder.glob("*.py"), *folder.glob("*.pyi")]}
    found = []
    for path in [*folder.glob("*.py"), *folder.glob("*.pyi")]:
        tree = ast.parse(path.read_text())
        for_types = {id(inner) for node in ast.walk(tree) if isinstance(node, ast.If)
                     and ast.unparse(node.test).strip("_") == "TYPE_CHECKING"
                     for statement in node.body for inner in ast.walk(statement)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                imported = [alias.name.partition("tessera.")[2] for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                module = re.sub(r"^tessera(\.|$)", "", node.module or "") if not node.level else node.module
                is_ours = node.level or (node.module or "").split(".")[0] == "tessera"
                imported = [] if not is_ours else [module] if module else [
                    alias.name if alias.name in names else "__init__" for alias in node.names]
            else:
                continue
            runs = id(node) not in for_types and path.suffix == ".py"
            found += [Import(path.stem, name, runs) for name in imported if name in names]
    return found


def faults_of(layers, imports):
    """What breaks the rules: a file in no layer or in two, an import from a higher layer, a circle."""
    level = {name: i for i, files in enumerate(layers) for name in files}
    faults = [f"{name} is in two layers" for name in level if sum(name in files for files in layers) > 1]
    named = {name for each in imports for name in each[:2]}
    faults += [f"{name} is in no layer" for name in sorted(named - set(level))]
    faults += [f"{a} imports {b}, of a higher layer" for a, b, runs in imports
               if level.get(b, 0) > level.get(a, 0) and (runs or (a, b) not in UPWARD)]
    after = {}
    for a, b, runs in imports:
        if runs:
            after.setdefault(a, set()).add(b)
    done, way = set(), []

    def visit(name):
        if name in way:
            faults.append(f"circle: {' imports '.join([*way[way.index(name):], name])}")
        elif name not in done:
            way.append(name)
            for following in sorted(after.get(name, ())):
                visit(following)
            way.pop()
            done.add(name)

    for name in sorted(after):
        visit(name)
    return faults


def listed_layers():
    page = (ROOT / "docs/architecture.md").read_text()
    table = page.partition("## Layers of the Python package")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (?!layer|---)[^|]+\|([^|]+)\|", table, re.MULTILINE)
    return [re.findall(r"`(\w+)`", row) for row in rows]


def test_imports_go_one_way():
    layers, imports = listed_layers(), imports_of(PACKAGE)
    assert len(imports) > 100
    assert faults_of(layers, imports) == []


def test_the_table_lists_the_files_of_the_package():
    modules = {path.name.partition(".")[0] for path in PACKAGE.iterdir() if path.suffix in (".py", ".so")}
    assert sorted(name for files in listed_layers() for name in files) == sorted(modules)


def test_each_exception_is_needed():
    assert UPWARD.keys() <= {(a, b) for a, b, runs in imports_of(PACKAGE) if not runs}


@pytest.mark.parametrize("files, fault", [
    ({"low": "import tessera.high", "high": ""}, "low imports high, of a higher layer"),
    ({"low": "from . import high", "high": ""}, "low imports high, of a higher layer"),
    ({"low": "def f():\n    from .high import g", "high": ""}, "low imports high, of a higher layer"),
    ({"low": "if TYPE_CHECKING:\n    from tessera.high import g", "high": ""},
     "low imports high, of a higher layer"),
    ({"high": "from . import other", "other": "def f():\n    from . import high"},
     "circle: high imports other imports high"),
    ({"high": "from . import stray", "stray": ""}, "stray is in no layer"),
    ({"high": "from . import low, other", "low": "import os", "other": ""}, None),
    ({"high": "from . import other", "other": "if TYPE_CHECKING:\n    from . import high"}, None),
])
def test_the_check_bites(tmp_path, files, fault):
    for name, text in files.items():
        (tmp_path / f"{name}.py").write_text(text)
    assert faults_of([["low"], ["high", "other"]], imports_of(tmp_path)) == ([fault] if fault else [])
