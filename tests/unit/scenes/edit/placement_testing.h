#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "renderer/math/elementary.h"
#include "renderer/math/transform.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/placement.h"
#include "tests/uniform_numbers.h"
#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {

inline int include_of(const Outline& made) {
  for (size_t i = 0; i < made.entities().size(); ++i)
    if (made.entities()[i].kind == EntityKind::include) return static_cast<int>(i);
  return -1;
}

/// The text where its first include has another placement.
inline std::string placed(Language language, const std::string& text, const Placement& placement) {
  const Outline made = outline(language, text);
  const Change change = set_placement(made, include_of(made), placement);
  EXPECT_TRUE(change.is_made()) << text << refusal_of(change);
  return apply_edits(text, change.edits);
}

inline std::string fault(Language language, const std::string& text, const Placement& placement) {
  const Outline made = outline(language, text);
  return refusal_of(set_placement(made, include_of(made), placement));
}

inline WrittenPlacement read_include(Language language, const std::string& text) {
  const Outline made = outline(language, text);
  return read_placement(made, include_of(made));
}

/// The text with a new include.
inline std::string added(Language language, const std::string& text, const Placement& placement) {
  const Outline made = outline(language, text);
  return applied(made, add_placement(made, placement));
}

inline void expect_same(const Placement& one, const Placement& other) {
  EXPECT_EQ(one.file, other.file);
  EXPECT_EQ(one.material, other.material);
  EXPECT_EQ(one.position, other.position);
  EXPECT_EQ(one.rotation, other.rotation);
  EXPECT_EQ(one.scale, other.scale);
  EXPECT_EQ(one.flip, other.flip);
}

inline Vec3 numbers_of(const std::array<std::string, 3>& typed) {
  return {*typed_number(typed[0]), *typed_number(typed[1]), *typed_number(typed[2])};
}

inline Vec3 signed_numbers_of_scale(const Placement& placement) {
  Vec3 scale = numbers_of(placement.scale);
  for (int i = 0; i < 3; ++i)
    if (placement.flip[static_cast<size_t>(i)]) scale[i] = -scale[i];
  return scale;
}

/// Of the one order or the other: turned about z first, or about x.
inline Affine matrix_of(const Placement& placement, bool turns_z_first) {
  const Vec3 degrees = numbers_of(placement.rotation);
  const Affine x = rotation({1, 0, 0}, portable::radians(degrees.x));
  const Affine y = rotation({0, 1, 0}, portable::radians(degrees.y));
  const Affine z = rotation({0, 0, 1}, portable::radians(degrees.z));
  return translation(numbers_of(placement.position)) * (turns_z_first ? x * y * z : z * y * x) *
         scaling(signed_numbers_of_scale(placement));
}

inline double largest_difference(const Affine& a, const Affine& b) {
  double most = 0;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) most = std::max(most, std::abs(a.m[r][c] - b.m[r][c]));
  return most;
}

/// Numbers with up to three decimals, many of them those of no placement.
inline Placement random_placement(uint64_t seed) {
  UniformNumbers random(seed);
  const auto number = [&](int least, int most) {
    return fmt::format(
        "{}", (least + static_cast<int>(random.below(static_cast<size_t>(most - least)))) / 1000.0);
  };
  Placement placement{.file = "a.obj", .material = ""};
  if (random.below(3) > 0)
    for (std::string& each : placement.position) each = number(-9000, 9000);
  for (std::string& each : placement.rotation)
    if (random.below(2) > 0) each = number(-90000, 90000);
  if (random.below(3) == 0) placement.scale.fill(number(1, 4000));
  if (random.below(3) == 0)
    for (std::string& each : placement.scale) each = number(1, 4000);
  for (bool& each : placement.flip) each = random.below(4) == 0;
  return placement;
}

}  // namespace tessera::edit
