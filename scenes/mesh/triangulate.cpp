#include "scenes/mesh/triangulate.h"

#include <cstddef>

namespace tessera {
namespace {

struct Flat {
  double x, y;
};

double turn(const Flat& a, const Flat& b, const Flat& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool same(const Flat& a, const Flat& b) { return a.x == b.x && a.y == b.y; }

/// Along the two axes in which the polygon is largest, counter-clockwise.
std::vector<Flat> flatten(std::span<const Vec3> corners, const Vec3& normal) {
  int drop = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(normal[a]) > std::abs(normal[drop])) drop = a;
  int u = (drop + 1) % 3, v = (drop + 2) % 3;
  if (normal[drop] < 0) std::swap(u, v);
  std::vector<Flat> flat;
  flat.reserve(corners.size());
  for (const Vec3& c : corners) flat.push_back({c[u], c[v]});
  return flat;
}

/// The ring of corners that are left, as a doubly linked list.
class EarClipper {
 public:
  explicit EarClipper(std::vector<Flat> points) : points_(std::move(points)) {
    const auto n = static_cast<uint32_t>(points_.size());
    next_.resize(n);
    previous_.resize(n);
    for (uint32_t i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
  }

  void clip(std::vector<CornerTriple>& out) {
    uint32_t left = static_cast<uint32_t>(points_.size());
    uint32_t at = 0;
    uint32_t looked_at = 0;
    while (left > 3) {
      // A whole round without an ear means that the polygon crosses itself: cut there regardless,
      // since a picture with one odd triangle is better than none.
      if (looked_at < left && !is_ear(at)) {
        at = next_[at];
        ++looked_at;
        continue;
      }
      out.push_back({previous_[at], at, next_[at]});
      next_[previous_[at]] = next_[at];
      previous_[next_[at]] = previous_[at];
      at = previous_[at];
      looked_at = 0;
      --left;
    }
    out.push_back({previous_[at], at, next_[at]});
  }

 private:
  bool is_ear(uint32_t i) const {
    const Flat &a = points_[previous_[i]], &b = points_[i], &c = points_[next_[i]];
    if (same(a, b) || same(b, c)) return true;  // a corner written twice is cut off first
    if (turn(a, b, c) <= 0) return false;
    for (uint32_t j = next_[next_[i]]; j != previous_[i]; j = next_[j]) {
      const Flat& p = points_[j];
      if (same(p, a) || same(p, b) || same(p, c)) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  std::vector<Flat> points_;
  std::vector<uint32_t> next_, previous_;
};

}  // namespace

Vec3 newell_normal(std::span<const Vec3> corners) {
  // Relative to the first corner: far from the origin the products would cancel.
  Vec3 sum{};
  for (size_t i = 1; i + 1 < corners.size(); ++i)
    sum = sum + cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return sum;
}

bool is_convex(std::span<const Vec3> corners, const Vec3& normal) {
  const size_t n = corners.size();
  // Where a corner is written twice no turn shows, so edges without length are passed over.
  Vec3 last{};
  for (size_t i = 0; i < 2 * n; ++i) {
    const Vec3 edge = corners[(i + 1) % n] - corners[i % n];
    if (edge == Vec3{}) continue;
    if (dot(cross(last, edge), normal) < 0) return false;
    last = edge;
  }
  return true;
}

void triangulate_fan(size_t corners, std::vector<CornerTriple>& out) {
  for (uint32_t i = 1; i + 1 < corners; ++i) out.push_back({0, i, i + 1});
}

bool triangulate(std::span<const Vec3> corners, std::vector<CornerTriple>& out) {
  const Vec3 normal = newell_normal(corners);
  if (corners.size() == 3 || is_convex(corners, normal)) {
    triangulate_fan(corners.size(), out);
    return true;
  }
  if (corners.size() > kMaxConcaveCorners) return false;
  EarClipper(flatten(corners, normal)).clip(out);
  return true;
}

}  // namespace tessera
