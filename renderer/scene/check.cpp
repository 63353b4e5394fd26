#include "renderer/scene/check.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/plain_text.h"

namespace tessera {

namespace {

std::string describe(const Range& range) {
  const bool has_min = std::isfinite(range.min), has_max = std::isfinite(range.max);
  if (!has_min && !has_max) return "a finite number";
  if (!has_max) return fmt::format("a number {} {}", range.above_min ? ">" : ">=", range.min);
  return fmt::format("a number in {}{}, {}{}", range.above_min ? '(' : '[', range.min, range.max,
                     range.below_max ? ')' : ']');
}

bool is_inside(double value, const Range& range) {
  return std::isfinite(value) && value >= range.min && value <= range.max &&
         !(range.above_min && value == range.min) && !(range.below_max && value == range.max);
}

}  // namespace

std::string Where::str() const {
  const std::string before = parent ? parent->str() + " > " : "";
  if (!name.empty()) return fmt::format("{}{} '{}'", before, kind, escape_controls(name));
  return index < 0 ? before + kind : fmt::format("{}{} {}", before, kind, index + 1);
}

void fail_value(const Where& where, std::string_view field, std::string_view value,
                std::string_view expected) {
  throw scene_error(SourcePlace{where.str()}, fmt::format("{} is {}", field, value), expected);
}

void fail_unsupported(const Where& where, std::string_view name) {
  throw scene_error(SourcePlace{where.str()}, fmt::format("{} is not supported yet", name), "");
}

double checked(const Where& where, std::string_view field, double value, const Range& range) {
  if (!is_inside(value, range)) {
    fail_value(where, field, fmt::format("{}", value), describe(range));
  }
  return value;
}

Vec3 checked(const Where& where, std::string_view field, const v1::Vec3& value) {
  const Vec3 v{value.x(), value.y(), value.z()};
  if (!is_finite(v)) {
    fail_value(where, field, fmt::format("({}, {}, {})", v.x, v.y, v.z), "finite numbers");
  }
  return v;
}

Point3 checked_point(const Where& where, std::string_view field, const v1::Vec3& value) {
  return Point3{} + checked(where, field, value);
}

Vec3 checked_direction(const Where& where, std::string_view field, const v1::Vec3& value) {
  const Vec3 v = checked(where, field, value);
  if (v == Vec3{}) fail_value(where, field, "(0, 0, 0)", "a vector of any length but 0");
  return normalize(v);
}

Color checked(const Where& where, std::string_view field, const v1::Color& value,
              const Range& range) {
  for (const double channel : {value.r(), value.g(), value.b()}) {
    if (!is_inside(channel, range)) {
      fail_value(where, field, fmt::format("({}, {}, {})", value.r(), value.g(), value.b()),
                 describe(range) + " in each channel");
    }
  }
  return {value.r(), value.g(), value.b()};
}

}  // namespace tessera
