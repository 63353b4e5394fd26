r"""The Cornell box of docs/notes/accuracy_measured.md by Cycles, for `tessera bench error --peer`.

  blender --background --factory-startup --python-exit-code 1 --python cycles_cornell.py -- \
      OUTPUT.exr --samples 64 [--threads 4] [--size 512] [--seed 0] [--repeat 3]

It is the scene of scenes/samples/cornell.tessera: diffuse surfaces, a lamp that shines downwards
alone, a box filter of one pixel, 64 bounces; nothing clamped, denoised or stopped early; linear
light in an EXR of 32 bits. It is rendered once with one sample to warm up, then `--repeat` times.

  cycles: 64 samples, 4 threads: 10.420 s on the wall, 41.100 s of processors (...), mean R G B ...

tells the least of these times, each from the call of the renderer to its return: handing Cycles
the scene and building its tree are in it (less than the one sample takes, which is told too),
Blender's start and the writing of the file are not.
"""
import argparse
import math
import os
import sys

import bpy
from mathutils import Matrix

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import blender_scene  # noqa: E402
from blender_scene import diffuse, rectangle  # noqa: E402


def block(name, x, y, height, turn, surface):
    vertices = [(sx * .3, sy * .3, z) for z in (0, height) for sy in (-1, 1) for sx in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    blender_scene.add(name, vertices, faces, surface).matrix_world = \
        Matrix.Translation((x, y, -1)) @ Matrix.Rotation(turn, 4, "Z")


def build_room():
    white = diffuse("white", (.73, .73, .73))
    rectangle("floor", (-1, -1, -1), (2, 0, 0), (0, 2, 0), white)
    rectangle("ceiling", (-1, -1, 1), (0, 2, 0), (2, 0, 0), white)
    rectangle("back", (-1, 1, -1), (2, 0, 0), (0, 0, 2), white)
    rectangle("left", (-1, -1, -1), (0, 2, 0), (0, 0, 2), diffuse("red", (.65, .05, .05)))
    rectangle("right", (1, -1, -1), (0, 0, 2), (0, 2, 0), diffuse("green", (.12, .45, .15)))
    block("tall block", -.35, .3, 1.2, .3, white)
    block("short block", .35, -.3, .6, -.3, white)
    rectangle("lamp", (-.25, -.25, .99), (0, .5, 0), (.5, 0, 0), blender_scene.one_sided_lamp(15))


def main():
    parser = argparse.ArgumentParser(prog="cycles_cornell.py")
    blender_scene.add_options(parser)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    build_room()
    scene.world = blender_scene.even_world(0)
    camera = blender_scene.add_camera(scene, (0, -3.9, 0), 2 / 2.9)
    camera.rotation_euler = (math.pi / 2, 0, 0)  # along +y, +z upwards
    blender_scene.render(scene, options)


main()
