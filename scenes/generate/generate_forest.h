#pragma once

#include <cstdint>

#include "scenes/import/loaded_scene.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {

inline constexpr uint32_t kTreeTriangles = 100'000;

/// A tree of kTreeTriangles triangles, 1 high, standing on y = 0: a trunk, and leaves about it.
MeshData tree_mesh(uint64_t seed);
/// `trees` places in a square, 1 apart, each with one of two trees. The trees are described once
/// and shared by all places: 10,000 of these show 10^9 triangles.
LoadedScene forest(uint32_t trees);

}  // namespace tessera
