#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/math/transform.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/surface_sampler.h"
#include "renderer/shapes/triangle_mesh.h"
#include "renderer/shapes/triangle_tree.h"

namespace tessera {

/// Triangles to choose from, in their own frame. Immutable once made; shared by all places where
/// they stand.
class TriangleSet {
 public:
  /// Those of `mesh` that have an area and whose face material is `material`, with a tree where
  /// there are enough to choose from. Of triangles with the same corners, by whatever turn, hits
  /// tell the first alone, and so does the set: if `has_backs`, of those that face the other way
  /// too.
  static TriangleSet of(const TriangleMesh& mesh, uint32_t material, bool has_backs = true);
  /// If it has an area. Without a tree hits need not tell it apart.
  void add(const TriangleCorners& corners) { add(corners, 0); }
  bool empty() const { return corners_.empty(); }
  double area() const { return sums_.empty() ? 0 : sums_.back(); }
  const Bounds3& bounds() const { return bounds_; }

  /// What `u`, uniform in [0, 1), picks as seen from view_of(), all where there is no tree; what is
  /// left of the number goes back into it. Not of an empty set.
  template <typename ViewOf>
  TriangleTree::Part pick(const ViewOf& view_of, double& u) const {
    return tree_ ? tree_->pick(view_of(), u) : all();
  }
  /// Of what pick() may pick that which holds the triangle that hits tell as `primitive`; nothing
  /// where it is not of the set.
  template <typename ViewOf>
  std::optional<TriangleTree::Part> holding(const ViewOf& view_of, uint32_t primitive) const {
    if (!tree_) return all();
    const auto place = place_of(primitive);
    return place ? std::optional(tree_->holding(view_of(), *place)) : std::nullopt;
  }
  /// The triangle of a part, which is not empty, that `u.x` chooses by area; what is left of the
  /// number goes back into it.
  const TriangleCorners& choose(const TriangleTree::Part& part, Vec2& u) const;

 private:
  /// `primitive`, in ascending order, is how hits tell it.
  void add(const TriangleCorners& corners, uint32_t primitive);
  void plant();
  TriangleTree::Part all() const { return {.to = corners_.size(), .area = area()}; }
  /// Where it stands in the tree's order; nothing where it was not added. Only where there is one.
  std::optional<size_t> place_of(uint32_t primitive) const;

  std::vector<TriangleCorners> corners_;
  std::vector<double> sums_;  ///< of areas up to and with each
  Bounds3 bounds_;
  std::vector<uint32_t> primitives_;  ///< as they were added
  std::vector<uint32_t> places_;      ///< of each primitive, where there is a tree
  std::optional<TriangleTree> tree_;
};

/// Which sides of a surface emit light.
enum class LitSides : uint8_t { both, front, back };

/// Samples the triangles with such sides. Null where there are none.
std::unique_ptr<const SurfaceSampler> make_triangle_sampler(
    std::shared_ptr<const TriangleSet> triangles, const Transform& world_from_object,
    bool flip_normals, LitSides sides = LitSides::both);

}  // namespace tessera
