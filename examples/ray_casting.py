"""Measures a solid by rays: its volume by all hits along parallel rays, and by points inside it.

    ray_casting.py [RAYS_PER_SIDE]
"""
import sys

import numpy as np
import tessera as ts

side = int(sys.argv[1]) if len(sys.argv) > 1 else 1000

# A cube whose corners stick out of a ball that was taken from it.
scene = ts.Scene()
scene.add(ts.Box() - ts.Sphere(radius=1.2), name="solid")
tracer = scene.tracer()

# One ray in the middle of each cell of a grid above the solid, straight down.
middles = (np.arange(side) + 0.5) / side * 2 - 1
x, z = np.meshgrid(middles, middles)
origins = np.stack([x, np.full_like(x, 2), z], axis=-1)
down = (0, -1, 0)

# Where a ray leaves the solid its t counts, and where it enters less t: what is left is the length inside.
hits = tracer.intersect_all(origins, down)
leaves = hits.normal @ down > 0
length = np.bincount(hits.ray, np.where(leaves, hits.t, -hits.t), minlength=side * side)
by_hits = length.sum() * (2 / side) ** 2

# The same by chance: the share of random points in the cube that are inside.
points = np.random.default_rng(1).uniform(-1, 1, (side * side, 3))
by_points = tracer.contains(points).mean() * 8

print(f"{len(hits)} hits of {side * side} rays")
print(f"volume by rays   {by_hits:.4f} m^3")
print(f"volume by points {by_points:.4f} m^3")
