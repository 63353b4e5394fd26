#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/math/transform.h"

namespace tessera::edit {

/// A rotation as X3D writes it: an axis of any length but 0, and an angle in radians.
using AxisAngle = std::array<double, 4>;

/// Rotations are the same where no entries of their matrices are farther apart.
inline constexpr double kSameRotation = 1e-6;

/// Nothing where the text has not four numbers. `unit`: that of its angle, in radians.
std::optional<AxisAngle> read_axis_angle(std::string_view text, double unit = 1);
AxisAngle axis_angle(const Affine& rotation);
Affine rotation_of(const AxisAngle& turn);
/// The largest difference of two entries.
double rotation_difference(const Affine& a, const Affine& b);

/// The shortest numbers, with the angle in that unit, that are the same rotation and that
/// `is_enough` accepts; without it any.
std::string written_axis_angle(const AxisAngle& turn, double unit = 1,
                               const std::function<bool(const std::string&)>& is_enough = {});

/// A rotation's text as degrees about x, y and z, the last turning first: in the shortest numbers
/// that are within 1e-6 of it, and within the text's own precision where that is finer. A rotation
/// about one of the axes keeps it, however far it turns. Nothing where the text has not four
/// numbers.
std::optional<std::array<std::string, 3>> shown_degrees(std::string_view text);
/// The text of such degrees, in the shortest numbers that are the same rotation. One about a single
/// axis has enough digits for shown_degrees to give the same degrees.
std::string written_degrees(const std::array<std::string, 3>& degrees);
/// The matrix of such degrees, which must be numbers.
Affine rotation_of_degrees(const std::array<std::string, 3>& degrees);
/// Whether `wanted` needs no other text than `shown`: it has equal numbers, or is the same rotation
/// about no single axis, whose numbers need not come back.
bool is_same_rotation(const std::array<std::string, 3>& shown,
                      const std::array<std::string, 3>& wanted);

}  // namespace tessera::edit
