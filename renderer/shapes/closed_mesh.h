#pragma once

#include <memory>
#include <vector>

#include "renderer/shapes/solid.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// A triangle mesh that bounds a solid. Whether a line crosses a triangle is decided by the exact
/// signs of edge functions, an edge or vertex right on the line being moved aside the same way for
/// all triangles: so a line crosses each face of a closed mesh as often inward as outward, never
/// twice at a shared edge and never not at all. Primitives are triangles.
class ClosedMesh final : public Solid {
 public:
  /// Vertices at the same place count as one. A mesh that is inside out is turned. Throws Error
  /// where an edge lacks its neighbour on the other side, or no volume is enclosed.
  explicit ClosedMesh(std::shared_ptr<const TriangleMesh> mesh);

  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  size_t primitive_count() const override { return mesh_->triangles.size(); }
  void crossings(const Ray& ray, const RayError& error,
                 std::vector<SolidEvent>& events) const override;

 private:
  /// A tree of boxes in preorder for queries by whole lines.
  struct Node {
    Bounds3 bounds;
    uint32_t end = 0;               ///< one past the nodes below
    uint32_t first = 0, count = 0;  ///< triangles of a leaf, in order_
  };
  void build(uint32_t first, uint32_t last);
  /// Calls visit(triangle) for every triangle that the line may touch.
  template <typename Visit>
  void visit_near(const Ray& ray, const Visit& visit) const;

  std::shared_ptr<const TriangleMesh> mesh_;
  Bounds3 bounds_;
  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
  bool inside_out_ = false;
};

}  // namespace tessera
