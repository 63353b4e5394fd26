#include "renderer/shapes/triangle_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "renderer/math/elementary.h"
#include "renderer/math/warp.h"
#include "renderer/shapes/area_density.h"

namespace tessera {

namespace {

/// About how much longer a map makes what it maps: the root of the mean square over all directions.
double stretch_of(const Affine& m) {
  double sum = 0;
  for (const auto& row : m.m) sum += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
  return std::sqrt(sum / 3);
}
/// Whether it keeps all angles: all columns are as long, and square to each other.
bool is_similarity(const Affine& m) {
  Vec3 axes[3];
  for (size_t c = 0; c < 3; ++c) axes[c] = {m.m[0][c], m.m[1][c], m.m[2][c]};
  const double squared = length_squared(axes[0]), tolerance = 1e-9 * squared;
  for (int a = 0; a < 3; ++a) {
    if (!(std::abs(length_squared(axes[a]) - squared) <= tolerance)) return false;
    if (!(std::abs(dot(axes[a], axes[(a + 1) % 3])) <= tolerance)) return false;
  }
  return true;
}
double side_of(LitSides sides) {
  if (sides == LitSides::both) return 0;
  return sides == LitSides::front ? 1 : -1;
}

/// Which triangles lie where others do that come before them; of those that face the same way, or
/// `either_way`.
std::vector<bool> behind_others(const TriangleMesh& mesh, bool either_way) {
  using Key = std::array<std::array<float, 3>, 3>;
  std::vector<std::pair<Key, uint32_t>> keys(mesh.triangles.size());
  for (uint32_t i = 0; i < keys.size(); ++i) {
    auto& [key, number] = keys[i];
    number = i;
    for (size_t corner = 0; corner < 3; ++corner) {
      const Float3& p = mesh.positions[mesh.triangles[i][corner]];
      key[corner] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};  // no -0
    }
    std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
    if (either_way && key[2] < key[1]) std::swap(key[1], key[2]);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<bool> behind(keys.size());
  for (size_t i = 1; i < keys.size(); ++i)
    behind[keys[i].second] = keys[i].first == keys[i - 1].first;
  return behind;
}

/// By area in the triangles' own frame within what the tree picks; a transform that is no
/// similarity spreads them unevenly.
class TriangleSampler final : public SurfaceSampler {
 public:
  TriangleSampler(std::shared_ptr<const TriangleSet> triangles, const Transform& to_world,
                  bool flip, LitSides sides)
      : triangles_(std::move(triangles)),
        to_world_(to_world),
        side_(flip != (to_world.matrix().determinant() < 0) ? -1 : 1),
        lit_side_(flip ? -side_of(sides) : side_of(sides)),
        is_similar_(is_similarity(to_world.matrix())),
        growth_(portable::pow(std::abs(to_world.matrix().determinant()), 2.0 / 3)),
        stretch_(stretch_of(to_world.matrix())) {}

  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override {
    Vec2 rest = u;
    const TriangleTree::Part part = triangles_->pick([&] { return view(from); }, rest.x);
    const auto& [p, q, r] = triangles_->choose(part, rest);
    const Point3 a = to_world_.point(p), b = to_world_.point(q), c = to_world_.point(r);
    const Vec2 w = triangle_point(rest);
    sample.point = a + (b - a) * w.x + (c - a) * w.y;
    sample.point_error = rounding_of(sample.point, length(b - a) + length(c - a));
    const Vec3 across = cross(b - a, c - a);
    if (!(length_squared(across) > 0)) return 0;  // flat once it is placed
    sample.normal = normalize(across) * side_;
    return density_in(part, from.at, sample.point, sample.normal);
  }
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t primitive) const override {
    const auto part = triangles_->holding([&] { return view(from); }, primitive);
    return part ? density_in(*part, from.at, there, normal) : 0;
  }
  /// About, where the transform is no similarity.
  double area() const override { return std::max(triangles_->area() * growth_, 1e-300); }
  Bounds3 bounds() const override { return to_world_.bounds(triangles_->bounds()); }

 private:
  TriangleTree::View view(const LitPoint& from) const {
    TriangleTree::View view{.from = from.at, .normal = from.normal, .side = lit_side_};
    if (to_world_.is_identity()) return view;
    view.from = to_world_.inverse_point(from.at);
    if (is_similar_) {
      view.normal = normalize(to_world_.inverse_vector(from.normal));
    } else {
      view.measure = &to_world_.matrix();
      view.stretch = stretch_;
    }
    return view;
  }
  /// Of a point of that part. Extremes of size leave none.
  double density_in(const TriangleTree::Part& part, const Point3& from, const Point3& there,
                    const Vec3& normal) const {
    const double growth = is_similar_ ? growth_ : area_growth(to_world_.matrix(), normal);
    const double area = part.area / part.probability;
    const double density = density_by_area(area * growth, from, there, normal);
    return std::isfinite(density) ? density : 0;
  }

  std::shared_ptr<const TriangleSet> triangles_;
  Transform to_world_;
  double side_;
  double lit_side_;  ///< TriangleTree::View::side
  bool is_similar_;
  double growth_;  ///< of areas; about, where it is no similarity
  double stretch_;
};

}  // namespace

std::unique_ptr<const SurfaceSampler> make_triangle_sampler(
    std::shared_ptr<const TriangleSet> triangles, const Transform& world_from_object,
    bool flip_normals, LitSides sides) {
  if (triangles->empty()) return nullptr;
  return std::make_unique<TriangleSampler>(std::move(triangles), world_from_object, flip_normals,
                                           sides);
}

TriangleSet TriangleSet::of(const TriangleMesh& mesh, uint32_t material, bool has_backs) {
  TriangleSet set;
  const std::vector<bool> is_behind = behind_others(mesh, has_backs);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (is_behind[i]) continue;
    if ((mesh.face_materials.empty() ? 0 : mesh.face_materials[i]) != material) continue;
    set.add(mesh.corners(i), static_cast<uint32_t>(i));
  }
  constexpr size_t kEnough = 4;
  if (set.corners_.size() >= kEnough) set.plant();
  return set;
}

void TriangleSet::add(const TriangleCorners& corners, uint32_t primitive) {
  const auto& [a, b, c] = corners;
  const double size = length(cross(b - a, c - a)) / 2;
  if (!(size > 0) || !std::isfinite(area() + size)) return;
  corners_.push_back(corners);
  primitives_.push_back(primitive);
  sums_.push_back(area() + size);
  for (const Point3& p : corners) bounds_.extend(p);
}

void TriangleSet::plant() {
  std::vector<double> areas;
  areas.reserve(corners_.size());
  for (const auto& [a, b, c] : corners_) areas.push_back(length(cross(b - a, c - a)) / 2);
  std::vector<uint32_t> order;
  tree_.emplace(corners_, areas, order);
  std::vector<TriangleCorners> ordered;
  ordered.reserve(corners_.size());
  places_.resize(corners_.size());
  double sum = 0;
  for (const uint32_t i : order) {
    places_[i] = static_cast<uint32_t>(ordered.size());
    sums_[ordered.size()] = sum += areas[i];
    ordered.push_back(corners_[i]);
  }
  corners_ = std::move(ordered);
}

const TriangleCorners& TriangleSet::choose(const TriangleTree::Part& part, Vec2& u) const {
  if (part.to - part.from == 1) return corners_[part.from];
  const auto at = [&](size_t place) { return sums_.begin() + static_cast<std::ptrdiff_t>(place); };
  const double before = part.from == 0 ? 0 : sums_[part.from - 1];
  const double wanted = before + u.x * (sums_[part.to - 1] - before);
  const auto found = std::upper_bound(at(part.from), at(part.to - 1), wanted);
  const double below = found == sums_.begin() ? 0 : *(found - 1);
  u.x = *found > below ? std::clamp((wanted - below) / (*found - below), 0.0, 0x1.fffffffffffffp-1)
                       : 0;
  return corners_[static_cast<size_t>(found - sums_.begin())];
}

std::optional<size_t> TriangleSet::place_of(uint32_t primitive) const {
  // So many were left out, at most, before it.
  const size_t count = primitives_.size(), left_out = primitives_.back() + size_t{1} - count;
  const size_t first = primitive > left_out ? primitive - left_out : 0;
  const auto at = [&](size_t i) {
    return primitives_.begin() + static_cast<std::ptrdiff_t>(std::min(i, count));
  };
  const auto found = std::lower_bound(at(first), at(size_t{primitive} + 1), primitive);
  if (found == primitives_.end() || *found != primitive) return std::nullopt;
  return places_[static_cast<size_t>(found - primitives_.begin())];
}

}  // namespace tessera
