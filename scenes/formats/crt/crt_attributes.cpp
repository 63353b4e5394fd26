#include "scenes/formats/crt/crt_attributes.h"

#include <fmt/format.h>

#include <cmath>

namespace tessera {
namespace {

bool is_finite(double x, double y, double z) {
  return std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
}

bool is_inside(double value, const CrtRange& range) {
  return (range.above_min ? value > range.min : value >= range.min) &&
         (range.below_max ? value < range.max : value <= range.max);
}

std::string range_text(const CrtRange& range) {
  std::string text = "a finite number";
  if (std::isfinite(range.min))
    text += fmt::format("{} {}", range.above_min ? " above" : " of at least", range.min);
  if (std::isfinite(range.max))
    text += fmt::format("{}{} {}", std::isfinite(range.min) ? " and" : "",
                        range.below_max ? " below" : " at most", range.max);
  return text;
}

}  // namespace

CrtAttributes::CrtAttributes(std::string_view object, CrtSpan where,
                             std::vector<CrtAttribute> attributes, CrtDiagnostics& diagnostics)
    : object_(object),
      where_(where),
      attributes_(std::move(attributes)),
      diagnostics_(diagnostics) {}

const CrtAttribute* CrtAttributes::find(std::string_view name) {
  known_.emplace(name);
  for (auto at = attributes_.rbegin(); at != attributes_.rend(); ++at)
    if (at->name == name) return &*at;
  return nullptr;
}

void CrtAttributes::fail(CrtSpan where, std::string_view found, std::string_view expected) {
  failed_ = true;
  diagnostics_.error(where, found, expected);
}

void CrtAttributes::wrong(const CrtAttribute& attribute, std::string_view expected) {
  failed_ = true;
  if (holds<CrtFailed>(attribute.value)) return;  // was reported where it failed
  diagnostics_.error(attribute.value_span,
                     fmt::format("{} is {}", attribute.name, describe(attribute.value)), expected);
}

const CrtAttribute* CrtAttributes::asked(std::string_view name, std::string_view expected,
                                         bool required) {
  const CrtAttribute* found = find(name);
  if (!found && required) {
    // A misspelt one says more than a missing one.
    std::vector<std::string> given;
    for (const CrtAttribute& attribute : attributes_) given.emplace_back(attribute.name);
    const auto near = nearest_name(name, given);
    for (const CrtAttribute& attribute : attributes_) {
      if (!near || attribute.name != *near || known_.contains(attribute.name)) continue;
      fail(attribute.name_span, fmt::format("{} has no attribute '{}'", object_, attribute.name),
           fmt::format("'{}'; did you mean '{}'?", name, name));
      return nullptr;
    }
    fail(where_, fmt::format("{} without '{}'", object_, name),
         fmt::format("{} -> {}", name, expected));
  }
  return found;
}

double CrtAttributes::number(std::string_view name, CrtRange range,
                             std::optional<double> fallback) {
  const CrtAttribute* found = asked(name, "a number", !fallback);
  if (!found) return fallback.value_or(1);
  if (!is_number(found->value)) {
    wrong(*found, "a number");
  } else {
    const double value = number_of(found->value);
    if (std::isfinite(value) && is_inside(value, range)) return value;
    wrong(*found, range_text(range));
  }
  return fallback.value_or(1);
}

int32_t CrtAttributes::integer(std::string_view name, int32_t fallback) {
  const CrtAttribute* found = find(name);
  if (!found) return fallback;
  if (const auto whole = whole_number(found->value)) return *whole;
  wrong(*found, "an integer");
  return fallback;
}

bool CrtAttributes::boolean(std::string_view name) {
  const CrtAttribute* found = find(name);
  if (!found) return false;
  if (holds<bool>(found->value)) return std::get<bool>(found->value);
  wrong(*found, "true or false");
  return false;
}

std::string CrtAttributes::text(std::string_view name, std::string_view fallback) {
  const CrtAttribute* found = find(name);
  if (!found) return std::string(fallback);
  if (holds<const std::string*>(found->value)) return *std::get<const std::string*>(found->value);
  wrong(*found, "a text");
  return std::string(fallback);
}

Vec3 CrtAttributes::vector(std::string_view name, std::optional<Vec3> fallback) {
  const CrtAttribute* found = asked(name, "vec3(x, y, z)", !fallback);
  if (!found) return fallback.value_or(Vec3{});
  if (!holds<Vec3>(found->value)) {
    wrong(*found, "a vector: vec3(x, y, z)");
    return {};
  }
  const Vec3 value = std::get<Vec3>(found->value);
  if (is_finite(value.x, value.y, value.z)) return value;
  fail(found->value_span, fmt::format("{} is not finite", name), "three finite numbers");
  return {};
}

Vec3 CrtAttributes::direction(std::string_view name, std::optional<Vec3> fallback) {
  const Vec3 value = vector(name, fallback);
  const double size = length(value);
  if (size > 0 && std::isfinite(size)) return value / size;
  if (const CrtAttribute* found = find(name); found && holds<Vec3>(found->value))
    fail(found->value_span, fmt::format("{} has no direction", name),
         "a vector that is not too short or too long");
  return {0, 1, 0};
}

Color CrtAttributes::color(std::string_view name, std::optional<Color> fallback) {
  const CrtAttribute* found = asked(name, "rgb(r, g, b)", !fallback);
  if (!found) return fallback.value_or(kBlack);
  if (!holds<Color>(found->value)) {
    wrong(*found, "a colour: rgb(r, g, b)");
    return kBlack;
  }
  const Color value = std::get<Color>(found->value);
  if (is_finite(value.r, value.g, value.b) && value.r >= 0 && value.g >= 0 && value.b >= 0)
    return value;
  fail(found->value_span, fmt::format("{} is rgb({}, {}, {})", name, value.r, value.g, value.b),
       "finite shares of 0 or more");
  return kBlack;
}

bool CrtAttributes::finish() {
  const std::vector<std::string> known(known_.begin(), known_.end());
  for (const CrtAttribute& attribute : attributes_) {
    if (known_.contains(attribute.name)) continue;
    diagnostics_.warning(attribute.name_span,
                         fmt::format("{} has no attribute '{}', which is left out{}", object_,
                                     attribute.name, suggestion(attribute.name, known)));
  }
  return !failed_;
}

}  // namespace tessera
