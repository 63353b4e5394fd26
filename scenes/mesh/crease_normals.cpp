#include "scenes/mesh/crease_normals.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

Vec3 unit_or_zero(const Vec3& v) { return v == Vec3{} ? v : normalize(v); }

/// The corners at each position, in the order of the faces (compressed rows).
struct Fans {
  std::vector<uint32_t> starts, corners;
};

Fans fans_of(const Polygons& polygons, size_t position_count) {
  Fans fans;
  fans.starts.assign(position_count + 1, 0);
  for (const uint32_t position : polygons.corners) ++fans.starts[position + 1];
  for (size_t i = 0; i < position_count; ++i) fans.starts[i + 1] += fans.starts[i];
  fans.corners.resize(polygons.corners.size());
  std::vector<uint32_t> next(fans.starts.begin(), fans.starts.end() - 1);
  for (uint32_t c = 0; c < polygons.corners.size(); ++c)
    fans.corners[next[polygons.corners[c]]++] = c;
  return fans;
}

std::vector<uint32_t> faces_of_corners(const Polygons& polygons) {
  std::vector<uint32_t> faces(polygons.corners.size());
  for (uint32_t f = 0; f < polygons.size(); ++f)
    std::fill(faces.begin() + polygons.starts[f], faces.begin() + polygons.starts[f + 1], f);
  return faces;
}

class CreaseNormals {
 public:
  CreaseNormals(const Polygons& polygons, std::span<const Vec3> areas)
      : areas_(areas), faces_(faces_of_corners(polygons)) {
    units_.reserve(areas.size());
    for (const Vec3& area : areas) units_.push_back(unit_or_zero(area));
    out_.corner_normal.resize(polygons.corners.size());
  }

  void smooth(std::span<const uint32_t> fan) {
    Vec3 sum{};
    for (const uint32_t corner : fan) sum = sum + areas_[faces_[corner]];
    const uint32_t normal = add(sum);
    for (const uint32_t corner : fan) out_.corner_normal[corner] = normal;
  }

  void crease(std::span<const uint32_t> fan, double cosine) {
    const size_t first = out_.normals.size() / 3;
    for (const uint32_t corner : fan) {
      const uint32_t own = faces_[corner];
      Vec3 sum{};
      for (const uint32_t other : fan)
        if (faces_[other] == own || dot(units_[faces_[other]], units_[own]) > cosine)
          sum = sum + areas_[faces_[other]];
      out_.corner_normal[corner] = add_once(sum, first);
    }
  }

  GeneratedNormals take() { return std::move(out_); }

 private:
  uint32_t add(const Vec3& sum) {
    const Vec3 unit = sum == Vec3{} ? Vec3{0, 0, 1} : normalize(sum);
    for (int a = 0; a < 3; ++a) out_.normals.push_back(static_cast<float>(unit[a]));
    return static_cast<uint32_t>(out_.normals.size() / 3 - 1);
  }

  /// Corners with the same normal share it, so that they can share a vertex.
  uint32_t add_once(const Vec3& sum, size_t first) {
    const uint32_t added = add(sum);
    const float* values = out_.normals.data();
    for (size_t n = first; n < added; ++n) {
      if (!std::equal(values + 3 * n, values + 3 * n + 3, values + 3 * size_t{added})) continue;
      out_.normals.resize(3 * size_t{added});
      return static_cast<uint32_t>(n);
    }
    return added;
  }

  std::span<const Vec3> areas_;
  std::vector<uint32_t> faces_;
  std::vector<Vec3> units_;
  GeneratedNormals out_;
};

}  // namespace

GeneratedNormals crease_normals(const Polygons& polygons, std::span<const Vec3> face_areas,
                                size_t position_count, double crease_angle) {
  const Fans fans = fans_of(polygons, position_count);
  const bool smooth = crease_angle >= 3.14159265;
  const double cosine = portable::cos(std::clamp(crease_angle, 0.0, portable::kPi));
  CreaseNormals normals(polygons, face_areas);
  for (size_t p = 0; p < position_count; ++p) {
    const auto fan =
        std::span(fans.corners).subspan(fans.starts[p], fans.starts[p + 1] - fans.starts[p]);
    if (fan.empty()) continue;
    if (smooth)
      normals.smooth(fan);
    else if (fan.size() <= kMaxCreaseFaces)
      normals.crease(fan, cosine);
    else
      return {};
  }
  return normals.take();
}

}  // namespace tessera
