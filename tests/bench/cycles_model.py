r"""The scenes of beside_cycles.py by Cycles:

  blender --background --factory-startup --python-exit-code 1 --python cycles_model.py -- \
      OUTPUT.exr FOLDER KIND --samples 16 [--threads 4] [--size 512] [--seed 0] [--repeat 3]

FOLDER holds the model, the floor's texture and the sky's picture that beside_cycles.py made.
"""
import argparse
import json
import math
import os
import sys

import bpy
from mathutils import Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import blender_scene  # noqa: E402
from blender_scene import diffuse, material, rectangle  # noqa: E402


def turned(point):
    """Blender's z is upwards, our y."""
    x, y, z = point
    return Vector((x, -z, y))


def principled(facts, metallic):
    def build(nodes, _):
        surface = nodes.new("ShaderNodeBsdfPrincipled")
        surface.distribution = "MULTI_GGX"
        surface.inputs["Base Color"].default_value = (*facts["glossy"], 1)
        surface.inputs["Metallic"].default_value = metallic
        surface.inputs["Roughness"].default_value = facts["roughness"]
        surface.inputs["Specular"].default_value = .5  # a refractive index of 1.5
        return surface
    return build


def glass(facts, distribution, roughness):
    def build(nodes, _):
        surface = nodes.new("ShaderNodeBsdfGlass")
        surface.distribution = distribution
        surface.inputs["Color"].default_value = (1, 1, 1, 1)
        surface.inputs["Roughness"].default_value = roughness
        surface.inputs["IOR"].default_value = facts["index"]
        return surface
    return build


def half_there(facts):
    def build(nodes, links):
        mix = nodes.new("ShaderNodeMixShader")
        mix.inputs["Fac"].default_value = facts["opacity"]
        there = nodes.new("ShaderNodeBsdfDiffuse")
        there.inputs["Color"].default_value = (*[facts["model"]] * 3, 1)
        links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
        links.new(there.outputs[0], mix.inputs[2])
        return mix
    return build


def tinted_glass(facts):
    absorption = facts["absorption"]
    made = material("tinted", glass(facts, "SHARP", 0))
    nodes, links = made.node_tree.nodes, made.node_tree.links
    volume = nodes.new("ShaderNodeVolumeAbsorption")  # takes density * (1 - colour) a metre
    volume.inputs["Density"].default_value = max(absorption)
    volume.inputs["Color"].default_value = (*(1 - a / max(absorption) for a in absorption), 1)
    output = next(node for node in nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    links.new(volume.outputs[0], output.inputs["Volume"])
    return made


def emission(radiance):
    def build(nodes, _):
        surface = nodes.new("ShaderNodeEmission")
        surface.inputs["Strength"].default_value = radiance
        return surface
    return build


def textured(file):
    def build(nodes, links):
        texture = nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.load(file)
        surface = nodes.new("ShaderNodeBsdfDiffuse")
        links.new(texture.outputs["Color"], surface.inputs["Color"])
        return surface
    return build


def picture_world(file):
    world = bpy.data.worlds.new("picture")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(file)
    turn = nodes.new("ShaderNodeMapping")  # its middle lies at +x, ours at -z, which is +y here
    turn.inputs["Rotation"].default_value = (0, 0, -math.pi / 2)
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Generated"], turn.inputs["Vector"])
    links.new(turn.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])
    return world


def add_ball(center, radius, radiance):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=radius, location=turned(center))
    bpy.context.object.data.materials.append(material("ball", emission(radiance)))


def build(scene, folder, kind):
    facts = json.load(open(os.path.join(folder, "facts.json"), encoding="utf-8"))
    surfaces = {"plastic": principled(facts, 0), "metal": principled(facts, 1),
                "glass": glass(facts, "SHARP", 0),
                "frosted": glass(facts, "MULTI_GGX", facts["roughness"]), "veil": half_there(facts),
                "mesh": emission(facts["mesh_radiance"])}
    bpy.ops.wm.obj_import(filepath=os.path.join(folder, "model.obj"),
                          forward_axis="NEGATIVE_Z", up_axis="Y")
    model = bpy.context.selected_objects[0]
    model.data.materials.clear()
    if kind == "tinted":
        surface = tinted_glass(facts)
    elif kind in surfaces:
        surface = material(kind, surfaces[kind])
    else:
        surface = diffuse("model", [facts["model"]] * 3)
    model.data.materials.append(surface)
    floor = material("floor", textured(os.path.join(folder, "floor.png"))) if kind == "texture" \
        else diffuse("floor", [facts["floor"]] * 3)
    half = facts["floor_half"]
    ground = rectangle("floor", (-half, -half, 0), (2 * half, 0, 0), (0, 2 * half, 0), floor)
    corners = ground.data.uv_layers.new()
    for corner, at in zip(corners.data, ((0, 0), (1, 0), (1, 1), (0, 1))):
        corner.uv = at
    if kind in facts["under_lamp"]:
        side, height = facts["lamp_side"], facts["lamp_height"]
        rectangle("lamp", (-side / 2, -side / 2, height), (0, side, 0), (side, 0, 0),
                  blender_scene.one_sided_lamp(facts["lamp_radiance"]))
    if kind == "balls":
        for center in facts["balls"]:
            add_ball(center, facts["ball_radius"], facts["ball_radiance"])
    scene.world = picture_world(os.path.join(folder, "sky.hdr")) if kind == "sun" \
        else blender_scene.even_world(facts["sky"].get(kind, 0))
    if kind == "lights":
        for i, center in enumerate(facts["lamps"]):
            x, y, z = turned(center)
            side = facts["small_lamp_side"]
            rectangle(f"lamp {i}", (x - side / 2, y - side / 2, z), (0, side, 0), (side, 0, 0),
                      blender_scene.one_sided_lamp(facts["small_lamp_radiance"]))
    camera = blender_scene.add_camera(scene, turned(facts["eye"]), facts["width_over_distance"])
    view = turned(facts["target"]) - turned(facts["eye"])
    if kind == "lens":
        camera.data.dof.use_dof = True
        camera.data.dof.focus_distance = view.length
        camera.data.dof.aperture_fstop = camera.data.lens / 2000 / facts["lens_radius"]
    camera.rotation_euler = view.to_track_quat("-Z", "Y").to_euler()


def main():
    parser = argparse.ArgumentParser(prog="cycles_model.py")
    blender_scene.add_options(parser)
    parser.add_argument("folder")
    parser.add_argument("kind")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    build(scene, options.folder, options.kind)
    blender_scene.render(scene, options)


main()
