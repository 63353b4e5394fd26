"""The wheel of the Python package. CMake builds it, and installs its component `wheel` into it.

    pip install --no-build-isolation .

The environment variable TESSERA_BUILD_FOLDER names a configured build folder that is to be used; by
default there is one of its own, below build/.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent
PROJECT = re.search(r"project\(tessera VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))


class BuildByCMake(build_ext):
    def run(self):
        if self.inplace or getattr(self, "editable_mode", False):
            sys.exit("an editable install was asked for; expected a plain one: after edits, use a build "
                     "folder by PYTHONPATH=<build folder>/python")
        folder = os.environ.get("TESSERA_BUILD_FOLDER")
        if not folder:
            folder = pathlib.Path(self.build_temp).resolve()
            self.cmake("--preset", "release", "-B", folder, "-DTESSERA_PYTHON=ON",
                       f"-DTESSERA_PYTHON_INTERPRETER={sys.executable}")
        self.cmake("--build", folder, "--target", "wheel")
        wheel = pathlib.Path(self.build_lib).resolve()
        shutil.rmtree(wheel / "tessera", ignore_errors=True)  # what an earlier build left
        self.cmake("--install", folder, "--component", "wheel", "--strip", "--prefix", wheel)

    @staticmethod
    def cmake(*arguments):
        subprocess.run(["cmake", *map(str, arguments)], cwd=ROOT, check=True)


setup(
    name="tessera",
    version=PROJECT.group(1),
    description="Ray-tracing renderer: scenes as values, pictures and ray queries as arrays",
    long_description="Built from source for the machine that it is installed on: it links the shared "
                     "libraries of that system (Debian 12), and is no manylinux wheel.",
    license="Apache-2.0",
    classifiers=["Intended Audience :: Science/Research", "Operating System :: POSIX :: Linux",
                 "Programming Language :: C++", "Programming Language :: Python :: 3.11",
                 "Topic :: Multimedia :: Graphics :: 3D Rendering"],
    python_requires=">=3.10",
    packages=[],
    entry_points={"console_scripts": ["tessera = tessera.__main__:main"]},
    ext_modules=[Extension("tessera._core", [])],
    cmdclass={"build_ext": BuildByCMake},
)
