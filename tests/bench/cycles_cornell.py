r"""The Cornell box of docs/accuracy.md by Cycles, so that `tessera bench error --peer` can plot it.

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
import time

import bpy
from mathutils import Matrix, Vector


def diffuse(name, colour):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    surface = nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = (*colour, 1)
    surface.inputs["Roughness"].default_value = 0
    links.new(surface.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def one_sided_lamp(radiance):
    """Shines from its front; its back is black."""
    material = bpy.data.materials.new("lamp")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    light = nodes.new("ShaderNodeEmission")
    light.inputs["Strength"].default_value = radiance
    black = nodes.new("ShaderNodeBsdfDiffuse")
    black.inputs["Color"].default_value = (0, 0, 0, 1)
    mix = nodes.new("ShaderNodeMixShader")
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs["Fac"])
    links.new(light.outputs[0], mix.inputs[1])
    links.new(black.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def add(name, vertices, faces, material, place=None):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    if place is not None:
        thing.matrix_world = place
    bpy.context.scene.collection.objects.link(thing)


def rectangle(name, corner, u, v, material):
    """Faces along u x v."""
    c, u, v = Vector(corner), Vector(u), Vector(v)
    add(name, [c, c + u, c + u + v, c + v], [(0, 1, 2, 3)], material)


def block(name, x, y, height, turn, material):
    vertices = [(sx * .3, sy * .3, z) for z in (0, height) for sy in (-1, 1) for sx in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    add(name, vertices, faces, material, Matrix.Translation((x, y, -1)) @ Matrix.Rotation(turn, 4, "Z"))


def build_room():
    white = diffuse("white", (.73, .73, .73))
    rectangle("floor", (-1, -1, -1), (2, 0, 0), (0, 2, 0), white)
    rectangle("ceiling", (-1, -1, 1), (0, 2, 0), (2, 0, 0), white)
    rectangle("back", (-1, 1, -1), (2, 0, 0), (0, 0, 2), white)
    rectangle("left", (-1, -1, -1), (0, 2, 0), (0, 0, 2), diffuse("red", (.65, .05, .05)))
    rectangle("right", (1, -1, -1), (0, 0, 2), (0, 2, 0), diffuse("green", (.12, .45, .15)))
    block("tall block", -.35, .3, 1.2, .3, white)
    block("short block", .35, -.3, .6, -.3, white)
    rectangle("lamp", (-.25, -.25, .99), (0, .5, 0), (.5, 0, 0), one_sided_lamp(15))


def build_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    build_room()
    world = bpy.data.worlds.new("black")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    scene.world = world
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "HORIZONTAL"
    camera.angle = 2 * math.atan(1 / 2.9)
    thing = bpy.data.objects.new("camera", camera)
    thing.location = (0, -3.9, 0)
    thing.rotation_euler = (math.pi / 2, 0, 0)  # along +y, +z upwards
    scene.collection.objects.link(thing)
    scene.camera = thing
    return scene


def set_up(scene, options):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    for bounces in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, bounces + "_bounces", 64)
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.light_sampling_threshold = 0
    cycles.use_guiding = cycles.use_fast_gi = False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    cycles.seed = options.seed
    render = scene.render
    render.resolution_x = render.resolution_y = options.size
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", options.threads
    render.use_compositing = render.use_sequencer = False
    scene.view_settings.view_transform = "Raw"
    image = render.image_settings
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"
    image.exr_codec = "ZIP"


def timed_render(scene, samples):
    """Seconds on the wall and of all processors."""
    scene.cycles.samples = samples
    wall, used = time.monotonic(), os.times()
    bpy.ops.render.render()
    now = os.times()
    return time.monotonic() - wall, now.user - used.user + now.system - used.system


def mean_of(file):
    picture = bpy.data.images.load(file)
    picture.colorspace_settings.name = "Raw"
    values = picture.pixels[:]
    return [math.fsum(values[channel::4]) / (len(values) // 4) for channel in range(3)]


def main():
    parser = argparse.ArgumentParser(prog="cycles_cornell.py")
    parser.add_argument("output")
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--threads", type=int, default=4)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    scene = build_scene()
    set_up(scene, options)
    first = timed_render(scene, 1)[0]
    times = [timed_render(scene, options.samples) for _ in range(options.repeat)]
    output = os.path.abspath(options.output)
    bpy.data.images["Render Result"].save_render(output)
    wall, used = (min(column) for column in zip(*times))
    mean = " ".join(f"{value:.5f}" for value in mean_of(output))
    print(f"cycles: {options.samples} samples, {options.threads} threads: {wall:.3f} s on the wall, "
          f"{used:.3f} s of processors (1 sample: {first:.3f} s on the wall), mean R G B {mean}",
          flush=True)


main()
