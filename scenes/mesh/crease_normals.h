#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/math/vec.h"

namespace tessera {

/// The faces around a position that one crease angle may compare: the work is in its square.
inline constexpr size_t kMaxCreaseFaces = 4096;

/// Polygons over shared positions: face f has corners [starts[f], starts[f + 1]).
struct Polygons {
  std::vector<uint32_t> corners;  ///< indices of positions
  std::vector<uint32_t> starts{0};

  size_t size() const { return starts.size() - 1; }
  std::span<const uint32_t> face(size_t f) const {
    return std::span(corners).subspan(starts[f], starts[f + 1] - starts[f]);
  }
};

/// Normals for the corners of polygons that come without.
struct GeneratedNormals {
  std::vector<float> normals;           ///< x y z each, unit
  std::vector<uint32_t> corner_normal;  ///< an index into `normals` for each corner
};

/// At each corner the mean, weighted by area, of the normals of those faces around its position
/// that make less than `crease_angle` (radians) with its own face; all of them from pi on.
/// `face_areas` are the faces' area vectors. Empty where more than kMaxCreaseFaces would be
/// compared.
GeneratedNormals crease_normals(const Polygons& polygons, std::span<const Vec3> face_areas,
                                size_t position_count, double crease_angle);

}  // namespace tessera
