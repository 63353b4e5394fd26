"""The types of the package hold, and no public name is without words."""
import inspect
import pathlib
import subprocess
import sys

import tessera as ts

SCRIPT = '''
import tessera as ts

scene = ts.Scene(width=64, height=36, spp=4, integrator="path")
red = ts.Classic(diffuse="red", sides="front_only")
node = scene.add(ts.Sphere((0, 0, 0), 1.0, material=red), transform=ts.translate(1, 2, 3), name="ball")
scene.add(ts.PointLight((3, 4, 5), intensity=2), ts.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)]))
scene.camera = ts.Camera.look_at((0, 0, 5), (0, 0, 0), fov=40, lens=ts.Lens(radius=.1, focus=5))
scene.background = ts.Background(glow=.5)
solid: ts.Csg = ts.Sphere() - ts.Box()
digest: str = scene.digest
'''


def mypy(path, text):
    path.write_text(text)
    package = pathlib.Path(ts.__file__).parent.parent
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--no-incremental", "--follow-imports=silent", path],
                          capture_output=True, text=True, cwd=path.parent,
                          env={"MYPYPATH": str(package), "PATH": "/usr/bin:/bin"})


def test_a_script_has_right_types_and_wrong_ones_are_found(tmp_path):
    right = mypy(tmp_path / "script.py", SCRIPT)
    assert right.returncode == 0, right.stdout
    wrong = mypy(tmp_path / "script.py", SCRIPT + 'ts.Sphere(raduis=1)\nts.Classic(sides="both")\n')
    assert wrong.stdout.count("error:") == 2, wrong.stdout


def test_each_public_name_has_words():
    silent = []
    for name in ts.__all__:
        thing = getattr(ts, name)
        if not inspect.getdoc(thing):
            silent.append(name)
        if inspect.isclass(thing):
            silent += [f"{name}.{member}" for member, held in vars(thing).items()
                       if not member.startswith("_") and callable(held) and not inspect.getdoc(held)]
    assert silent == []
