#!/usr/bin/env python3
"""The Debian packages, installed in a clean root and used there.

Opt-in: TESSERA_PACKAGES names the folder that `cpack -G DEB` wrote them to. As root, with debootstrap;
the machine's own package sources are used."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
from tessera_process import TesseraTest  # noqa: E402

PACKAGES = os.environ.get("TESSERA_PACKAGES")
SCENE = "/usr/share/tessera/samples/knot.tessera"


@unittest.skipUnless(PACKAGES, "TESSERA_PACKAGES names no packages")
class Package(TesseraTest):
    @classmethod
    def setUpClass(cls):
        cls.debs = sorted(pathlib.Path(PACKAGES).glob("*.deb"), reverse=True)
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="tessera-root-"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.run_step("debootstrap", "--variant=minbase", "bookworm", cls.root)
        for mounted in ("proc", "sys"):
            cls.run_step("mount", "--bind", f"/{mounted}", cls.root / mounted)
            cls.addClassCleanup(subprocess.run, ["umount", cls.root / mounted])
        for file in ("resolv.conf", "hosts"):
            shutil.copy(f"/etc/{file}", cls.root / "etc")
        (cls.root / "etc/apt/sources.list").write_text("")
        for file in pathlib.Path("/etc/apt/sources.list.d").glob("debian.*"):
            shutil.copy(file, cls.root / "etc/apt/sources.list.d")
        cls.inside("apt-get", "update", "-q")
        cls.install(cls.debs[0])

    @staticmethod
    def run_step(*command, **options):
        done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, **options)
        if done.returncode != 0:
            raise AssertionError(f"{command}: {done.stdout[-3000:]}")
        return done.stdout

    @classmethod
    def inside(cls, *command):
        return cls.run_step("env", "-i", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "HOME=/root",
                            "DEBIAN_FRONTEND=noninteractive", "chroot", cls.root, *command)

    @classmethod
    def install(cls, deb):
        shutil.copy(deb, cls.root / "srv")
        cls.inside("apt-get", "install", "-q", "-y", "--no-install-recommends", f"/srv/{deb.name}")

    def test_1_without_openimageio_it_renders_and_coordinates(self):
        self.assertNotIn("OpenImageIO", self.inside("ldconfig", "-p"))
        told = self.inside("tessera", "render", SCENE, "--workers", "4", "-o", "/srv/knot.png")
        self.assertIn("by 4 workers", told)
        for accelerator in ("embree", "octree"):  # Embree and NLopt are modules
            self.inside("tessera", "render", SCENE, "-o", "/srv/other.png", "--quiet", "--accel",
                        accelerator)
            self.assert_equal_pictures("knot.png", "other.png")
        self.inside("tessera", "render", SCENE, "--quiet", "-o", "/srv/knot.exr")
        self.assertGreater((self.root / "srv/knot.exr").stat().st_size, 10000)
        self.farm()

    def assert_equal_pictures(self, one, other):
        compared = self.run_program("compare", self.root / "srv" / one, self.root / "srv" / other)
        self.assertIn("differing pixels  0 of", compared.out, compared.err)

    def farm(self):
        def start(*arguments):
            process = subprocess.Popen(["chroot", self.root, "tessera", *arguments], text=True,
                                       stdout=subprocess.PIPE, env=self.environment())
            self.addCleanup(self.end, process)
            return process
        service = start("serve", "--store", "/srv/farm", "--bind", "tcp://127.0.0.1:*")
        endpoint = service.stdout.readline().split()[-1]
        worker = start("worker", "--connect", endpoint)
        self.inside("tessera", "submit", SCENE, "--quiet", "--connect", endpoint)
        self.inside("tessera", "fetch", "knot", "--wait", "-o", "/srv/farm.png", "--connect", endpoint)
        self.assert_equal_pictures("knot.png", "farm.png")
        service.send_signal(signal.SIGTERM)
        self.assertEqual(0, service.wait(60))
        self.assertEqual(0, worker.wait(60))

    def test_2_with_openimageio_it_writes_tiff(self):
        self.assertEqual(3, len(self.debs))
        self.install(self.debs[1])
        self.inside("tessera", "render", SCENE, "--quiet", "-o", "/srv/knot.tif")
        self.assertGreater((self.root / "srv/knot.tif").stat().st_size, 10000)

    def test_3_python_uses_the_installed_program(self):
        self.install(self.debs[2])
        package = self.root / "usr/lib/python3/dist-packages/tessera"
        self.assertTrue(list(package.glob("__pycache__/__init__.*.pyc")), "postinst compiles to byte code")
        core, = package.glob("_core.*.so")
        self.assertLessEqual(core.stat().st_size, 12 * 2**20)
        shown = self.inside("python3", "-c", "import sys, tessera as ts; print(ts.program(), ts.__version__)")
        version = self.inside("tessera", "--version")
        self.assertEqual(["/usr/lib/tessera/tessera", version.split()[1]], shown.split())
        self.assertEqual(version, self.inside("python3", "-m", "tessera", "--version"))

    def test_4_removed_it_leaves_nothing(self):
        self.inside("apt-get", "purge", "-q", "-y", "tessera", "tessera-openimageio", "python3-tessera")
        left = [path for folder in ("usr", "etc", "lib") for path in (self.root / folder).rglob("*tessera*")]
        self.assertEqual([], left)

    def test_lintian_finds_no_errors(self):
        if not shutil.which("lintian"):
            self.skipTest("lintian is not installed")
        print(self.run_step("lintian", "--fail-on", "error", *self.debs), flush=True)
        self.run_step("lintian", "--fail-on", "error,warning", self.debs[2])


if __name__ == "__main__":
    unittest.main()
