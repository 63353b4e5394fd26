#include "scenes/edit/x3d_rotation.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "renderer/math/elementary.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/x3d_words.h"

namespace tessera::edit {
namespace {

/// Numbers are tried at tolerances from 1e-6 on that become finer by this factor.
constexpr double kFiner = 8, kFinest = 1e-17;

/// The one of x, y and z that a vector is along; nothing for any other.
std::optional<size_t> main_axis(const std::array<double, 3>& v) {
  std::optional<size_t> found;
  for (size_t i = 0; i < 3; ++i) {
    if (v[i] == 0) continue;
    if (found) return {};
    found = i;
  }
  return found;
}

std::array<double, 3> numbers_of(const std::array<std::string, 3>& typed) {
  std::array<double, 3> numbers{};
  for (size_t i = 0; i < 3; ++i) numbers[i] = typed_number(typed[i]).value_or(0);
  return numbers;
}

/// How far a rotation may be from its text: that of 1.5707963 may be 90 degrees.
double precision_of(std::string_view text) {
  constexpr double kLeast = 1e-15;
  int decimals = 0;
  for (const SourceRange range : number_words(text, {0, static_cast<uint32_t>(text.size())})) {
    const std::string_view word = text_of(text, range);
    const size_t digits_end = std::min(word.find_first_of("eE"), word.size());
    const size_t point = std::min(word.find('.'), digits_end - 1);
    int exponent = 0;
    if (digits_end < word.size())
      std::from_chars(word.data() + digits_end + 1, word.data() + word.size(), exponent);
    decimals = std::max(decimals, static_cast<int>(digits_end - point) - 1 - exponent);
  }
  return std::clamp(2 * std::pow(10, -decimals), kLeast, kSameRotation);
}

/// Radians about x, y and z. At `is_upright`, where y is about a quarter of a turn, x and z turn
/// about one axis and x has both.
std::array<double, 3> euler_angles(const Affine& f, bool is_upright) {
  const double y = std::atan2(f.m[0][2], std::hypot(f.m[1][2], f.m[2][2]));
  if (is_upright) return {std::atan2(f.m[2][1], f.m[1][1]), y, 0};
  return {std::atan2(-f.m[1][2], f.m[2][2]), y, std::atan2(-f.m[0][1], f.m[0][0])};
}

std::array<std::string, 3> shown_euler(const Affine& wanted, double tolerance) {
  constexpr double kRounding = 1e-13;
  tolerance = std::max(tolerance, kRounding);
  std::array<std::string, 3> shown;
  for (const bool is_upright : {true, false}) {
    if (is_upright && std::hypot(wanted.m[1][2], wanted.m[2][2]) > 4 * tolerance) continue;
    const auto exact = euler_angles(wanted, is_upright);
    for (double each = tolerance; each > kFinest; each /= kFiner) {
      for (size_t i = 0; i < 3; ++i)
        shown[i] = shortest_number(portable::degrees(exact[i]), portable::degrees(each));
      if (rotation_difference(wanted, rotation_of_degrees(shown)) <= tolerance) return shown;
    }
  }
  return shown;
}

}  // namespace

std::optional<AxisAngle> read_axis_angle(std::string_view text, double unit) {
  const auto words = number_words(text, {0, static_cast<uint32_t>(text.size())});
  AxisAngle turn{};
  if (words.size() != turn.size()) return {};
  for (size_t i = 0; i < turn.size(); ++i) {
    const auto number = typed_number(text_of(text, words[i]));
    if (!number) return {};
    turn[i] = *number;
  }
  turn[3] *= unit;
  return turn;
}

AxisAngle axis_angle(const Affine& f) {
  const double trace = f.m[0][0] + f.m[1][1] + f.m[2][2];
  Vec3 axis{f.m[2][1] - f.m[1][2], f.m[0][2] - f.m[2][0], f.m[1][0] - f.m[0][1]};
  const double sine = length(axis) / 2, cosine = (trace - 1) / 2;
  const double angle = std::atan2(sine, cosine);
  if (sine < 1e-4 && cosine < 0) {
    // About half a turn, where the axis is in the symmetric part: cosine I + (1 - cosine) a a'.
    size_t best = 0;
    for (size_t i = 1; i < 3; ++i)
      if (f.m[i][i] > f.m[best][best]) best = i;
    Vec3 column;
    for (size_t i = 0; i < 3; ++i)
      column[static_cast<int>(i)] = (f.m[i][best] + f.m[best][i]) / 2 - (i == best ? cosine : 0);
    if (dot(column, axis) < 0) column = -column;
    axis = column;
  }
  if (!(length(axis) > 1e-12)) return {0, 0, 1, 0};
  axis = normalize(axis);
  return {axis.x, axis.y, axis.z, angle};
}

double rotation_difference(const Affine& a, const Affine& b) {
  double most = 0;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a.m[r][c] - b.m[r][c]));
  return most;
}

Affine rotation_of(const AxisAngle& turn) {
  const Vec3 axis{turn[0], turn[1], turn[2]};
  return length(axis) > 0 ? rotation(axis, turn[3]) : Affine{};
}

std::string written_axis_angle(const AxisAngle& turn, double unit,
                               const std::function<bool(const std::string&)>& is_enough) {
  const Affine wanted = rotation_of(turn);
  std::string text;
  for (double tolerance = kSameRotation; tolerance > kFinest; tolerance /= kFiner) {
    text.clear();
    for (size_t i = 0; i < 3; ++i) text += shortest_number(turn[i], tolerance) + " ";
    text += shortest_number(turn[3] / unit, tolerance / unit);
    const auto read = read_axis_angle(text, unit);
    if (read && rotation_difference(wanted, rotation_of(*read)) <= kSameRotation &&
        (!is_enough || is_enough(text)))
      break;
  }
  return text;
}

std::optional<std::array<std::string, 3>> shown_degrees(std::string_view text) {
  const auto turn = read_axis_angle(text);
  if (!turn) return {};
  const double precision = precision_of(text);
  const auto [x, y, z, angle] = *turn;
  const auto axis = main_axis({x, y, z});
  if (!axis) return shown_euler(rotation_of(*turn), precision);
  std::array<std::string, 3> shown{"0", "0", "0"};
  shown[*axis] = shortest_number(portable::degrees(std::copysign(angle, angle * (*turn)[*axis])),
                                 portable::degrees(precision));
  return shown;
}

Affine rotation_of_degrees(const std::array<std::string, 3>& degrees) {
  const auto [x, y, z] = numbers_of(degrees);
  return rotation({1, 0, 0}, portable::radians(x)) * rotation({0, 1, 0}, portable::radians(y)) *
         rotation({0, 0, 1}, portable::radians(z));
}

bool is_same_rotation(const std::array<std::string, 3>& shown,
                      const std::array<std::string, 3>& wanted) {
  if (numbers_of(shown) == numbers_of(wanted)) return true;
  return !main_axis(numbers_of(wanted)) &&
         rotation_difference(rotation_of_degrees(shown), rotation_of_degrees(wanted)) <=
             kSameRotation;
}

std::string written_degrees(const std::array<std::string, 3>& degrees) {
  const auto numbers = numbers_of(degrees);
  const auto axis = main_axis(numbers);
  if (!axis) return written_axis_angle(axis_angle(rotation_of_degrees(degrees)));
  AxisAngle turn{};
  turn[*axis] = 1;
  turn[3] = portable::radians(numbers[*axis]);
  return written_axis_angle(turn, 1, [&](const std::string& text) {
    constexpr double kSameDegrees = 1e-11;
    const auto shown = shown_degrees(text);
    return shown && std::abs(numbers_of(*shown)[*axis] - numbers[*axis]) <= kSameDegrees;
  });
}

}  // namespace tessera::edit
