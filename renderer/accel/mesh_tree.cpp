#include "renderer/accel/mesh_tree.h"

#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>

#include "base/monotonic.h"
#include "base/process.h"
#include "renderer/accel/spatial_splits.h"
#include "renderer/accel/tree_boxes.h"

namespace tessera {
namespace {

/// All of a built tree but its array.
struct Facts {
  Bounds3 bounds;
  CutPlanes cut_planes;
  uint32_t root = 0;
  float extent = 0;
  float usual_extent = 0;
  BoxMargin margin;
  AcceleratorStatistics statistics;
};
static_assert(std::is_trivially_copyable_v<Facts>);
static_assert(sizeof(TraversalTree) == sizeof(AlignedArray<TreeUnit>) + 12 + 4 + sizeof(BoxMargin),
              "a new member belongs into Facts");

std::optional<BuiltMeshTree> load(const SharedArena::Claim& claim) {
  Facts facts;
  if (claim.size().value_or(0) < sizeof facts) return std::nullopt;
  const uint64_t units = (*claim.size() - sizeof facts) / sizeof(TreeUnit);
  BuiltMeshTree built;
  TraversalTree& tree = built.tree.tree;
  tree.units = AlignedArray<TreeUnit>(static_cast<size_t>(units));
  if (!claim.read(0, std::as_writable_bytes(std::span(&facts, 1))) ||
      !claim.read(sizeof facts,
                  std::as_writable_bytes(std::span(tree.units.data(), tree.units.size())))) {
    return std::nullopt;
  }
  tree.root = facts.root;
  tree.extent = facts.extent;
  tree.usual_extent = facts.usual_extent;
  tree.margin = facts.margin;
  built.tree.bounds = facts.bounds;
  built.tree.cut_planes = facts.cut_planes;
  built.statistics = facts.statistics;
  return built;
}

void publish(SharedArena::Claim& claim, const BuiltMeshTree& built) {
  const TraversalTree& tree = built.tree.tree;
  const Facts facts{built.tree.bounds, built.tree.cut_planes, tree.root,       tree.extent,
                    tree.usual_extent, tree.margin,           built.statistics};
  const std::array parts{std::as_bytes(std::span(&facts, 1)),
                         std::as_bytes(std::span(tree.units.data(), tree.units.size()))};
  claim.publish(parts);
}

}  // namespace

BuiltMeshTree build_mesh_tree(const TriangleMesh& mesh, int threads, BvhQuality quality) {
  const Time start = monotonic_now();
  BuiltMeshTree built;
  std::vector<BuildBox> boxes = triangle_boxes(mesh, threads);
  built.tree.bounds = bounds_of(boxes, threads);
  if (quality == BvhQuality::spatial_splits) {
    SpatialSplits splits = split_spatially(mesh, std::move(boxes));
    boxes = std::move(splits.boxes);
    built.tree.cut_planes = splits.planes;
  }
  const size_t references = boxes.size();
  const WideTree tree = build_wide_tree(std::move(boxes), 4, threads);
  lay_out(tree, mesh, built.tree, threads);
  built.statistics = statistics_of(tree, mesh.triangles.size(), references);
  built.statistics.bytes = built.tree.tree.units.bytes();
  built.statistics.build_seconds = to_seconds(monotonic_now() - start);
  return built;
}

BuiltMeshTree shared_mesh_tree(const TriangleMesh& mesh, int threads, BvhQuality quality,
                               const SharedTree& shared) {
  if (shared.arena == nullptr || mesh.triangles.size() < kTrianglesWorthSharing) {
    return build_mesh_tree(mesh, threads, quality);
  }
  SharedArena::Claim claim = shared.arena->claim(shared.key);
  if (auto loaded = load(claim)) return std::move(*loaded);
  BuiltMeshTree built = build_mesh_tree(mesh, std::max(threads, core_count()), quality);
  publish(claim, built);
  return built;
}

}  // namespace tessera
