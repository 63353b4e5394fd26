#include "renderer/shapes/mesh_boundary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/math/bounds.h"
#include "renderer/math/elementary.h"
#include "renderer/shapes/projected_edge.h"

namespace tessera {
namespace {

constexpr double kSphere = 4 * std::numbers::pi;

/// A sum of angles as the complex number whose argument it is, but for whole turns, so that one arc
/// tangent is enough for all of them.
class AngleSum {
 public:
  /// Adds the argument of x + iy, from -pi to pi; of 0 nothing.
  void add(double x, double y) {
    const double real = real_ * x - imaginary_ * y, imaginary = real_ * y + imaginary_ * x;
    const double size = std::abs(real) + std::abs(imaginary);
    if (size == 0) return;
    // Two angles of one sign that together have the other make more than half a turn.
    const bool is_below = std::signbit(y);
    if (std::signbit(imaginary_) == is_below && std::signbit(imaginary) != is_below)
      turns_ += is_below ? -1 : 1;
    real_ = real / size;
    imaginary_ = imaginary / size;
  }
  double value() const {
    return portable::atan2(imaginary_, real_) + 2 * std::numbers::pi * turns_;
  }

 private:
  double real_ = 1, imaginary_ = 0;
  int turns_ = 0;
};

/// The solid angles that triangles fill as seen from the origin of a ray that go from an edge to
/// the point endlessly far behind it.
class StripAngles {
 public:
  explicit StripAngles(const Ray& ray)
      : frame_(ray), origin_(ray.origin), along_(normalize(ray.direction)) {
    // Where edge_side() moves what is right on the ray.
    Vec3 aside;
    aside[frame_.kx] = -1;
    aside_ = aside - dot(aside, along_) * along_;
  }

  /// A point as the ray has it.
  struct Seen {
    ProjectedVertex projected;
    Vec3 across;        ///< of the vector to it what is at right angles to the ray
    double behind = 0;  ///< its length less what of it is along the ray
  };
  Seen seen(const Point3& point) const {
    const Vec3 v = point - origin_;
    const double along = dot(v, along_), whole = length(v);
    const Vec3 across = v - along * along_;
    const double squared = length_squared(across);
    const ProjectedVertex projected = project(frame_, point);
    if (along > 0 && squared == 0) return {projected, aside_, 0};
    return {projected, across, along > 0 ? squared / (whole + along) : whole - along};
  }

  /// Adds half of that of the edge from `a` to `b`, by van Oosterom and Strackee 1983, without
  /// differences that cancel. On which side of the edge the ray passes is decided as for triangles,
  /// so that it fits their crossings.
  void add_half(const Seen& a, const Seen& b, AngleSum& sum) const {
    const int side = edge_side(a.projected, b.projected);
    if (side == 0) return;
    const double volume = dot(along_, cross(b.across, a.across));
    sum.add(a.behind * b.behind + dot(a.across, b.across), std::copysign(volume, side));
  }

 private:
  TriangleRay frame_;
  Point3 origin_;
  Vec3 along_, aside_;
};

/// Of the fan of triangles from the center to the loop through the points and back.
struct Fan {
  Vec3 area;             ///< across its mean direction
  double most_area = 0;  ///< of all triangles together
};

Fan fan_of(const Point3* begin, const Point3* end, const Point3& center) {
  Fan fan;
  for (const Point3* p = begin; p != end; ++p) {
    const Point3& next = p + 1 == end ? *begin : p[1];
    const Vec3 area = cross(*p - center, next - center) / 2;
    fan.area = fan.area + area;
    fan.most_area += length(area);
  }
  return fan;
}

}  // namespace

MeshBoundary::MeshBoundary(const TriangleMesh& mesh) : edges_(open_edges(mesh)) {
  std::vector<Loop> loops = make_loops(mesh);
  if (!loops.empty()) build_loops(loops, 0, loops.size());
}

std::vector<MeshBoundary::Loop> MeshBoundary::make_loops(const TriangleMesh& mesh) {
  // As each triangle comes to each corner and leaves it, open edges do so too.
  std::vector<OpenEdge> by_from = edges_;
  std::stable_sort(by_from.begin(), by_from.end(),
                   [](const OpenEdge& a, const OpenEdge& b) { return a.from < b.from; });
  std::vector<bool> used(by_from.size());
  const auto next_from = [&](uint32_t vertex) {
    auto at = std::lower_bound(by_from.begin(), by_from.end(), vertex,
                               [](const OpenEdge& edge, uint32_t v) { return edge.from < v; });
    while (at != by_from.end() && at->from == vertex &&
           used[static_cast<size_t>(at - by_from.begin())])
      ++at;
    return static_cast<size_t>(at - by_from.begin());
  };
  std::vector<Loop> loops;
  for (size_t i = 0; i < by_from.size(); ++i) {
    if (used[i]) continue;
    const uint32_t start = by_from[i].from;
    Loop loop{static_cast<uint32_t>(points_.size()), 0, {}};
    points_.push_back(mesh.vertex(start));
    for (uint32_t vertex = start;;) {
      const size_t edge = next_from(vertex);
      used[edge] = true;
      vertex = by_from[edge].to;
      points_.push_back(mesh.vertex(vertex));
      if (vertex == start) break;
    }
    loop.last = static_cast<uint32_t>(points_.size() - 1);
    Bounds3 box;
    for (uint32_t p = loop.first; p < loop.last; ++p) box.extend(points_[p]);
    loop.center = box.center();
    loops.push_back(loop);
  }
  return loops;
}

void MeshBoundary::build_loops(std::vector<Loop>& loops, size_t begin, size_t end) {
  if (end - begin == 1) return build_chain(loops[begin].first, loops[begin].last);
  const size_t self = nodes_.size();
  nodes_.emplace_back();
  Bounds3 centers;
  for (size_t i = begin; i < end; ++i) centers.extend(loops[i].center);
  const Vec3 d = centers.diagonal();
  const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  const size_t middle = begin + (end - begin) / 2;
  const auto at = [&](size_t i) { return loops.begin() + static_cast<ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [axis](const Loop& a, const Loop& b) {
    return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.first < b.first;
  });
  build_loops(loops, begin, middle);
  const size_t second = nodes_.size();
  build_loops(loops, middle, end);
  Node& node = nodes_[self];
  Bounds3 box;
  for (const size_t child : {self + 1, second}) {
    const Vec3 r{nodes_[child].radius, nodes_[child].radius, nodes_[child].radius};
    box.extend(nodes_[child].center - r);
    box.extend(nodes_[child].center + r);
    node.area = node.area + nodes_[child].area;
  }
  node.center = box.center();
  for (const size_t child : {self + 1, second}) node.most_area += nodes_[child].most_area;
  for (const size_t child : {self + 1, second})
    node.radius =
        std::max(node.radius, length(nodes_[child].center - node.center) + nodes_[child].radius);
  node.end = static_cast<uint32_t>(nodes_.size());
}

void MeshBoundary::build_chain(uint32_t first, uint32_t last) {
  constexpr uint32_t kEdgesOfLeaf = 4;
  const size_t self = nodes_.size();
  Node node;
  node.first = first;
  node.last = last;
  node.is_leaf = last - first <= kEdgesOfLeaf;
  Bounds3 box;
  for (uint32_t p = first; p <= last; ++p) box.extend(points_[p]);
  node.center = box.center();
  for (uint32_t p = first; p <= last; ++p)
    node.radius = std::max(node.radius, length(points_[p] - node.center));
  const Fan fan = fan_of(points_.data() + first, points_.data() + last + 1, node.center);
  node.area = fan.area;
  node.most_area = fan.most_area;
  nodes_.push_back(node);
  if (!node.is_leaf) {
    const uint32_t middle = first + (last - first) / 2;
    build_chain(first, middle);
    build_chain(middle, last);
  }
  nodes_[self].end = static_cast<uint32_t>(nodes_.size());
}

MeshBoundary::Angle MeshBoundary::angle(const Ray& ray, double may_miss) const {
  if (nodes_.empty()) return {};
  constexpr double kFar = 2.5;
  const StripAngles strips(ray);
  const Vec3 along = normalize(ray.direction);
  AngleSum half;
  double dipoles = 0;
  double left = may_miss;
  uint32_t last = 0;
  StripAngles::Seen seen_last = strips.seen(points_[last]);
  // What came before mostly ended where this begins.
  const auto see = [&](uint32_t point) {
    return point == last ? seen_last : strips.seen(points_[point]);
  };
  for (uint32_t i = 0; i < nodes_.size();) {
    const Node& node = nodes_[i];
    const Vec3 to_center = node.center - ray.origin;
    const double squared = length_squared(to_center), ahead = dot(to_center, along);
    const double near = kFar * node.radius;
    // A loop that the ray goes through is no dipole: it is seen from behind, all of the sphere but
    // the loop.
    const bool is_passed = ahead <= 0 || squared - ahead * ahead > 1.01 * node.radius * node.radius;
    const bool is_whole = points_[node.first] == points_[node.last];
    bool is_far = is_passed && squared > near * near;
    if (is_far) {
      dipoles += dot(node.area, to_center) / (squared * std::sqrt(squared));
    } else if (is_passed && left > 0 && squared > node.radius * node.radius) {
      const double gap = std::sqrt(squared) - node.radius, most = node.most_area / (gap * gap);
      is_far = most <= left / 2;
      if (is_far) left -= most;
    }
    if (is_far) {
      if (!is_whole) {
        const StripAngles::Seen first = see(node.first);
        last = node.last;
        seen_last = strips.seen(points_[last]);
        strips.add_half(first, seen_last, half);
      }
      i = node.end;
      continue;
    }
    if (node.is_leaf) {
      seen_last = see(node.first);
      for (last = node.first; last < node.last; ++last) {
        const StripAngles::Seen next = strips.seen(points_[last + 1]);
        strips.add_half(seen_last, next, half);
        seen_last = next;
      }
    }
    ++i;
  }
  return {dipoles + 2 * half.value(), may_miss - left};
}

double MeshBoundary::winding_number(const Ray& ray, int crossing_number) const {
  // Strips from the open edges away from where the ray goes close the mesh without crossing the
  // ray. It goes around its origin as often as the ray leaves it; the strips take their share off.
  return angle(ray, 0).sum / kSphere - crossing_number;
}

bool MeshBoundary::goes_around(const Ray& ray, int crossing_number) const {
  if (nodes_.empty()) return crossing_number != 0;
  constexpr double kMayMiss = 0.4, kRounding = 0.01;
  const Angle found = angle(ray, kMayMiss * kSphere);
  const double about = std::abs(found.sum / kSphere - crossing_number);
  const bool is_sure = std::abs(about - 0.5) > found.missed / kSphere + kRounding;
  if (found.missed == 0 || is_sure) return about > 0.5;
  return std::abs(winding_number(ray, crossing_number)) > 0.5;
}

}  // namespace tessera
