#pragma once

#include <cstddef>
#include <filesystem>

namespace tessera {

/// Of our samples: two that take long, and two that do not.
inline constexpr char kHeavy[] = "mosaic.tessera", kFull[] = "cornell.tessera",
                      kLight[] = "still_life.tessera", kEdited[] = "lanterns.tessera";
/// Scenes of the bench beside our samples: a ball to be dragged, and a mesh with a file of its
/// material, which is edited.
inline constexpr char kDragged[] = "dragged.tessera", kMesh[] = "mesh.tessera",
                      kMeshMaterials[] = "mesh.mtl";

/// Writes them; the mesh has about so many triangles.
void write_bench_scenes(const std::filesystem::path& folder, size_t triangles);

}  // namespace tessera
