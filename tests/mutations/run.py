#!/usr/bin/env python3
"""Plants one known bug after another in a copy of the source and makes sure that a test fails.

  tests/mutations/run.py                 all of them, on each core another one
  tests/mutations/run.py --only torus    those with "torus" in their names
  tests/mutations/run.py --list          what there is
  tests/mutations/run.py --check         whether each finds its place in the source

The copies, one for each core, and their builds stay in build/mutations, for the next run. The exit code is 1 where a bug
was not caught, or its place is not in the source any more. Nothing of this is ever in the program itself.
"""

import argparse
import concurrent.futures
import os
import pathlib
import queue
import shutil
import subprocess
import sys
import time

from mutations import MUTATIONS, PYTHON

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOME = ROOT / "build" / "mutations"

def tracked_files():
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others",
                             "--exclude-standard"], cwd=ROOT, check=True, capture_output=True)
    return [name for name in listed.stdout.decode().split("\0")
            if name and (ROOT / name).is_file()]


class Copy:
    """A copy of the source in which one bug at a time is planted, and its build."""

    def __init__(self, number):
        self.tree, self.build_folder = HOME / str(number) / "tree", HOME / str(number) / "build"
        self.log = HOME / f"{number}.log"
        self.log.parent.mkdir(parents=True, exist_ok=True)
        self.log.write_text("")
        self.refresh()

    def refresh(self):
        """Copies what has changed, so that what has not is not compiled again."""
        names = tracked_files()
        for name in names:
            source, copy = ROOT / name, self.tree / name
            if copy.exists() and copy.read_bytes() == source.read_bytes():
                continue
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, copy)
            shutil.copymode(source, copy)
        known = set(names)
        for copy in [path for path in self.tree.rglob("*") if path.is_file()]:
            if str(copy.relative_to(self.tree)) not in known:
                copy.unlink()

    def run(self, command):
        with open(self.log, "a") as out:
            return subprocess.run(command, stdout=out, stderr=subprocess.STDOUT,
                                  check=False).returncode

    def build(self, targets, jobs):
        if not (self.build_folder / "build.ninja").exists():
            configure = ["cmake", "-G", "Ninja", "-S", str(self.tree), "-B", str(self.build_folder),
                         "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O1", "-DTESSERA_TESTS=ON"]
            if self.run(configure) != 0:
                sys.exit(f"cmake failed: see {self.log}")
        if PYTHON in targets:
            targets = [*(target for target in targets if target != PYTHON), "tessera",
                       "tessera_python"]
        return self.run(["cmake", "--build", str(self.build_folder), "-j", str(jobs), "--target",
                         *targets])

    def command_of(self, mutation):
        """What runs its tests: the command, and what its environment and folder are."""
        programs = self.build_folder / "bin"
        if mutation.program == PYTHON:
            return (["/usr/bin/python3", "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider",
                     *mutation.tests.split()],
                    {"cwd": self.tree / "tests" / "python",
                     "env": {**os.environ, "TESSERA_PROGRAM": str(programs / "tessera"),
                             "PYTHONPATH": str(self.build_folder / "python")}})
        return [str(programs / mutation.program), f"--gtest_filter={mutation.tests}",
                "--gtest_fail_fast", "--gtest_brief=1"], {}

    def tests_fail(self, mutation):
        command, options = self.command_of(mutation)
        try:
            result = subprocess.run(command, capture_output=True, text=True, errors="replace",
                                    check=False, timeout=300, **options)
        except subprocess.TimeoutExpired:
            return "does not end"  # which ctest, too, takes as a failure
        with open(self.log, "a") as out:
            out.write(result.stdout[-4000:])
        if result.returncode == 0:
            return None
        for line in result.stdout.splitlines():
            if line.startswith("[  FAILED  ] "):
                return line.split("] ", 1)[1].split(",")[0].split(" (")[0]
            if line.startswith("FAILED "):
                return line.split(" ")[1]
        return "crashed"

    def plant(self, mutation):
        """The test that caught the bug; None where none did."""
        path = self.tree / mutation.file
        text = path.read_text()
        path.write_text(text.replace(mutation.old, mutation.new))
        try:
            if self.build([mutation.program], 1) != 0:
                sys.exit(f"'{mutation.name}' does not compile: see {self.log}")
            return self.tests_fail(mutation)
        finally:
            path.write_text(text)


def on_copies(copies, method, mutations):
    """Calls method(copy, mutation) for each mutation on a copy that is free, side by side: the copy, the
    mutation and the result, in order."""
    free = queue.SimpleQueue()
    for copy in copies:
        free.put(copy)

    def call(mutation):
        copy = free.get()
        try:
            return copy, mutation, method(copy, mutation)
        finally:
            free.put(copy)
    with concurrent.futures.ThreadPoolExecutor(len(copies)) as threads:
        yield from threads.map(call, mutations)


def plant(copy, mutation):
    """Copy.plant(), told."""
    began = time.monotonic()
    caught_by = copy.plant(mutation)
    print(f"{mutation.name:68} {caught_by or 'NOT CAUGHT':70} {time.monotonic() - began:5.0f} s",
          flush=True)
    return caught_by


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
    files = {m.file: ROOT / m.file for m in chosen}
    texts = {name: path.read_text() if path.exists() else "" for name, path in files.items()}
    lost = [m for m in chosen if texts[m.file].count(m.old) != 1]
    for m in lost:
        print(f"{m.file}: '{m.old}' is not there once; bring '{m.name}' in mutations.py up to date")
    if options.check:
        return 1 if lost else 0
    chosen = [m for m in chosen if m not in lost]
    programs = sorted({m.program for m in chosen})
    copies = [Copy(i) for i in range(min(options.jobs, max(1, len(chosen))))]
    for copy in copies:
        if copy.build(programs, options.jobs) != 0:
            sys.exit(f"the unchanged source does not build: see {copy.log}")
    whole = {(m.program, m.tests): m for m in chosen}.values()
    for copy, m, failed in on_copies(copies, Copy.tests_fail, whole):
        if failed:
            sys.exit(f"without any bug '{m.tests}' of {m.program} fails already: see {copy.log}")
    survived = [m for _, m, caught_by in on_copies(copies, plant, chosen) if not caught_by]
    print(f"{len(chosen) - len(survived)} of {len(chosen) + len(lost)} bugs caught")
    return 1 if survived or lost else 0


if __name__ == "__main__":
    sys.exit(main())
