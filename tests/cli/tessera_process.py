"""Runs the real program for the end-to-end tests of this folder."""
import ctypes
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import uuid

PROGRAM = os.environ.get("TESSERA_PROGRAM") or str(
    pathlib.Path(__file__).parents[2] / "build/release/bin/tessera")
SLOWER = float(os.environ.get("TESSERA_TEST_SLOWDOWN", "1"))  # sanitizers
PATIENCE = 120 * SLOWER  # seconds; what takes longer is taken for hung, so no machine is too slow
MARK = "TESSERA_TEST_MARK"


def marked_processes(mark):
    """The ids of the living processes whose environment carries `mark`, zombies left out."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            if f"{MARK}={mark}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                state = (entry / "stat").read_text().rpartition(")")[2].split()[0]
                if state not in "ZX":
                    found.append(int(entry.name))
        except OSError:
            pass  # it ended while we looked
    return found


def is_worker(process):
    """Whether the living process is `tessera worker`, not one that encodes pictures, say."""
    try:
        return b"worker" in pathlib.Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return False


def catches(process, sent):
    """Whether the process has a handler for that signal by now."""
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    return int(status.split("SigCgt:")[1].split()[0], 16) >> (sent - 1) & 1 == 1


def heed_permissions():
    """Between fork and exec: the program will find unreadable what others would, though run by root."""
    PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH = 24, 1, 2
    for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, capability)


def wait_until(condition, what):
    """Polls until `condition()` is true; its value. What takes long is looked at rarely: it needs the cores itself."""
    began = time.monotonic()
    while True:
        if value := condition():
            return value
        waited = time.monotonic() - began
        if waited > PATIENCE:
            raise AssertionError(f"after {PATIENCE} s still not: {what}")
        time.sleep(min(0.002 + waited / 20, 0.05))


def nightly(test):
    """A test that is left to .ci/nightly, since quicker ones show that the same feature works."""
    test.is_nightly = True
    return test


class TesseraTest(unittest.TestCase):
    """Each test has a folder of its own and fails if it leaves a process or a temporary file."""

    def __init_subclass__(cls):
        """With TESSERA_TEST_NIGHTLY in the environment, 1 leaves those marked @nightly, 0 the others."""
        asked = os.environ.get("TESSERA_TEST_NIGHTLY")
        for name, member in list(vars(cls).items()):
            if asked and name.startswith("test_") and hasattr(member, "is_nightly") != (asked == "1"):
                delattr(cls, name)

    def troubles(self):
        result = self._outcome.result
        return len(result.failures) + len(result.errors)

    def setUp(self):
        self.troubles_before = self.troubles()
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-test-"))
        self.temporary = self.folder / "tmp"
        self.temporary.mkdir()
        self.mark = uuid.uuid4().hex
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def tearDown(self):
        left = marked_processes(self.mark)
        for process in left:
            os.kill(process, signal.SIGKILL)
        self.assertEqual([], left, "processes left behind")
        self.assertEqual([], list(self.temporary.iterdir()), "temporary files left behind")
        half = [p.name for p in self.folder.rglob("*")
                if p.suffix in (".part", ".tmp") and p != self.temporary]
        self.assertEqual([], half, "half-written files left behind")

    def environment(self):
        return {**os.environ, MARK: self.mark, "TMPDIR": str(self.temporary)}

    def write(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def start(self, *arguments, **options):
        """The program as a running process, in the test's folder."""
        process = subprocess.Popen(
            [PROGRAM, *map(str, arguments)], cwd=self.folder, env=self.environment(), text=True,
            stdin=subprocess.DEVNULL, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options})
        self.addCleanup(self.end, process)
        return process

    def end(self, process):
        """Ends it; of a test that failed, what it said."""
        lived = process.poll() is None
        if lived:
            process.kill()
        if process.stderr and process.stderr.closed:
            return  # the test has read it
        said = process.communicate()[1]
        if self.troubles() > self.troubles_before:
            how = "still ran" if lived else f"had ended with {process.returncode}"
            print(f"{' '.join(process.args[1:])}: {how}; it said:\n{said}", file=sys.stderr)

    def run_program(self, *arguments, **options):
        """The ended process with .code, .out and .err."""
        process = self.start(*arguments, **options)
        out, err = process.communicate(timeout=PATIENCE)
        return Result(process.returncode, out, err)

    def render(self, scene, *options):
        """Renders and returns the --stats of a success."""
        result = self.run_program("render", scene, "-o", "picture.png", "--stats", "stats.json",
                                  *options)
        self.assertEqual(0, result.code, result.err)
        return self.stats()

    def stats(self):
        return json.loads((self.folder / "stats.json").read_text())

    def assert_error(self, result, code, *parts):
        """One line on standard error that has all `parts`, and that exit code."""
        self.assertEqual(code, result.code, result.err)
        lines = [line for line in result.err.splitlines() if not line.startswith("tessera: warning")]
        self.assertEqual(1, len(lines), result.err)
        for part in parts:
            self.assertIn(part, lines[0])


class Result:
    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err
