"""Turns a mesh made of arrays before the camera, on workers that are kept from frame to frame.

    turntable.py [FRAMES [WIDTH]]                 writes turn.000.png and so on
"""
import sys

import numpy as np
import tessera as ts

frames = int(sys.argv[1]) if len(sys.argv) > 1 else 48
width = int(sys.argv[2]) if len(sys.argv) > 2 else 640

# A trefoil knot: rings of vertices around a curve, and two triangles between neighbours.
along, around = 400, 40
s = np.linspace(0, 2 * np.pi, along, endpoint=False)
curve = np.stack([np.sin(s) + 2 * np.sin(2 * s), np.cos(s) - 2 * np.cos(2 * s), -np.sin(3 * s)], axis=1)
tangent = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
side = np.cross(tangent, (0, 0, 1))
side /= np.linalg.norm(side, axis=1, keepdims=True)
up = np.cross(side, tangent)
up /= np.linalg.norm(up, axis=1, keepdims=True)
angle = np.linspace(0, 2 * np.pi, around, endpoint=False)[:, None]
normals = np.cos(angle) * side[:, None] + np.sin(angle) * up[:, None]
positions = curve[:, None] + 0.5 * normals

vertex = np.arange(along * around).reshape(along, around)
a, b = vertex, np.roll(vertex, -1, axis=0)
c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)

scene = ts.Scene(width=width, height=width, spp=16, background="white")
scene.camera = ts.Camera.look_at(eye=(0, 3, 11), target=(0, 0, 0), fov=40)
knot = scene.add(ts.Mesh(positions.reshape(-1, 3), triangles, normals=normals.reshape(-1, 3), closed=True),
                 material=ts.Classic(diffuse="teal", specular="white", shininess=60))
scene.add(ts.PointLight(position=(5, 8, 9)), ts.PointLight(position=(-9, -3, 4), intensity=0.4))

with ts.LocalFarm() as farm:
    for frame in range(frames):
        knot.transform = ts.rotate("y", 360 * frame / frames)
        image = scene.render(farm=farm)
        image.save(f"turn.{frame:03}.png")
        print(f"turn.{frame:03}.png  {image.stats['bytes']['scene']} bytes of scene sent")
