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

/// Picks triangles of a shining surface by what they can bring to a point: area by the cosine at
/// the triangle (of a cone of normals) and that at the point, over the square of the distance, from
/// the root of a tree of halves downwards (Conty Estevez and Kulla 2018, "Importance Sampling of
/// Many Lights with Adaptive Tree Splitting", without the splitting). What is far and about flat is
/// left whole, to be chosen from by area. Immutable; thread-safe; does not allocate once built.
class TriangleTree {
 public:
  /// Of `triangles`, at least one, which have those areas, above 0. `order` becomes theirs in the
  /// tree: what it picks are places in it.
  TriangleTree(std::span<const TriangleCorners> triangles, std::span<const double> areas,
               std::vector<uint32_t>& order);

  /// From where they are seen.
  struct View {
    Point3 from;      ///< in the triangles' frame
    Vec3 normal;      ///< unit, of what is lit, in the frame in which lengths are measured
    double side = 0;  ///< 1: fronts shine, where corners are counter-clockwise; -1: backs; 0: both
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
  struct Node {
    Point3 center;
    double reach = 0;   ///< half the radius of a ball about it: most lies as near to the centre
    Vec3 axis;          ///< unit, of a cone about all normals
    double spread = 0;  ///< the sine of the cone's angle; 1 where that is a right one or more
    double area = 0;
  };
  /// It is worth `over` / `under`.
  struct Seen {
    double over, under;
    bool is_even;  ///< any of it is worth about as much by area
  };
  void build(std::span<const TriangleCorners> triangles, std::span<const double> areas,
             std::span<const Vec3> normals, std::span<uint32_t> order);
  static Seen seen_from(const View& view, const Node& node);
  template <typename GoesFirst>
  Part descend(const View& view, const GoesFirst& goes_first) const;

  /// Each is followed by those of its first half, then by those of its second.
  std::vector<Node> nodes_;
};

}  // namespace tessera
