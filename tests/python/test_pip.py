"""`pip install .`, and what it leaves: done once, in an environment of its own, from what is built."""
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import tessera as ts
from tessera import _core

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(ts.__file__).parents[2]
MIB = 2**20


def run(*command, folder, **environment):
    """A command without what the caller's Python has set."""
    return subprocess.run(list(map(str, command)), cwd=folder, capture_output=True, text=True,
                          env={"PATH": "/usr/bin:/bin", "HOME": str(folder), **environment})


def files_in(folder):
    return {path for path in folder.rglob("*")}


class Environment:
    def __init__(self, folder):
        self.folder = folder
        made = run(sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", folder / "venv",
                   folder=folder)
        assert made.returncode == 0, made.stderr
        self.site, = (folder / "venv").glob("lib/python3.*/site-packages")
        self.package = self.site / "tessera"
        self.files_before = files_in(folder / "venv")
        # The sources as links, so that what pip leaves beside setup.py is left here.
        self.sources = folder / "sources"
        self.sources.mkdir()
        for entry in ROOT.iterdir():
            if entry.name not in ("build", ".git", "tessera.egg-info"):
                (self.sources / entry.name).symlink_to(entry)
        self.pip("install", "--no-build-isolation", "--no-deps", self.sources)

    def python(self, *arguments):
        return run(self.folder / "venv/bin/python", *arguments, folder=self.folder)

    def pip(self, *arguments):
        environment = {"TESSERA_BUILD_FOLDER": str(BUILD), "PIP_NO_INDEX": "1", "PIP_NO_CACHE_DIR": "1"}
        done = run(self.folder / "venv/bin/python", "-m", "pip", *arguments, folder=self.folder, **environment)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    environment = Environment(tmp_path_factory.mktemp("pip"))
    yield environment
    shutil.rmtree(environment.folder)


def test_the_wheel_is_for_this_python_on_linux(installed):
    told, = installed.site.glob("tessera-*.dist-info/WHEEL")
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert f"Tag: {version}-{version}-linux_{os.uname().machine}\n" in told.read_text()


def test_it_has_every_file_of_the_package_and_is_no_link_to_them(installed):
    def python_files(package):
        return {file.relative_to(package) for kind in ("*.py", "*.pyi", "py.typed", "_core.*.so")
                for file in package.rglob(kind)}
    assert python_files(installed.package) == python_files(pathlib.Path(ts.__file__).parent)
    assert not any(file.is_symlink() for file in installed.package.rglob("*"))


def test_it_has_a_program_of_its_own_with_codec_and_modules(installed):
    shown = installed.python("-c", "import tessera; print(tessera.program())")
    assert shown.stdout.strip() == str(installed.package / "_bin/tessera"), shown.stderr
    told = run(installed.folder / "venv/bin/tessera", "--version", folder=installed.folder)
    assert told.stdout.startswith("tessera "), told.stderr
    scene = ROOT / "scenes/samples/knot.tessera"
    # PNG by the codec alone, EXR by the module that loads OpenImageIO, trees by those of Embree and NLopt.
    for picture, accelerator in (("knot.png", "bvh"), ("knot.exr", "embree"), ("other.png", "octree")):
        if accelerator == "embree" and not (BUILD / "bin/tessera_embree.so").exists():
            accelerator = "bvh"
        done = installed.python("-m", "tessera", "render", scene, "--size", "32x18", "--spp", "1", "--workers", "1",
                                "--accel", accelerator, "--quiet", "-o", installed.folder / picture)
        assert done.returncode == 0, done.stderr
    one, other = ((installed.folder / name).read_bytes() for name in ("knot.png", "other.png"))
    assert one == other


def test_what_is_installed_is_stripped_small_and_names_no_build_folder(installed):
    assert (installed.package / pathlib.Path(_core.__file__).name).stat().st_size <= 12 * MIB
    for file in [*installed.package.glob("*.so"), *(installed.package / "_bin").iterdir()]:
        data = file.read_bytes()
        assert b".debug_info" not in data, file
        assert os.fsencode(BUILD) not in data, file


def test_an_editable_install_is_refused_in_one_sentence(installed):
    refused = run(sys.executable, "setup.py", "build_ext", "--inplace", folder=installed.sources)
    assert refused.returncode != 0 and refused.stderr.splitlines()[-1].startswith("an editable install")


def test_uninstalled_it_leaves_nothing(installed):
    assert files_in(installed.folder / "venv") != installed.files_before
    installed.pip("uninstall", "-y", "tessera")
    assert files_in(installed.folder / "venv") == installed.files_before
