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
  /// there are enough to choose from.
  static TriangleSet of(const TriangleMesh& mesh, uint32_t material);
  /// The one that a shape's hits tell as `primitive`, in ascending order, if it has an area.
  void add(const TriangleCorners& corners, uint32_t primitive);
  bool empty() const { return corners_.empty(); }
  double area() const { return sums_.empty() ? 0 : sums_.back(); }
  const Bounds3& bounds() const { return bounds_; }

  /// Null: they are to be chosen by area alone.
  const TriangleTree* tree() const { return tree_ ? &*tree_ : nullptr; }
  /// All of them.
  TriangleTree::Part all() const { return {.to = corners_.size(), .area = area()}; }
  /// The triangle of a part, which is not empty, that `u.x` chooses by area; what is left of the
  /// number goes back into it.
  const TriangleCorners& choose(const TriangleTree::Part& part, Vec2& u) const;
  /// Where `primitive` stands in the tree's order; nothing where it was not added.
  std::optional<size_t> place_of(uint32_t primitive) const;

 private:
  void plant();

  std::vector<TriangleCorners> corners_;
  std::vector<double> sums_;  ///< of areas up to and with each
  Bounds3 bounds_;
  std::vector<uint32_t> primitives_;  ///< as they were added
  std::vector<uint32_t> places_;      ///< of each primitive, where there is a tree
  std::optional<TriangleTree> tree_;
};

/// Which sides of a surface shine.
enum class LitSides : uint8_t { both, front, back };

/// Of triangles of which those sides shine. Null where there are none.
std::unique_ptr<const SurfaceSampler> make_triangle_sampler(
    std::shared_ptr<const TriangleSet> triangles, const Transform& world_from_object,
    bool flip_normals, LitSides sides = LitSides::both);

}  // namespace tessera
