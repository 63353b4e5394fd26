"""Small scenes in text form, one a kind of work: a mesh, mirrors and glass, several lights."""
import math

CAMERAS = """
cameras {
  name: "front"
  world_from_camera { steps { look_at { eye { x: 0.5 y: 1.5 z: 5 } target { y: 0.5 } } } }
  perspective { field_of_view: 45 }
}
cameras {
  name: "side"
  world_from_camera { steps { look_at { eye { x: 5 y: 1 z: 0 } target { y: 0.5 } } } }
}
"""

CAMERA = CAMERAS + """
background { gradient { sky { r: 0.4 g: 0.6 b: 1 } ground { r: 0.8 g: 0.7 b: 0.6 } } }
"""

SUN = """
nodes { name: "sun" light { directional { direction { x: -0.5 y: -1 z: -0.6 } } } }
"""

ONE_SPHERE = CAMERA + SUN + """
nodes { shape { sphere { center { y: 0.5 } } } }
"""

MOVING = CAMERA + SUN + """
settings { frames { per_second: 10 } sampling { samples_per_pixel: 1 } }
nodes {
  shape { sphere { center { y: 0.5 } radius: 0.5 } }
  keys { time: 0 transform { steps { translate {} } } } keys { time: 1 transform { steps { translate { x: 3 } } } }
}
"""


def material(name, fields):
    return f'materials {{ name: "{name}" classic {{ {fields} }} }}\n'


def gray(field, value):
    return f"{field} {{ value {{ r: {value} g: {value} b: {value} }} }}"


def mesh_scene(rings=24, segments=48):
    """A bumpy torus of 2 * rings * segments triangles."""
    positions, triangles = [], []
    for i in range(rings):
        for j in range(segments):
            u, v = 2 * math.pi * i / rings, 2 * math.pi * j / segments
            minor = 0.45 + 0.08 * math.cos(5 * v) * math.sin(3 * u)
            radius = 1.1 + minor * math.cos(u)
            positions += [radius * math.cos(v), 0.6 + minor * math.sin(u), radius * math.sin(v)]
            a, b = i * segments + j, i * segments + (j + 1) % segments
            c, d = ((i + 1) % rings * segments + j), ((i + 1) % rings * segments + (j + 1) % segments)
            triangles += [a, c, b, b, c, d]
    return (CAMERA + SUN + material("clay", gray("diffuse", 0.7)) +
            'nodes { shape { materials: "clay" mesh {\n'
            f"inline_positions: [{', '.join(f'{p:.6f}' for p in positions)}]\n"
            f"inline_triangles: [{', '.join(map(str, triangles))}]\n"
            "} } }\nnodes { shape { plane { } } }\n")


def two_meshes_scene():
    """Two bumpy balls side by side."""
    nodes = ""
    for x in (-1.3, 1.3):
        positions, triangles = [], []
        rings, segments = 24, 32
        for i in range(rings + 1):
            for j in range(segments):
                u, v = math.pi * (i + .5) / (rings + 1), 2 * math.pi * j / segments
                radius = 0.9 + 0.1 * math.cos(7 * v) * math.sin(5 * u)
                positions += [x + radius * math.sin(u) * math.cos(v), 1 + radius * math.cos(u),
                              radius * math.sin(u) * math.sin(v)]
                if i < rings:
                    a, b = i * segments + j, i * segments + (j + 1) % segments
                    triangles += [a, b, a + segments, b, b + segments, a + segments]
        nodes += ('nodes { shape { materials: "clay" mesh {\n'
                  f"inline_positions: [{', '.join(f'{p:.6f}' for p in positions)}]\n"
                  f"inline_triangles: [{', '.join(map(str, triangles))}]\n}} }} }}\n")
    return CAMERA + SUN + material("clay", gray("diffuse", 0.7)) + nodes


def glass_scene():
    """A mirror and a glass ball that see each other, on a plane."""
    return (CAMERA + SUN +
            material("mirror", gray("reflectivity", 0.9) + gray("diffuse", 0.05)) +
            material("glass", "transparency { value: 0.9 } refractive_index: 1.5 " +
                     gray("diffuse", 0.02)) +
            'nodes { shape { materials: "mirror" sphere { center { x: -0.9 y: 0.8 } radius: 0.8 } } }\n'
            'nodes { shape { materials: "glass" sphere { center { x: 0.8 y: 0.6 z: 0.8 } radius: 0.6 } } }\n'
            'nodes { shape { box { min { x: 0.5 y: 0 z: -1.5 } max { x: 1.5 y: 1 z: -0.5 } } } }\n'
            "nodes { shape { plane { } } }\n")


def paths_scene():
    """Lamps of three shapes, the sky, rough metal and glass, to be followed by paths."""
    lamp = gray("diffuse", 0) + gray("emission", 6)
    return (CAMERAS + material("lamp", lamp) +
            'settings { sampling { samples_per_pixel: 4 } integrator { kind: "path" } }\n'
            "background { sun_and_sky { sun_direction { x: 1 y: 2 z: 1 } intensity: .2 } }\n"
            'materials { name: "metal" conductor { eta { r: .2 g: .9 b: 1.1 } k { r: 3.9 g: 2.5 b: 2.4 } '
            "roughness { value: .3 } } }\n"
            'materials { name: "frosted" dielectric { roughness { value: .4 } } }\n'
            'nodes { shape { materials: "metal" sphere { center { x: -0.9 y: 0.8 } radius: 0.8 } } }\n'
            'nodes { shape { materials: "frosted" sphere { center { x: 0.8 y: 0.6 z: 0.8 } radius: 0.6 } } }\n'
            'nodes { shape { materials: "lamp" sphere { center { x: 1.2 y: 1.6 } radius: 0.2 } } }\n'
            'nodes { shape { materials: "lamp" disc { center { y: 3 } normal { y: -1 } radius: .5 } } }\n'
            'nodes { shape { materials: "lamp" box { min { x: -2 z: 1 } max { x: -1.8 y: .2 z: 1.2 } } } }\n'
            "nodes { shape { plane { } } }\n")


def lights_scene():
    """Every kind of light over a few boxes, with shadows."""
    lights = "".join(
        f"nodes {{ light {{ point {{ position {{ x: {2.5 * math.cos(a):.4f} y: 2 z: "
        f"{2.5 * math.sin(a):.4f} }} }} color {{ r: {0.5 + 0.5 * math.cos(a):.4f} g: 0.6 b: "
        f"{0.5 + 0.5 * math.sin(a):.4f} }} intensity: 0.25 }} }}\n"
        for a in (2 * math.pi * i / 6 for i in range(6)))
    spot = ("nodes { light { spot { position { y: 4 } direction { y: -1 } beam_width: 15 cut_off: 30 } "
            "intensity: 0.5 } }\n")
    boxes = "".join(
        f"nodes {{ shape {{ box {{ min {{ x: {x} y: 0 z: {z} }} max {{ x: {x + 0.5} y: {0.3 + 0.2 * k} "
        f"z: {z + 0.5} }} }} }} }}\n" for k, (x, z) in enumerate([(-1.2, 0), (0, -1), (0.6, 0.7)]))
    return CAMERA + SUN + lights + spot + boxes + "nodes { shape { plane { } } }\n"
