#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "renderer/math/vec.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// Rows of three numbers in the caller's memory, in single or double precision. Strides count
/// bytes; a row stride of 0 repeats one row.
struct VectorRows {
  const void* data = nullptr;
  std::ptrdiff_t row = 3 * sizeof(double), column = sizeof(double);
  bool is_single = false;

  Vec3 operator[](size_t i) const {
    const char* at = static_cast<const char*>(data) + static_cast<std::ptrdiff_t>(i) * row;
    if (is_single) return {read<float>(at), read<float>(at + column), read<float>(at + 2 * column)};
    return {read<double>(at), read<double>(at + column), read<double>(at + 2 * column)};
  }
  /// Starts to load row `i`, which need not be there.
  void prefetch(size_t i) const {
    __builtin_prefetch(static_cast<const char*>(data) + static_cast<std::ptrdiff_t>(i) * row);
  }

 private:
  /// From an address that need not be aligned.
  template <typename Number>
  static double read(const char* at) {
    Number number;
    std::memcpy(&number, at, sizeof number);
    return number;
  }
};

/// One number a ray. Without data, `otherwise` for every ray.
struct NumberRows {
  const double* data = nullptr;
  double otherwise = 0;

  double operator[](size_t i) const { return data ? data[i] : otherwise; }
};

/// Rays in the caller's memory. t counts lengths of the direction; hits lie at t_min < t < t_max.
/// A ray with a part that is not a number, or without a direction, hits nothing.
struct RayArrays {
  size_t count = 0;
  VectorRows origins, directions;
  NumberRows t_min{};  ///< none below 0
  NumberRows t_max{.otherwise = std::numeric_limits<double>::infinity()};
  Cull cull = Cull::none;
  /// Where queries copy the rays to as they read them, three numbers each; null for nowhere.
  double *kept_origins = nullptr, *kept_directions = nullptr;

  Ray operator[](size_t i) const {
    return {Point3{} + origins[i], directions[i], t_min[i], t_max[i], cull};
  }
};

/// Arrays for hits, one entry a ray; null where a field is not wanted. Where nothing is hit, t is
/// infinite, instance and primitive are kNoInstance and uv is 0.
struct HitArrays {
  double* t = nullptr;
  uint32_t* instance = nullptr;
  uint32_t* primitive = nullptr;  ///< of a mesh: the row of its triangles in the description
  double* uv = nullptr;           ///< two numbers a ray: weights of a triangle's vertices 1 and 2
};

/// Hits to look up, in the layout of HitArrays; none is null.
struct ConstHitArrays {
  const double* t = nullptr;
  const uint32_t* instance = nullptr;
  const uint32_t* primitive = nullptr;
  const double* uv = nullptr;
};

/// Arrays for what lies at hits; null where not wanted. Where there is no hit: NaN, kNoInstance.
struct AttributeArrays {
  double* point = nullptr;           ///< three numbers a hit
  double* point_error = nullptr;     ///< three: LocalSurface::point_error
  double* normal = nullptr;          ///< three: unit, of the surface's front
  double* shading_normal = nullptr;  ///< three: unit, smoothed by the normals of vertices
  double* texcoord = nullptr;        ///< two
  uint32_t* material = nullptr;      ///< into RayQueries::material_names()
};

/// All hits of rays: those of ray i are entries offsets[i] to offsets[i + 1] of the other arrays,
/// sorted by (t, instance, primitive), each hit once.
struct AllHits {
  std::vector<int64_t> offsets;  ///< one more than there are rays
  std::vector<double> t;
  std::vector<uint32_t> instance, primitive;
  std::vector<double> uv;  ///< two numbers a hit
};

/// How many rays one thread traces between two looks at whether it is to end.
inline constexpr size_t kRaysBetweenLooks = 64;

/// Who works on a call, and what ends it early. The result does not depend on `threads`.
struct QueryControl {
  int threads = 1;
  const std::atomic<bool>* cancelled = nullptr;  ///< see kRaysBetweenLooks
};

}  // namespace tessera
