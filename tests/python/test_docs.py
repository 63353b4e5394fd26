"""The blocks of Python in documents run, in order, as one session a page."""
import doctest
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).parents[2]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks(text):
    """The Python of a page, block by block, after the number of lines before it."""
    for found in re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield text.count("\n", 0, found.start(1)), found.group(1)


def run_session(source, names, page, line):
    """Runs the lines that follow `>>>`, and holds what they print against what is shown."""
    example = doctest.DocTestParser().get_doctest(source, {}, page.name, str(page), line)
    example.globs = names  # itself, no copy: later blocks use what this one makes
    told = []
    doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(example, out=told.append, clear_globs=False)
    assert not told, "".join(told)


@pytest.mark.parametrize("page, least", [("README.md", 1), ("docs/python.md", 25)])
def test_every_block_runs(page, least, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / page).read_text(encoding="utf-8")
    names = {"__name__": "__main__"}
    count = 0
    for line, source in blocks(text):
        if source.startswith(">>>"):
            run_session(source, names, ROOT / page, line)
        else:
            exec(compile("\n" * line + source, str(ROOT / page), "exec"), names)
        count += 1
    assert count == text.count("```python") >= least
