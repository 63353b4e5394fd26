#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "renderer/math/elementary.h"
#include "renderer/math/transform.h"
#include "scenes/formats/x3d/geometry/x3d_faces.h"

namespace tessera {
namespace {

/// The axes of the plane that the cross-section lies in at one point of the spine.
struct Section {
  Vec3 x, y, z;
};

bool is_null(const Vec3& v) { return !(length_squared(v) > 0); }

/// Whether the points end where they begin, but for what rounding makes of the sine and cosine of a
/// whole turn.
bool is_closed(const std::vector<Vec3>& points) {
  constexpr double kRounding = 1e-6;
  if (points.size() <= 2) return false;
  double size = 0;
  for (const Vec3& p : points) size = std::max(size, max_component(abs(p)));
  return max_component(abs(points.front() - points.back())) <= kRounding * size;
}

/// The turn that takes +y to `direction`.
Section turned_to(const Vec3& direction) {
  const Vec3 from{0, 1, 0}, to = normalize(direction);
  const Vec3 axis = cross(from, to);
  Affine turn;
  if (!is_null(axis))
    turn = rotation(axis, portable::acos(std::clamp(dot(from, to), -1., 1.)));
  else if (to.y < 0)
    turn = rotation({1, 0, 0}, 3.14159265358979323846);
  return {turn(Vec3{1, 0, 0}), turn(Vec3{0, 1, 0}), turn(Vec3{0, 0, 1})};
}

/// ISO/IEC 19775-1, 13.3.5.4: y along the spine, z along the normal of its bend.
class SpinePlanes {
 public:
  explicit SpinePlanes(const std::vector<Vec3>& spine) : spine_(spine), n_(spine.size()) {
    closed_ = is_closed(spine);
  }

  std::vector<Section> make() const {
    std::vector<Vec3> bends(n_);
    for (size_t i = 0; i < n_; ++i) bends[i] = bend(i);
    const auto bent = std::find_if_not(bends.begin(), bends.end(), is_null);
    if (bent == bends.end()) return std::vector<Section>(n_, turned_to(overall()));
    Vec3 last = *bent, along = overall();
    std::vector<Section> out;
    for (size_t i = 0; i < n_; ++i) {
      // Where the spine goes straight on, the plane goes with it.
      const bool straight = is_null(bends[i]) || (!closed_ && (i == 0 || i + 1 == n_));
      Vec3 z = straight ? last : bends[i];
      if (dot(z, last) < 0) z = -z;
      last = z;
      const Vec3 y = direction(i);
      if (!is_null(y)) along = normalize(y);
      const Vec3 x = cross(along, z);
      out.push_back(is_null(x) ? turned_to(along)
                               : Section{normalize(x), along, cross(normalize(x), along)});
    }
    return out;
  }

 private:
  const Vec3& before(size_t i) const {
    return i > 0 ? spine_[i - 1] : closed_ ? spine_[n_ - 2] : spine_[0];
  }
  const Vec3& after(size_t i) const {
    return i + 1 < n_ ? spine_[i + 1] : closed_ ? spine_[1] : spine_[n_ - 1];
  }
  Vec3 direction(size_t i) const { return after(i) - before(i); }

  /// Null where the spine does not bend.
  Vec3 bend(size_t i) const {
    const Vec3 a = after(i) - spine_[i], b = before(i) - spine_[i];
    const Vec3 z = cross(a, b);
    const bool some = length_squared(z) > 1e-12 * length_squared(a) * length_squared(b);
    return some ? normalize(z) : Vec3{};
  }

  /// Some direction of the spine, +y where it is a point.
  Vec3 overall() const {
    for (size_t i = 1; i < n_; ++i)
      if (!is_null(spine_[i] - spine_[0])) return normalize(spine_[i] - spine_[0]);
    return {0, 1, 0};
  }

  const std::vector<Vec3>& spine_;
  size_t n_;
  bool closed_ = false;
};

class Extruder {
 public:
  Extruder(const X3dNode& node, const X3dValues& values) : node_(node), values_(values) {
    section_ = list("crossSection", 2, {1, 1, 1, -1, -1, -1, -1, 1, 1, 1});
    scale_ = list("scale", 2, {1, 1});
    if (std::ranges::any_of(scale_, [](double scale) { return scale < 0; }))
      values.repair(node, "scale", "0 or more", "it is taken as it is");
    orientation_ = list("orientation", 4, {0, 0, 1, 0});
    const auto spine = list("spine", 3, {0, 0, 0, 0, 1, 0});
    for (size_t i = 0; i < spine.size(); i += 3)
      spine_.push_back({spine[i], spine[i + 1], spine[i + 2]});
    width_ = section_.size() / 2;
    if (width_ * spine_.size() > kMaxX3dPoints)
      throw values.document().error(
          node.offset,
          fmt::format("{} times {} points of {}", width_, spine_.size(), describe(node)),
          fmt::format("at most {}", kMaxX3dPoints));
    std::vector<Vec3> section;
    for (size_t j = 0; j < width_; ++j)
      section.push_back({section_[2 * j], 0, section_[2 * j + 1]});
    closed_ = is_closed(section);
  }

  X3dFaces make() {
    if (width_ < 2 || spine_.size() < 2) return {};
    add_points();
    add_uvs();
    add_sides();
    if (values_.boolean(node_, "beginCap", true)) add_cap(0, true);
    if (values_.boolean(node_, "endCap", true)) add_cap(spine_.size() - 1, false);
    return std::move(out_);
  }

 private:
  std::vector<double> list(const char* name, size_t width, std::vector<double> otherwise) const {
    return node_.field(name) ? values_.numbers(node_, name, width) : std::move(otherwise);
  }

  /// The i-th of a list of such values, or its last.
  static const double* value(const std::vector<double>& list, size_t width, size_t i) {
    return list.data() + width * std::min(i, list.size() / width - 1);
  }

  void add_points() {
    if (scale_.empty()) scale_ = {1, 1};
    if (orientation_.empty()) orientation_ = {0, 0, 1, 0};
    const auto planes = SpinePlanes(spine_).make();
    for (size_t i = 0; i < spine_.size(); ++i) {
      const double* scale = value(scale_, 2, i);
      const double* turn = value(orientation_, 4, i);
      const Vec3 axis{turn[0], turn[1], turn[2]};
      const double angle =
          std::fmod(turn[3] * values_.document().radians_per_unit(), 2 * std::numbers::pi);
      const Affine turned = is_null(axis) ? Affine{} : rotation(axis, angle);
      for (size_t j = 0; j < width_; ++j) {
        const Vec3 p = turned(Vec3{section_[2 * j] * scale[0], 0, section_[2 * j + 1] * scale[1]});
        const Section& s = planes[i];
        const Vec3 at = spine_[i] + s.x * p.x + s.y * p.y + s.z * p.z;
        for (int a = 0; a < 3; ++a) out_.points.push_back(static_cast<float>(at[a]));
      }
    }
  }

  /// Shares of the way along the cross-section and along the spine.
  void add_uvs() {
    const auto u = shares(width_, [&](size_t j) {
      return Vec3{section_[2 * j], section_[2 * j + 1], 0};
    });
    const auto v = shares(spine_.size(), [&](size_t i) { return spine_[i]; });
    for (const double t : v)
      for (const double s : u)
        out_.uvs.insert(out_.uvs.end(), {static_cast<float>(s), static_cast<float>(t)});
  }

  template <typename Points>
  static std::vector<double> shares(size_t count, const Points& point) {
    std::vector<double> way(count, 0);
    for (size_t i = 1; i < count; ++i) way[i] = way[i - 1] + length(point(i) - point(i - 1));
    const double all = way.back();
    if (all > 0)
      for (double& w : way) w /= all;
    return way;
  }

  uint32_t at(size_t i, size_t j) const { return static_cast<uint32_t>(i * width_ + j); }

  void add_sides() {
    for (size_t i = 0; i + 1 < spine_.size(); ++i) {
      for (size_t j = 0; j + 1 < width_; ++j) {
        // A closed cross-section ends where it began, so that its normals go round.
        const size_t k = closed_ && j + 2 == width_ ? 0 : j + 1;
        const uint32_t quad[] = {at(i, j), at(i, k), at(i + 1, k), at(i + 1, j)};
        const uint32_t uvs[] = {at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)};
        out_.add_face(quad);
        out_.corner_uvs.insert(out_.corner_uvs.end(), std::begin(uvs), std::end(uvs));
      }
    }
  }

  void add_cap(size_t i, bool faces_back) {
    const size_t corners = closed_ ? width_ - 1 : width_;
    if (corners < 3) return;
    std::array<double, 2> low{section_[0], section_[1]}, high = low;
    for (size_t j = 0; j < corners; ++j) {
      for (size_t a = 0; a < 2; ++a) {
        low[a] = std::min(low[a], section_[2 * j + a]);
        high[a] = std::max(high[a], section_[2 * j + a]);
      }
    }
    const double size = std::max(high[0] - low[0], high[1] - low[1]);
    std::vector<uint32_t> face;
    const auto first_uv = static_cast<uint32_t>(out_.uvs.size() / 2);
    for (size_t k = 0; k < corners; ++k) {
      const size_t j = faces_back ? corners - 1 - k : k;
      const size_t from = 3 * (i * width_ + j);
      face.push_back(static_cast<uint32_t>(out_.points.size() / 3));
      for (size_t a = 0; a < 3; ++a) out_.points.push_back(out_.points[from + a]);
      for (size_t a = 0; a < 2; ++a)
        out_.uvs.push_back(
            static_cast<float>(size > 0 ? (section_[2 * j + a] - low[a]) / size : 0));
      out_.corner_uvs.push_back(first_uv + static_cast<uint32_t>(k));
    }
    out_.add_face(face);
  }

  const X3dNode& node_;
  const X3dValues& values_;
  std::vector<double> section_, scale_, orientation_;
  std::vector<Vec3> spine_;
  size_t width_ = 0;  ///< points of the cross-section
  bool closed_ = false;
  X3dFaces out_;
};

}  // namespace

X3dFaces read_x3d_extrusion(const X3dNode& node, const X3dValues& values) {
  return Extruder(node, values).make();
}

}  // namespace tessera
