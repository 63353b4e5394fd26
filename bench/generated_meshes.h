#pragma once

#include <cstdint>
#include <string>

#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// The icosahedron, each triangle cut in four `subdivisions` times: 20 * 4^n triangles on a sphere
/// of radius 2, closed, outward.
TriangleMesh icosphere(int subdivisions);
/// Unconnected triangles of side about 1 / cbrt(count) in the unit cube.
TriangleMesh triangle_soup(size_t count, uint64_t seed);
/// Each triangle cut in four at the middles of its edges, `times` over; vertices are not shared.
TriangleMesh subdivided(const TriangleMesh& mesh, int times);

/// The same, as often as it takes to have a million triangles.
TriangleMesh subdivided_to_a_million(const TriangleMesh& mesh);

/// A furnished room, about 100,000 triangles: large walls, boxes of all sizes on shelves and floor,
/// thin bars, and finely divided balls.
TriangleMesh furnished_room(uint64_t seed);

}  // namespace tessera
