"""A depth camera without a display: distances, names and a cloud of points, from rays alone.

    depth_camera.py [WIDTH]                       writes depth.png and points.npy
"""
import sys

import numpy as np
import tessera as ts

width = int(sys.argv[1]) if len(sys.argv) > 1 else 640

scene = ts.Scene(width=width, height=width * 3 // 4)
scene.camera = ts.Camera.look_at(eye=(0, 1.5, 5), target=(0, 0.7, 0), fov=40)
scene.add(ts.Plane(), name="floor")
scene.add(ts.Sphere(center=(-1, 0.8, 0), radius=0.8), name="ball")
scene.add(ts.Torus(major_radius=0.6, minor_radius=0.2), name="ring",
          transform=ts.translate(1, 0.8, 0) @ ts.rotate("x", 70))

tracer = scene.tracer()
origins, directions = tracer.camera_rays()
hits = tracer.intersect(origins, directions)

for number, name in enumerate(tracer.instances):
    seen = hits.instance == number
    print(f"{name}: {seen.sum()} pixels, nearest {hits.t[seen].min():.3f} m")

np.save("points.npy", hits.point[hits.hit])
far = 12.0  # metres, at which the picture is black; so is the sky
ts.Image.from_array(np.clip(1 - hits.t / far, 0, 1), linear=False).save("depth.png")
