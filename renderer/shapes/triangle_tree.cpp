#include "renderer/shapes/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "renderer/math/bounds.h"
#include "renderer/shapes/light_halves.h"

namespace tessera {

namespace {

/// Of what is bounded so, at that distance. What is turned away keeps some of it: bounds are rough,
/// surfaces may let light through, and their normals may not be the true ones.
double bounded(double bound, double distance) {
  constexpr double kAway = 0.02;
  return std::clamp(bound, kAway * distance, distance);
}

}  // namespace

TriangleTree::TriangleTree(std::span<const TriangleCorners> triangles,
                           std::span<const double> areas, std::vector<uint32_t>& order) {
  std::vector<Vec3> normals;
  normals.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) normals.push_back(normalize(cross(b - a, c - a)));
  order.resize(triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(2 * triangles.size() - 1);
  build(triangles, areas, normals, order);
}

void TriangleTree::build(std::span<const TriangleCorners> triangles, std::span<const double> areas,
                         std::span<const Vec3> normals, std::span<uint32_t> order) {
  Bounds3 box;
  Vec3 sum;
  Node node;
  for (const uint32_t i : order) {
    for (const Point3& corner : triangles[i]) box.extend(corner);
    sum = sum + normals[i] * areas[i];
    node.area += areas[i];
  }
  node.center = box.center();
  node.reach = length(box.diagonal()) / 4;
  node.axis = sum == Vec3{} ? normals[order[0]] : normalize(sum);
  double cosine = 1;
  for (const uint32_t i : order) cosine = std::min(cosine, dot(node.axis, normals[i]));
  node.spread = cosine > 0 ? std::sqrt(1 - cosine * cosine) : 1;
  nodes_.push_back(node);
  if (order.size() == 1) return;
  halve(order, [&](uint32_t i) {
    const auto& [a, b, c] = triangles[i];
    return a + ((b - a) + (c - a)) / 3;
  });
  build(triangles, areas, normals, order.first(order.size() / 2));
  build(triangles, areas, normals, order.subspan(order.size() / 2));
}

/// With bounds on both cosines, times the distance, that need no sines: cos(a - b) <= cos a + sin
/// b.
inline TriangleTree::Seen TriangleTree::seen_from(const View& view, const Node& node) {
  // In reaches, and about 17 degrees.
  constexpr double kFar = 6, kNarrow = 0.3;
  const auto is_even = [&](double squared, double reach) {
    return node.spread < kNarrow && squared > kFar * kFar * reach * reach;
  };
  const Vec3 way = node.center - view.from;
  const double squared = length_squared(way) + node.reach * node.reach;
  const double distance = std::sqrt(squared), across = dot(way, node.axis);
  const double towards = view.side == 0 ? std::abs(across) : -across * view.side;
  const double facing = bounded(towards + node.spread * distance + node.reach, distance);
  if (!view.measure) {
    const double lit = bounded(dot(way, view.normal) + node.reach, distance);
    return {node.area * facing * lit, squared * squared, is_even(squared, node.reach)};
  }
  // Area times distance times the cosine at the surface is a volume: the map makes each as much
  // larger. The rest goes by distances as they are measured.
  const Vec3 placed = (*view.measure)(way);
  const double reach = node.reach * view.stretch;
  const double placed_squared = length_squared(placed) + reach * reach;
  const double lit = bounded(dot(placed, view.normal) + reach, std::sqrt(placed_squared));
  return {node.area * facing * lit, placed_squared * placed_squared,
          is_even(placed_squared, reach)};
}

template <typename GoesFirst>
TriangleTree::Part TriangleTree::descend(const View& view, const GoesFirst& goes_first) const {
  Part part{.to = (nodes_.size() + 1) / 2};
  size_t at = 0;
  bool is_even = seen_from(view, nodes_[0]).is_even;
  while (!is_even && part.to - part.from > 1) {
    // As many triangles take twice as many nodes, less one.
    const size_t half = (part.to - part.from) / 2, first = at + 1, second = at + 2 * half;
    const Seen a = seen_from(view, nodes_[first]), b = seen_from(view, nodes_[second]);
    const double share = first_share(a.over * b.under, b.over * a.under);
    const bool is_first = goes_first(share, part.from + half);
    (is_first ? part.to : part.from) = part.from + half;
    part.probability *= is_first ? share : 1 - share;
    at = is_first ? first : second;
    is_even = is_first ? a.is_even : b.is_even;
  }
  part.area = nodes_[at].area;
  return part;
}

TriangleTree::Part TriangleTree::pick(const View& view, double& u) const {
  return descend(view, [&](double share, size_t) { return chooses_first(share, u); });
}

TriangleTree::Part TriangleTree::holding(const View& view, size_t place) const {
  return descend(view, [&](double, size_t second) { return place < second; });
}

}  // namespace tessera
