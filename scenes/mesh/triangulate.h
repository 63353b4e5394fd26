#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/math/vec.h"

namespace tessera {

/// Three corners of a polygon by their position in it.
using CornerTriple = std::array<uint32_t, 3>;

/// Ear clipping takes time in the square of the number of corners, so there is an end to it.
inline constexpr size_t kMaxConcaveCorners = 8192;

/// Twice the area vector of a closed polygon, planar or not (Newell's method; Sutherland et al.
/// 1974): along the normal from which the corners turn counter-clockwise.
Vec3 newell_normal(std::span<const Vec3> corners);

/// Whether no corner turns the wrong way about `normal`, which is the polygon's Newell normal.
bool is_convex(std::span<const Vec3> corners, const Vec3& normal);

/// Cuts a polygon of at least 3 corners into corners.size() - 2 triangles of the same winding: a
/// fan where it is convex, by ear clipping in the plane of its Newell normal where not (Meisters
/// 1975). A polygon that crosses itself still gives that many triangles. Appends to `out`; returns
/// false, having done nothing, for one with over kMaxConcaveCorners that is not convex.
[[nodiscard]] bool triangulate(std::span<const Vec3> corners, std::vector<CornerTriple>& out);
/// The fan about the first corner.
void triangulate_fan(size_t corners, std::vector<CornerTriple>& out);

}  // namespace tessera
