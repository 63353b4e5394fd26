#pragma once

#include <cstddef>
#include <numbers>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/math/vec.h"

namespace tessera {

/// Of half a turn: what is between two of them sticks out by .9 % of the radius.
inline constexpr int kRimSteps = 24;
inline constexpr double kRimStep = std::numbers::pi / kRimSteps;
/// As a torus has.
inline constexpr size_t kMostOutlinePoints = size_t{2 * kRimSteps + 1} * 2 * kRimSteps;

/// The eight of them.
std::vector<Point3> box_corners(const Bounds3& box);
/// Adds points of the ellipse about `center` with the half axes `u` and `v`.
void add_rim(const Point3& center, const Vec3& u, const Vec3& v, std::vector<Point3>& points);
/// The same of a circle about the y axis.
void add_rim(double radius, double y, std::vector<Point3>& points);

}  // namespace tessera
