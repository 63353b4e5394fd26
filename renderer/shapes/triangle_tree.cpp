#include "renderer/shapes/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "renderer/math/bounds.h"
#include "renderer/shapes/light_halves.h"

namespace tessera {

class TriangleTree::Builder {
 public:
  Builder(TriangleTree& tree, std::span<const TriangleCorners> triangles,
          std::span<const double> areas)
      : tree_(tree), triangles_(triangles), areas_(areas) {
    normals_.reserve(triangles.size());
    for (const auto& [a, b, c] : triangles) normals_.push_back(normalize(cross(b - a, c - a)));
  }

  void build(std::span<uint32_t> order) {
    tree_.all_ = bounds_of(order);
    add_node(order);
  }

 private:
  uint32_t add_node(std::span<uint32_t> order) {
    const size_t at = tree_.nodes_.size();
    tree_.nodes_.push_back({});
    tree_.areas_.push_back({});
    halve_into(order, kHalves);
    for (size_t child = 0; child < kChildren; ++child) {
      const auto [from, to] = child_of({0, order.size()}, child);
      set_child(at, child, order.subspan(from, to - from));
    }
    return static_cast<uint32_t>(at);
  }
  void halve_into(std::span<uint32_t> order, size_t times) {
    if (times == 0 || order.size() < 2) return;
    halve(order, [&](uint32_t i) {
      const auto& [a, b, c] = triangles_[i];
      return a + ((b - a) + (c - a)) / 3;
    });
    halve_into(order.first(order.size() / 2), times - 1);
    halve_into(order.subspan(order.size() / 2), times - 1);
  }
  void set_child(size_t at, size_t child, std::span<uint32_t> order) {
    tree_.nodes_[at].next[child] = kNone;
    if (order.empty()) return;
    const Bounded bounded = bounds_of(order);
    tree_.areas_[at][child] = bounded.area;
    Node& node = tree_.nodes_[at];
    const Vec3 center = (bounded.center - tree_.all_.center) / tree_.all_.radius;
    for (int axis = 0; axis < 3; ++axis) {
      node.center[axis][child] = static_cast<float>(center[axis]);
      node.normal[axis][child] = static_cast<float>(bounded.mean_normal[axis]);
    }
    node.reach[child] = static_cast<float>(bounded.radius / 2 / tree_.all_.radius);
    node.spread[child] = static_cast<float>(bounded.spread);
    node.area[child] = static_cast<float>(bounded.area / tree_.all_.area);
    if (order.size() < 2) return;
    const uint32_t next = add_node(order);
    tree_.nodes_[at].next[child] = next;
  }
  Bounded bounds_of(std::span<const uint32_t> order) const {
    Bounds3 box;
    Vec3 sum;
    Bounded bounded;
    for (const uint32_t i : order) {
      for (const Point3& corner : triangles_[i]) box.extend(corner);
      sum = sum + normals_[i] * areas_[i];
      bounded.area += areas_[i];
    }
    bounded.center = box.center();
    bounded.radius = length(box.diagonal()) / 2;
    bounded.mean_normal = sum / bounded.area;
    bounded.spread = std::max(1 - length_squared(bounded.mean_normal), 0.0) / 4;
    return bounded;
  }

  TriangleTree& tree_;
  std::span<const TriangleCorners> triangles_;
  std::span<const double> areas_;
  std::vector<Vec3> normals_;
};

TriangleTree::TriangleTree(std::span<const TriangleCorners> triangles,
                           std::span<const double> areas, std::vector<uint32_t>& order)
    : count_(triangles.size()) {
  order.resize(triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  Builder(*this, triangles, areas).build(order);
}

inline TriangleTree::Range TriangleTree::child_of(const Range& range, size_t child) {
  auto [from, to] = range;
  for (size_t bit = kChildren / 2; bit > 0; bit /= 2) {
    const size_t middle = from + (to - from) / 2;
    ((child & bit) != 0 ? from : to) = middle;
  }
  return {from, to};
}

/// With estimates of both cosines, times the distance: at the point that of the middle, and half
/// the radius; at the surface what the mean of the normals m, in a direction where it is t, tells
/// of the mean of what of their cosines is above 0: (t + sqrt(t^2 + (1 - m^2) / 4)) / 2, which is
/// right for one normal and for those of a whole ball. `from` is in the nodes' frame. kMeasured:
/// where there is View::measure. Written for compilers that work out several children at once.
template <bool kMeasured>
inline void TriangleTree::look(const View& view, const Vec3& from, const Node& node, Seen& seen) {
  // What is turned away keeps some of its worth: these are estimates, surfaces may let light
  // through, and their normals may not be the true ones.
  constexpr float kAway = 0.02f, kLeastSquare = 1e-30f;
  const auto likely = [](float estimate, float distance) {
    const float least = kAway * distance, some = estimate > least ? estimate : least;
    return some < distance ? some : distance;
  };
  const auto to_float = [](double x) { return static_cast<float>(x); };
  const float x0 = to_float(from.x), y0 = to_float(from.y), z0 = to_float(from.z);
  const float nx = to_float(view.normal.x), ny = to_float(view.normal.y),
              nz = to_float(view.normal.z);
  const float side = to_float(view.side), sides = view.side == 0 ? 1.0f : 0.5f;
  float m[3][3] = {};
  if constexpr (kMeasured) {
    for (size_t row = 0; row < 3; ++row)
      for (size_t column = 0; column < 3; ++column)
        m[row][column] = to_float(view.measure->m[row][column] / view.stretch);
  }
  for (size_t i = 0; i < kChildren; ++i) {
    const float x = node.center[0][i] - x0, y = node.center[1][i] - y0, z = node.center[2][i] - z0;
    const float reach = node.reach[i], in_reach = reach * reach + kLeastSquare;
    const float squared = x * x + y * y + z * z + in_reach, distance = std::sqrt(squared);
    const float across = x * node.normal[0][i] + y * node.normal[1][i] + z * node.normal[2][i];
    const float steep = std::sqrt(across * across + node.spread[i] * squared);
    const float facing = likely(sides * (steep - across * side) + reach, distance);
    // Area times distance times the cosine at the surface is a volume: the map makes each as much
    // larger. The rest goes by distances as they are measured.
    float px = x, py = y, pz = z, placed_squared = squared, placed = distance;
    if constexpr (kMeasured) {
      px = m[0][0] * x + m[0][1] * y + m[0][2] * z;
      py = m[1][0] * x + m[1][1] * y + m[1][2] * z;
      pz = m[2][0] * x + m[2][1] * y + m[2][2] * z;
      placed_squared = px * px + py * py + pz * pz + in_reach;
      placed = std::sqrt(placed_squared);
    }
    const float lit = likely(px * nx + py * ny + pz * nz + reach, placed);
    seen.worth[i] = node.area[i] * (facing * lit / placed_squared) / placed_squared;
    seen.squared[i] = placed_squared;
  }
}

template <typename Choose>
inline TriangleTree::Part TriangleTree::descend(const View& view, const Choose& choose) const {
  // In reaches, and what normals within about 30 degrees have: finer parts cost more than their
  // noise.
  constexpr double kFar = 3, kNarrow = 0.03;
  const auto is_even = [](double squared, double reach, double spread) {
    return spread < kNarrow && squared > kFar * kFar * reach * reach;
  };
  const Vec3 from = (view.from - all_.center) / all_.radius;
  Range range{0, count_};
  Part part{.to = count_, .area = all_.area};
  if (is_even(length_squared(from) + 0.25, 0.5, all_.spread)) return part;
  for (uint32_t at = 0; at != kNone;) {
    const Node& node = nodes_[at];
    Seen seen;
    if (view.measure) {
      look<true>(view, from, node, seen);
    } else {
      look<false>(view, from, node, seen);
    }
    // None is given up for good. Extremes of distance may leave no number: then all alike.
    constexpr double kLeast = 1e-4;
    double sum = 0;
    for (const float worth : seen.worth) sum += worth;
    const bool has_sum = sum > 0 && sum < std::numeric_limits<double>::infinity();
    const double scale = has_sum ? (1 - kChildren * kLeast) / sum : 0;
    std::array<double, kChildren> shares;
    for (size_t i = 0; i < kChildren; ++i) shares[i] = seen.worth[i] * scale + kLeast;
    if (range.to - range.from < kChildren || !has_sum) share_again(range, has_sum, shares);
    const size_t child = choose(shares, range);
    range = child_of(range, child);
    part.probability *= shares[child];
    part.area = areas_[at][child];
    const bool ends = is_even(seen.squared[child], node.reach[child], node.spread[child]);
    at = ends ? kNone : node.next[child];
  }
  part.from = range.from, part.to = range.to;
  return part;
}

/// None of it to parts without triangles.
void TriangleTree::share_again(const Range& range, bool has_sum,
                               std::array<double, kChildren>& shares) {
  double sum = 0;
  for (size_t i = 0; i < kChildren; ++i) {
    const auto [from, to] = child_of(range, i);
    shares[i] = to == from ? 0 : has_sum ? shares[i] : 1;
    sum += shares[i];
  }
  for (double& share : shares) share /= sum;
}

TriangleTree::Part TriangleTree::pick(const View& view, double& u) const {
  return descend(view, [&](const std::array<double, kChildren>& shares, const Range&) {
    std::array<double, kChildren + 1> below{};
    for (size_t i = 0; i < kChildren; ++i) below[i + 1] = below[i] + shares[i];
    size_t child = 0;
    for (size_t i = 1; i < kChildren; ++i) child += u >= below[i];
    while (shares[child] == 0) --child;
    u = std::clamp((u - below[child]) / shares[child], 0.0, 0x1.fffffffffffffp-1);
    return child;
  });
}

TriangleTree::Part TriangleTree::holding(const View& view, size_t place) const {
  return descend(view, [&](const std::array<double, kChildren>&, const Range& range) {
    size_t child = 0;
    Range part = range;
    for (size_t bit = kChildren / 2; bit > 0; bit /= 2) {
      const size_t middle = part.from + (part.to - part.from) / 2;
      if (place >= middle) child |= bit;
      (place >= middle ? part.from : part.to) = middle;
    }
    return child;
  });
}

}  // namespace tessera
