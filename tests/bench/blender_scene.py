"""What the scripts of this folder that Blender runs share: surfaces, shapes, and Cycles with all that
is approximate switched off."""
import array
import math
import os
import time

import bpy
from mathutils import Vector


def material(name, build):
    """`build` is given the nodes and links, and returns the surface's node."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    surface = build(nodes, links)
    links.new(surface.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def diffuse(name, colour):
    def build(nodes, _):
        surface = nodes.new("ShaderNodeBsdfDiffuse")
        surface.inputs["Color"].default_value = (*colour, 1)
        surface.inputs["Roughness"].default_value = 0
        return surface
    return material(name, build)


def one_sided_lamp(radiance):
    """Shines from its front; its back is black."""
    def build(nodes, links):
        light = nodes.new("ShaderNodeEmission")
        light.inputs["Strength"].default_value = radiance
        black = nodes.new("ShaderNodeBsdfDiffuse")
        black.inputs["Color"].default_value = (0, 0, 0, 1)
        mix = nodes.new("ShaderNodeMixShader")
        links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs["Fac"])
        links.new(light.outputs[0], mix.inputs[1])
        links.new(black.outputs[0], mix.inputs[2])
        return mix
    return material("lamp", build)


def place(thing):
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add(name, vertices, faces, surface):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.materials.append(surface)
    return place(bpy.data.objects.new(name, mesh))


def rectangle(name, corner, u, v, surface):
    """Faces along u x v."""
    c, u, v = Vector(corner), Vector(u), Vector(v)
    return add(name, [c, c + u, c + u + v, c + v], [(0, 1, 2, 3)], surface)


def even_world(radiance):
    world = bpy.data.worlds.new("even")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = radiance
    return world


def add_camera(scene, location, width_over_distance):
    """`width_over_distance` of what is seen; looks where the returned object is turned to."""
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "HORIZONTAL"
    camera.angle = 2 * math.atan(width_over_distance / 2)
    thing = place(bpy.data.objects.new("camera", camera))
    thing.location = location
    scene.camera = thing
    return thing


def add_options(parser):
    parser.add_argument("output")
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--threads", type=int, default=4)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--pfm", help="a second file, of plain numbers")


def set_up(scene, options):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    for bounces in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, bounces + "_bounces", 64)
    cycles.transparent_max_bounces = 1024
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.light_sampling_threshold = 0
    cycles.blur_glossy = 0
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


def values_of(file):
    """Four numbers a pixel, rows from the bottom."""
    picture = bpy.data.images.load(file)
    picture.colorspace_settings.name = "Raw"
    return picture.pixels[:]


def mean_of(values):
    return [math.fsum(values[channel::4]) / (len(values) // 4) for channel in range(3)]


def write_pfm(path, values, size):
    with open(path, "wb") as file:
        file.write(b"PF\n%d %d\n-1\n" % (size, size))
        array.array("f", (x for i, x in enumerate(values) if i % 4 != 3)).tofile(file)


def render(scene, options):
    """Once with one sample to warm up, then as often as asked; tells the least times."""
    set_up(scene, options)
    first = timed_render(scene, 1)[0]
    times = [timed_render(scene, options.samples) for _ in range(options.repeat)]
    output = os.path.abspath(options.output)
    bpy.data.images["Render Result"].save_render(output)
    values = values_of(output)
    if options.pfm:
        write_pfm(options.pfm, values, options.size)
    wall, used = (min(column) for column in zip(*times))
    mean = " ".join(f"{value:.5f}" for value in mean_of(values))
    print(f"cycles: {options.samples} samples, {options.threads} threads: {wall:.3f} s on the wall, "
          f"{used:.3f} s of processors (1 sample: {first:.3f} s on the wall), mean R G B {mean}",
          flush=True)
