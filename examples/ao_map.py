"""Ambient occlusion by ray queries: how much of the sky each point of a surface sees.

    ao_map.py [WIDTH [RAYS_PER_PIXEL]]            writes ao.png
"""
import sys

import numpy as np
import numpy.typing as npt
import tessera as ts


def sky_share(tracer: ts.Tracer, hits: ts.Hits, rays: int, seed: int = 1) -> npt.NDArray[np.float64]:
    """The share of an evenly bright sky that lights each hit, estimated by so many rays."""
    random = np.random.default_rng(seed)
    free = np.zeros(hits.shape)
    for _ in range(rays):
        # A unit normal plus a random unit vector: as likely as the cosine to the normal is large.
        ball = random.normal(size=hits.shape + (3,))
        directions = hits.normal + ball / np.linalg.norm(ball, axis=-1, keepdims=True)
        free += ~tracer.occluded(tracer.spawn(hits, directions), directions)
    return free / rays


def main(width: int = 640, rays: int = 64) -> None:
    scene = ts.Scene(width=width, height=width * 9 // 16)
    scene.camera = ts.Camera.look_at(eye=(0, 2, 6), target=(0, 0.8, 0), fov=35)
    scene.add(ts.Plane())
    for i in range(5):
        scene.add(ts.Box() - ts.Sphere(radius=1.25),
                  transform=ts.translate(i - 2, 0.4, 0) @ ts.rotate("y", 20 * i) @ ts.scale(0.4))
        scene.add(ts.Sphere(radius=0.3), transform=ts.translate(i - 2, 1.1, 0))

    tracer = scene.tracer()
    share = sky_share(tracer, tracer.intersect(*tracer.camera_rays()), rays)
    ts.Image.from_array(share).save("ao.png")
    print(f"ao.png  {width}x{scene.height}, {share.size * rays} rays, mean {share.mean():.3f}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
