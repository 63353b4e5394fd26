#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/import/loaded_scene.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {

/// A unit sphere of 20 * 4^subdivisions triangles, by halving the edges of an icosahedron; at most
/// 10 subdivisions.
MeshData icosphere(int subdivisions, bool smooth);
/// `count` triangles with corners within `size` of a centre that is uniform in [-1, 1]^3.
MeshData triangle_soup(uint32_t count, double size, uint64_t seed);
/// A unit sphere of rings from pole to pole and segments around, both at least 3.
MeshData uv_sphere(uint32_t rings, uint32_t segments);
/// An octahedron of 8 triangles with its corners 1 from the origin.
MeshData diamond();

/// Names and parameters of the scenes that generate_scene makes, for help texts.
std::vector<std::string> generated_scene_names();

/// A procedural scene from text as "icosphere:5", "soup:100000", "spheres:10", "uvsphere:200" or
/// "forest:10000", with a camera and lights. The same text gives the same bytes everywhere. Throws
/// usage_error for an unknown name or a number out of its range.
LoadedScene generate_scene(std::string_view what);

}  // namespace tessera
