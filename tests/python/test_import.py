"""What happens at `import tessera`: which program goes with it, and where it is refused."""
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import tessera as ts
from tessera import _core, _program

PROGRAM = pathlib.Path(os.environ["TESSERA_PROGRAM"]).resolve()
PACKAGE = pathlib.Path(ts.__file__).parent
ROOT = pathlib.Path(__file__).resolve().parents[2]


def script(file, text):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("#!/bin/sh\n" + text)
    file.chmod(0o755)
    return file


def copy_package(parent):
    """The package in a folder of its own, without any program."""
    return pathlib.Path(shutil.copytree(PACKAGE, parent / "tessera",
                                        ignore=shutil.ignore_patterns("_bin", "__pycache__")))


def run(code, *, package=PACKAGE, check=True, **environment):
    """Runs a script with that copy of the package, and without what the caller has set."""
    kept = {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(package.parent), **environment}
    return subprocess.run([sys.executable, "-B", "-c", code], env=kept, capture_output=True, text=True,
                          check=check)


SHOW = "import tessera; print(tessera.program())"


# ---- the search order

@pytest.fixture
def places(tmp_path):
    """Four folders, each with a program, in the order in which they are looked at."""
    return [script(tmp_path / name / "tessera", "").parent for name in ("chosen", "beside", "installed", "path")]


def find(places, chosen=None):
    return pathlib.Path(_program.find(chosen, str(places[1]), str(places[2]), f"::/none:{places[3]}"))


def test_the_variable_names_the_program_or_its_folder(places):
    assert find(places, str(places[0])) == places[0] / "tessera"
    renamed = script(places[0] / "tessera-old", "")
    assert find(places, str(renamed)) == renamed


def test_what_the_variable_names_is_not_replaced_by_another(places):
    assert find(places, "/none/tessera") == pathlib.Path("/none/tessera")


def test_an_empty_variable_is_not_one_that_is_not_set(places):
    with pytest.raises(ImportError, match="^TESSERA_PROGRAM: ''; expected"):
        find(places, "")


def test_each_place_is_looked_at_after_the_one_before_it(places):
    for place in places[1:]:
        assert find(places) == place / "tessera"
        (place / "tessera").unlink()
    assert find(places) == places[2] / "tessera"  # where it should be installed


def test_what_cannot_be_run_is_passed_over(places):
    (places[1] / "tessera").chmod(0o644)
    (places[2] / "tessera").unlink()
    (places[2] / "tessera").mkdir()
    assert find(places) == places[3] / "tessera"


def test_an_empty_entry_of_the_search_path_is_not_the_current_folder(places, monkeypatch):
    for place in places[1:]:
        (place / "tessera").unlink()
    monkeypatch.chdir(places[0])
    assert find(places) == places[2] / "tessera"


# ---- the same by real imports

def test_the_build_tree_uses_its_own_program():
    assert run(SHOW).stdout.strip() == str(PROGRAM)


def test_a_copy_uses_its_own_bin_and_then_the_search_path(tmp_path):
    package = copy_package(tmp_path)
    if not os.path.exists(_core.installed_folder):
        assert run(SHOW, package=package, PATH=str(PROGRAM.parent)).stdout.strip() == str(PROGRAM)
    (package / "_bin").symlink_to(PROGRAM.parent)
    assert run(SHOW, package=package, PATH="/none").stdout.strip() == str(PROGRAM)


def test_a_link_leads_to_the_folder_of_the_program(tmp_path):
    (tmp_path / "link").symlink_to(PROGRAM)
    assert run(SHOW, TESSERA_PROGRAM=str(tmp_path / "link")).stdout.strip() == str(PROGRAM)


# ---- the version

def refusal(program):
    """What program() says of it; the import itself has to work."""
    told = run("import tessera\ntry: tessera.program()\nexcept ImportError as e: print(e)",
               TESSERA_PROGRAM=str(program))
    return told.stdout


def test_another_version_is_refused_and_both_are_named(tmp_path):
    other = script(tmp_path / "tessera", "echo tessera 0.0.9 GNU-12.2.0")
    told = refusal(other)
    assert "tessera 0.0.9 GNU-12.2.0" in told and _core.build in told
    assert str(other) in told and _core.__file__ in told


def test_another_compiler_makes_another_version(tmp_path):
    assert "other-compiler" in refusal(script(tmp_path / "tessera", f"echo tessera {ts.__version__} other-compiler"))


def test_what_is_no_program_is_named(tmp_path):
    for program in (tmp_path / "none", tmp_path, "/dev/null"):
        told = refusal(program)
        assert str(program) in told and "TESSERA_PROGRAM" in told, told


def test_a_program_that_does_not_answer_is_refused(tmp_path):
    told = run(f"""
import signal, tessera
signal.alarm(20)  # which ends the process
try: tessera.program()
except ImportError as error: print(error)
""", TESSERA_PROGRAM=str(script(tmp_path / "tessera", "exec sleep 100"))).stdout
    assert "no answer to --version" in told and str(tmp_path) in told


def test_the_import_starts_no_process_and_the_check_is_made_once(tmp_path):
    counted = script(tmp_path / "tessera", f'echo run >> {tmp_path}/runs\nexec {PROGRAM} "$@"')
    count = tmp_path / "runs"
    run("import tessera", TESSERA_PROGRAM=str(counted))
    assert not count.exists()
    run("import tessera; tessera.program(); tessera.program()", TESSERA_PROGRAM=str(counted))
    assert count.read_text() == "run\n"


def test_the_import_brings_neither_numpy_nor_subprocess():
    told = run("import sys, tessera; print([m for m in ('numpy', 'subprocess', 'socket') if m in sys.modules])")
    assert told.stdout.strip() == "[]"


RENDER = f"""
import tessera as ts
scene = {str(ROOT / "scenes/samples/knot.tessera")!r}
def render(farm): return ts.render(scene, size=(16, 9), spp=1, farm=farm)
"""


def test_a_farm_of_another_version_is_refused_and_threads_go_on(tmp_path):
    other = script(tmp_path / "tessera", f"echo run >> {tmp_path}/runs; echo tessera 0.0.9")
    told = run(RENDER + """
with ts.Threads(1) as farm: print(render(farm).linear.shape)
for make in (lambda: ts.LocalFarm(1), lambda: render(None)):
    try: make()
    except ImportError as error: print('refused', error)
""", TESSERA_PROGRAM=str(other)).stdout
    assert told.startswith("(9, 16, 3)") and told.count("refused") == 2 and "0.0.9" in told
    assert (tmp_path / "runs").read_text() == "run\nrun\n"  # --version alone, and no worker


def test_workers_codec_and_modules_are_those_of_the_program(tmp_path):
    package = copy_package(tmp_path)
    (package / "_bin").symlink_to(PROGRAM.parent)
    told = run(RENDER + f"""
with ts.LocalFarm(1) as farm: image = render(farm)
image.save({str(tmp_path / "knot.png")!r})
print(image.linear.shape)
""", package=package)
    assert told.stdout.strip() == "(9, 16, 3)" and (tmp_path / "knot.png").stat().st_size > 0


# ---- one copy in a process, and the main interpreter alone

def import_twice(first, second):
    return run(f"""
import sys
sys.path.insert(0, {str(first.parent)!r})
import tessera
for name in [n for n in sys.modules if n.split('.')[0] == 'tessera']: del sys.modules[name]
sys.path.insert(0, {str(second.parent)!r})
try:
    import tessera
    print('imported', tessera.__file__)
except ImportError as error:
    print('refused', error)
""", check=False)


def test_a_second_copy_is_refused_before_it_is_loaded(tmp_path):
    copy = copy_package(tmp_path)
    told = import_twice(PACKAGE, copy)
    assert told.returncode == 0, told.stderr
    assert told.stdout.startswith("refused") and str(copy) in told.stdout
    assert _core.__file__ in told.stdout


def test_the_same_copy_is_imported_again_but_not_by_another_path(tmp_path):
    (tmp_path / "tessera").symlink_to(PACKAGE)
    for again, expected in ((PACKAGE, "imported"), (tmp_path / "tessera", "refused")):
        told = import_twice(PACKAGE, again)
        assert told.returncode == 0 and told.stdout.startswith(expected), told


def test_a_module_that_was_replaced_under_a_running_python_is_refused(tmp_path):
    package = copy_package(tmp_path)
    core = next(package.glob("_core.*.so"))
    told = run(f"""
import os, shutil, sys, tessera
for name in [n for n in sys.modules if n.split('.')[0] == 'tessera']: del sys.modules[name]
shutil.copy({str(core)!r}, {str(core) + '.new'!r})
os.rename({str(core) + '.new'!r}, {str(core)!r})
try: import tessera
except ImportError as error: print(error)
""", package=package, check=False)
    assert told.returncode == 0 and "(deleted)" in told.stdout, told


@pytest.mark.parametrize("before", ["", "import tessera"])
def test_a_sub_interpreter_is_refused_and_the_main_one_goes_on(before):
    told = run(f"""
import _xxsubinterpreters as interpreters
{before}
other = interpreters.create()
try: interpreters.run_string(other, 'import tessera')
except interpreters.RunFailedError as error: print(error)
interpreters.destroy(other)
import tessera
print(tessera.Array, tessera.program())
""", check=False)
    assert told.returncode == 0, told.stderr
    assert "ImportError" in told.stdout and "sub-interpreter" in told.stdout
    assert told.stdout.strip().endswith(str(PROGRAM))


def test_another_python_than_it_is_built_for_is_told(tmp_path):
    package = copy_package(tmp_path)
    core, = package.glob("_core.*.so")
    core.rename(package / "_core.cpython-37m-x86_64-linux-gnu.so")
    told = run("import tessera", package=package, check=False).stderr.splitlines()[-1]
    assert "tessera is built for cpython-37m-x86_64-linux-gnu, and this is cpython-3" in told


# ---- python -m tessera

def command_line(*arguments, **environment):
    return subprocess.run([sys.executable, "-B", "-m", "tessera", *arguments], capture_output=True, text=True,
                          env={"PYTHONPATH": str(PACKAGE.parent), **environment})


def test_the_module_run_as_a_script_is_the_command_line(tmp_path):
    told = command_line("--version")
    assert (told.returncode, told.stdout.strip()) == (0, f"tessera {_core.build}")
    odd = command_line("info", "no such 'file'.tessera")
    same = subprocess.run([PROGRAM, "info", "no such 'file'.tessera"], capture_output=True, text=True)
    assert (odd.returncode, odd.stderr) == (same.returncode, same.stderr) and odd.returncode != 0


def test_the_command_line_without_a_program_says_so_in_one_line():
    told = command_line("--version", TESSERA_PROGRAM="/none/tessera")
    assert told.returncode == 1 and told.stderr.startswith("tessera: /none/tessera: ")
    assert told.stderr.count("\n") == 1


# ---- numpy

@pytest.mark.parametrize("call", [
    "ts.Image.from_array([[1.0]])", "ts.Scene().tracer().intersect((0, 0, 1), (0, 0, -1))",
    "ts.translate(1, 2, 3) @ [(0, 0, 0)]", "ts.Camera().pose", "ts.Scene().tracer().camera_rays((2, 2))"])
def test_a_call_that_needs_numpy_names_its_package(call):
    told = run(f"""
import sys
sys.modules["numpy"] = None
import tessera as ts
try:
    {call}
except ImportError as error:
    print(error)
""")
    assert told.stdout == ("numpy: not installed; expected Debian's package python3-numpy, as this call takes "
                           "or gives arrays\n"), told.stderr


def test_nothing_of_the_module_is_seen_by_others():
    told = subprocess.run(["nm", "-D", "--defined-only", _core.__file__], capture_output=True, text=True,
                          check=True)
    names = [line.split()[-1] for line in told.stdout.splitlines()]
    assert names == ["PyInit__core"]
