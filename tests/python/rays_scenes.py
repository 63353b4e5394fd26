"""Meshes and rays that several tests of ray queries share."""
import numpy as np
import tessera as ts


def tracer_of_mesh(points, rows, **options):
    return ts.Mesh(points, rows).tracer(**options)


def cube(cells=20, size=20.0):
    """A closed cube from 0 to `size` whose faces have cells x cells pairs of triangles, with shared
    vertices; its front is outside."""
    numbers, points, triangles = {}, [], []

    def vertex(place):
        if place not in numbers:
            numbers[place] = len(points)
            points.append([size * x / cells for x in place])
        return numbers[place]

    for axis in range(3):
        for side in (0, cells):
            for i in range(cells):
                for j in range(cells):
                    corners = []
                    for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        place = [0, 0, 0]
                        place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side, u, v
                        corners.append(vertex(tuple(place)))
                    if side == 0:
                        corners.reverse()
                    triangles += [corners[:3], [corners[0], corners[2], corners[3]]]
    return np.array(points, np.float32), np.array(triangles)


def soup(random, count, extent=2.0, size=1.0):
    """Triangles that have nothing to do with each other."""
    middle = random.uniform(-extent, extent, (count, 1, 3))
    points = middle + random.uniform(-size, size, (count, 3, 3))
    return points.reshape(-1, 3).astype(np.float32), np.arange(3 * count).reshape(-1, 3)


def rays_about(random, count, size=4.0):
    origins = random.uniform(-size, size, (count, 3))
    return origins, random.uniform(-size / 2, size / 2, (count, 3)) - origins
