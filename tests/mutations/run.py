#!/usr/bin/env python3
"""Plants one known bug after another in a copy of the source and makes sure that a test fails.

  tests/mutations/run.py                 all of them: some ten minutes on four cores
  tests/mutations/run.py --only torus    those with "torus" in their names
  tests/mutations/run.py --list          what there is
  tests/mutations/run.py --check         whether each finds its place in the source

The copy and its build stay in build/mutations, for the next run. The exit code is 1 where a bug
was not caught, or its place is not in the source any more. Nothing of this is ever in the program itself.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

from mutations import MUTATIONS, PYTHON

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOME = ROOT / "build" / "mutations"
TREE, BUILD = HOME / "tree", HOME / "build"


def tracked_files():
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others",
                             "--exclude-standard"], cwd=ROOT, check=True, capture_output=True)
    return [name for name in listed.stdout.decode().split("\0")
            if name and (ROOT / name).is_file()]


def refresh_tree():
    """Copies what has changed, so that what has not is not compiled again."""
    names = tracked_files()
    for name in names:
        source, copy = ROOT / name, TREE / name
        if copy.exists() and copy.read_bytes() == source.read_bytes():
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, copy)
        shutil.copymode(source, copy)
    known = set(names)
    for copy in [path for path in TREE.rglob("*") if path.is_file()]:
        if str(copy.relative_to(TREE)) not in known:
            copy.unlink()


def run(command, log, **options):
    with open(log, "a") as out:
        return subprocess.run(command, stdout=out, stderr=subprocess.STDOUT, check=False,
                              **options).returncode


def build(targets, jobs, log):
    if not (BUILD / "build.ninja").exists():
        configure = ["cmake", "-G", "Ninja", "-S", str(TREE), "-B", str(BUILD),
                     "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O1", "-DTESSERA_TESTS=ON"]
        if run(configure, log) != 0:
            sys.exit(f"cmake failed: see {log}")
    if PYTHON in targets:
        targets = [*(target for target in targets if target != PYTHON), "tessera", "tessera_python"]
    return run(["cmake", "--build", str(BUILD), "-j", str(jobs), "--target", *targets], log)


def command_of(mutation):
    """What runs its tests: the command, and what its environment and folder are."""
    if mutation.program == PYTHON:
        return (["/usr/bin/python3", "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider",
                 *mutation.tests.split()],
                {"cwd": TREE / "tests" / "python",
                 "env": {**os.environ, "TESSERA_PROGRAM": str(BUILD / "bin" / "tessera"),
                         "PYTHONPATH": str(BUILD / "python")}})
    return [str(BUILD / "bin" / mutation.program), f"--gtest_filter={mutation.tests}",
            "--gtest_fail_fast", "--gtest_brief=1"], {}


def tests_fail(mutation, log):
    command, options = command_of(mutation)
    try:
        result = subprocess.run(command, capture_output=True, text=True, errors="replace",
                                check=False, timeout=300, **options)
    except subprocess.TimeoutExpired:
        return "does not end"  # which ctest, too, takes as a failure
    with open(log, "a") as out:
        out.write(result.stdout[-4000:])
    if result.returncode == 0:
        return None
    for line in result.stdout.splitlines():
        if line.startswith("[  FAILED  ] "):
            return line.split("] ", 1)[1].split(",")[0].split(" (")[0]
        if line.startswith("FAILED "):
            return line.split(" ")[1]
    return "crashed"


def plant(mutation, jobs, log):
    """The test that caught the bug; None where none did."""
    path = TREE / mutation.file
    text = path.read_text()
    path.write_text(text.replace(mutation.old, mutation.new))
    try:
        if build([mutation.program], jobs, log) != 0:
            sys.exit(f"'{mutation.name}' does not compile: see {log}")
        return tests_fail(mutation, log)
    finally:
        path.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    options = parser.parse_args()
    chosen = [m for m in MUTATIONS if options.only in m.name]
    if options.list:
        for m in chosen:
            print(f"{m.name:60} {m.file}")
        return 0
    lost = [m for m in chosen if (ROOT / m.file).read_text().count(m.old) != 1]
    for m in lost:
        print(f"{m.file}: '{m.old}' is not there once; bring '{m.name}' in mutations.py up to date")
    if options.check:
        return 1 if lost else 0
    chosen = [m for m in chosen if m not in lost]
    HOME.mkdir(parents=True, exist_ok=True)
    log = HOME / "log.txt"
    log.write_text("")
    refresh_tree()
    programs = sorted({m.program for m in chosen})
    if build(programs, options.jobs, log) != 0:
        sys.exit(f"the unchanged source does not build: see {log}")
    for m in {(m.program, m.tests): m for m in chosen}.values():
        if tests_fail(m, log):
            sys.exit(f"without any bug '{m.tests}' of {m.program} fails already: see {log}")
    survived = []
    for m in chosen:
        began = time.monotonic()
        caught_by = plant(m, options.jobs, log)
        print(f"{m.name:68} {caught_by or 'NOT CAUGHT':70} {time.monotonic() - began:5.0f} s",
              flush=True)
        if not caught_by:
            survived.append(m.name)
    print(f"{len(chosen) - len(survived)} of {len(chosen) + len(lost)} bugs caught")
    return 1 if survived or lost else 0


if __name__ == "__main__":
    sys.exit(main())
