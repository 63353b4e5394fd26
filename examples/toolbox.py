"""Spheres and a cuboid on a plane between two mirrors, in the light of three lamps: the picture that a
classic toolbox of Python objects took 10 to 20 minutes for.

    python3 toolbox.py [PIXELS a side] [FILE.png]
"""
import sys

import tessera as ts

size = int(sys.argv[1]) if len(sys.argv) > 1 else 1400
file = sys.argv[2] if len(sys.argv) > 2 else "toolbox.png"


def matt(colour: str, highlight: float = .15) -> ts.Classic:
    return ts.Classic.toolbox(diffuse=.5, ambient=.35, highlight=highlight, roughness=.1, colour=colour)


scene = ts.Scene(width=size, height=size, ambient=(.4, .4, .4), response=ts.LIGHT_1, max_depth=100,
                 transfer="display", background=ts.Background(solid=(.08, .1, .16), glow=.12))
# Up is z, as in the toolbox; the screen stands half-way to what is looked at.
scene.camera = ts.Camera.screen(eye=(-3, -14, 4.2), centre=(-.2, 0, 1), width=5)

scene.add(ts.Plane.through((0, 0, 0), (1, 0, 0), (0, 1, 0)), material=matt("tan", highlight=0))
mirror = ts.Classic.toolbox(diffuse=.02, mirror=True)
back = ts.Rectangle.from_corners((-6, 4, .1), (6, 4, .1), (6, 4, 4.5), (-6, 4, 4.5), material=mirror)
scene.add(back)
scene.add(back.copy().mirror(ts.Plane((0, 1, 0), -6)))  # behind the eye, which its copy faces

for x, y, radius, colour in [(-2.6, .4, 1.3, "crimson"), (0, 1.2, 1, "gold"), (2.3, .2, 1.2, "steelblue"),
                             (-.7, -2, .5, "seagreen"), (1, -2.6, .4, "orchid")]:
    scene.add(ts.Sphere((x, y, radius), radius, material=matt(colour)))
ball = ts.Sphere((-3.8, -2.4, .6), .6, material=mirror)
scene.add(ball, ball.copy((7.8, .5, 0)))

a, b, c, d = (1.4, -2.2), (2.6, -2.8), (3.2, -1.6), (2, -1)
cuboid = ts.Box.from_corners([(*p, z) for z in (0, .9) for p in (a, b, c, d)], material=matt("coral"))
scene.add(cuboid)
scene.add(cuboid.copy().shift((-3.6, .3, 0)) - ts.Sphere((-1.3, -1.6, .9), .55, material=matt("white")))

for position, intensity in [((-7, -9, 9), .8), ((6, -6, 7), .5), ((0, 2, 8), .3)]:
    scene.add(ts.PointLight(position, intensity=intensity))

image = scene.render()
image.save(file)
print(f"{file}: {image.stats['pixels_sha256']}")
