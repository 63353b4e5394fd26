#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/math/transform.h"
#include "renderer/math/vec.h"

namespace tessera {

using TriangleCorners = std::array<Point3, 3>;

/// Picks triangles of an emissive surface by what they can bring to a point: area by the cosine at
/// the triangle and that at the point, over the square of the distance, from
/// the root of a tree downwards (Conty Estevez and Kulla 2018, "Importance Sampling of
/// Many Lights with Adaptive Tree Splitting", without the splitting). What is far and about flat is
/// left whole, to be chosen from by area. Immutable; thread-safe; does not allocate once built.
class TriangleTree {
 public:
  /// Of `triangles`, at least one, which have those areas, above 0. `order` becomes theirs in the
  /// tree: what it picks are places in it.
  TriangleTree(std::span<const TriangleCorners> triangles, std::span<const double> areas,
               std::vector<uint32_t>& order);

  /// The point that is lit, and how its frame relates to that of the triangles.
  struct View {
    Point3 from;      ///< in the triangles' frame
    Vec3 normal;      ///< unit, of what is lit, in the frame in which lengths are measured
    double side = 0;  ///< 1: fronts emit, where corners are counter-clockwise; -1: backs; 0: both
    const Affine* measure = nullptr;  ///< to that frame; null: it is the triangles' own
    double stretch = 1;               ///< about how much longer it makes what it maps
  };
  /// Neighbours in the order, to be chosen from by area.
  struct Part {
    size_t from = 0, to = 0;
    double area = 0;         ///< of them all, in the triangles' frame
    double probability = 1;  ///< with which they are picked; above 0
  };
  /// What `u`, uniform in [0, 1), picks; what is left of the number goes back into it.
  Part pick(const View& view, double& u) const;
  /// Of what pick() may pick that which holds the triangle at `place`.
  Part holding(const View& view, size_t place) const;

 private:
  static constexpr size_t kHalves = 3, kChildren = 1 << kHalves;
  static constexpr uint32_t kNone = ~0u;
  /// The three halvings of a range, a child in each part; those of fewer triangles have empty parts
  /// of area 0. In the frame in which the middle of all is the origin and the radius of all is 1.
  struct alignas(64) Node {
    float center[3][kChildren];
    /// Half the radius of a ball about it: most lies as near to the centre.
    float reach[kChildren];
    float normal[3][kChildren];  ///< the mean of the unit ones, by area
    float spread[kChildren];     ///< (1 - its square) / 4
    float area[kChildren];       ///< of all of 1
    uint32_t next[kChildren];    ///< kNone: no more than one triangle
  };
  struct Range {
    size_t from = 0, to = 0;
  };
  /// What is worked out of triangles side by side.
  struct Bounded {
    Point3 center;
    double radius = 0;
    Vec3 mean_normal;
    double spread = 0, area = 0;
  };
  /// Of a node's children: what each is worth, and where they are.
  struct Seen {
    float worth[kChildren], squared[kChildren];
  };
  class Builder;
  static Range child_of(const Range& range, size_t child);
  template <bool kMeasured>
  static void look(const View& view, const Vec3& from, const Node& node, Seen& seen);
  static void share_again(const Range& range, bool has_sum, std::array<double, kChildren>& shares);
  /// `choose(shares, range)` gives the child to go on with.
  template <typename Choose>
  Part descend(const View& view, const Choose& choose) const;

  Bounded all_;
  size_t count_;
  std::vector<Node> nodes_;
  std::vector<std::array<double, kChildren>> areas_;  ///< of the nodes' children
};

}  // namespace tessera
