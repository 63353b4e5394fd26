"""The blocks of docs/python.md run, in order, as one session."""
import doctest
import pathlib
import re

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "python.md"
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks():
    """The Python of the page, block by block, with the line on which each begins."""
    text = PAGE.read_text(encoding="utf-8")
    for found in re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield text.count("\n", 0, found.start(1)), found.group(1)


def run_session(source, names, line):
    """Runs the lines that follow `>>>`, and holds what they print against what is shown."""
    example = doctest.DocTestParser().get_doctest(source, names, PAGE.name, str(PAGE), line)
    example.globs = names  # not a copy: later blocks use what this one makes
    told = []
    doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(example, out=told.append, clear_globs=False)
    assert not told, "".join(told)


def test_every_block_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "__main__"}
    count = 0
    for line, source in blocks():
        if source.startswith(">>>"):
            run_session(source, names, line)
        else:
            exec(compile("\n" * line + source, str(PAGE), "exec"), names)
        count += 1
    assert count == PAGE.read_text(encoding="utf-8").count("```python") > 20
