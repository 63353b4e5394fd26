#include "scenes/formats/crt/crt_functions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

/// What one argument has to be.
enum class Wants : char { number = 'n', vector = 'v', any = 'a' };

struct Call {
  std::span<const CrtValue> arguments;
  CrtSpan where;
  JavaRandom& random;
  double number(size_t i) const { return number_of(arguments[i]); }
  const Vec3& vector(size_t i) const { return std::get<Vec3>(arguments[i]); }
};

/// Beyond this the portable sine is not exact.
constexpr double kLargestAngle = 1e6;

double angle(const Call& call) {
  const double value = call.number(0);
  if (!(std::abs(value) <= kLargestAngle))
    throw CrtError(call.where, fmt::format("an angle of {}", value), "at most 1e6 radians");
  return value;
}

/// Java's cast: towards zero, and what is too large to the largest.
int32_t to_integer(double value) {
  if (std::isnan(value)) return 0;
  constexpr double kLeast = std::numeric_limits<int32_t>::min();
  constexpr double kMost = std::numeric_limits<int32_t>::max();
  return static_cast<int32_t>(std::clamp(value, kLeast, kMost));
}

CrtValue length_of(const Call& call) {
  const CrtValue& value = call.arguments[0];
  if (holds<Vec3>(value)) return length(std::get<Vec3>(value));
  if (holds<const CrtList*>(value))
    return static_cast<int32_t>(std::get<const CrtList*>(value)->items.size());
  if (holds<const std::string*>(value))
    return static_cast<int32_t>(std::get<const std::string*>(value)->size());
  throw CrtError(call.where, fmt::format("the length of {}", describe(value)),
                 "a vector, a list or a text");
}

/// A raised to b, for every a and b for which Java's is a number.
double power(double a, double b) {
  if (a >= 0) return portable::pow(a, b);
  if (b != std::trunc(b)) return std::numeric_limits<double>::quiet_NaN();
  const double magnitude = portable::pow(-a, b);
  return std::fmod(b, 2) == 0 ? magnitude : -magnitude;
}

struct Function {
  std::string_view name;
  std::string_view wants;  ///< a letter an argument
  CrtValue (*run)(const Call&);
};

constexpr Function kFunctions[] = {
    {"rgb", "nnn",
     [](const Call& c) -> CrtValue {
       return Color{c.number(0), c.number(1), c.number(2)};
     }},
    {"rgba", "nnnn",
     [](const Call& c) -> CrtValue {
       return Color{c.number(0), c.number(1), c.number(2)};
     }},
    {"vec3", "nnn",
     [](const Call& c) -> CrtValue {
       return Vec3{c.number(0), c.number(1), c.number(2)};
     }},
    {"sin", "n", [](const Call& c) -> CrtValue { return portable::sin(angle(c)); }},
    {"cos", "n", [](const Call& c) -> CrtValue { return portable::cos(angle(c)); }},
    {"tan", "n", [](const Call& c) -> CrtValue { return portable::tan(angle(c)); }},
    {"rand", "nn",
     [](const Call& c) -> CrtValue {
       return c.random.next_double() * std::abs(c.number(0) - c.number(1)) +
              std::min(c.number(0), c.number(1));
     }},
    {"asin", "n", [](const Call& c) -> CrtValue { return portable::asin(c.number(0)); }},
    {"acos", "n", [](const Call& c) -> CrtValue { return portable::acos(c.number(0)); }},
    {"atan", "n", [](const Call& c) -> CrtValue { return portable::atan(c.number(0)); }},
    {"atan2", "nn",
     [](const Call& c) -> CrtValue { return portable::atan2(c.number(0), c.number(1)); }},
    {"exp", "n", [](const Call& c) -> CrtValue { return portable::exp(c.number(0)); }},
    {"log", "n", [](const Call& c) -> CrtValue { return portable::log(c.number(0)); }},
    {"pow", "nn", [](const Call& c) -> CrtValue { return power(c.number(0), c.number(1)); }},
    {"sqrt", "n", [](const Call& c) -> CrtValue { return std::sqrt(c.number(0)); }},
    {"abs", "n",
     [](const Call& c) -> CrtValue {
       if (holds<int32_t>(c.arguments[0]))
         return std::abs(std::max(std::get<int32_t>(c.arguments[0]), -0x7fffffff));
       return std::abs(c.number(0));
     }},
    {"floor", "n", [](const Call& c) -> CrtValue { return std::floor(c.number(0)); }},
    {"ceil", "n", [](const Call& c) -> CrtValue { return std::ceil(c.number(0)); }},
    {"round", "n", [](const Call& c) -> CrtValue { return std::floor(c.number(0) + 0.5); }},
    {"min", "nn",
     [](const Call& c) -> CrtValue {
       return c.number(1) < c.number(0) ? c.arguments[1] : c.arguments[0];
     }},
    {"max", "nn",
     [](const Call& c) -> CrtValue {
       return c.number(1) > c.number(0) ? c.arguments[1] : c.arguments[0];
     }},
    {"int", "n", [](const Call& c) -> CrtValue { return to_integer(c.number(0)); }},
    {"float", "n", [](const Call& c) -> CrtValue { return c.number(0); }},
    {"length", "a", length_of},
    {"normalize", "v", [](const Call& c) -> CrtValue { return normalize(c.vector(0)); }},
    {"dot", "vv", [](const Call& c) -> CrtValue { return dot(c.vector(0), c.vector(1)); }},
    {"cross", "vv", [](const Call& c) -> CrtValue { return cross(c.vector(0), c.vector(1)); }},
};

const Function* find(std::string_view name) {
  for (const Function& function : kFunctions)
    if (function.name == name) return &function;
  return nullptr;
}

}  // namespace

bool CrtFunctions::has(std::string_view name) { return find(name) != nullptr; }

std::vector<std::string> CrtFunctions::names() {
  std::vector<std::string> names;
  for (const Function& function : kFunctions) names.emplace_back(function.name);
  return names;
}

CrtValue CrtFunctions::call(std::string_view name, std::span<const CrtValue> arguments,
                            CrtSpan where) {
  const Function& function = *find(name);
  for (const CrtValue& argument : arguments)
    if (holds<CrtFailed>(argument)) return CrtFailed{};
  if (arguments.size() != function.wants.size())
    throw CrtError(where, fmt::format("{} with {} arguments", name, arguments.size()),
                   fmt::format("{}", function.wants.size()));
  for (size_t i = 0; i < arguments.size(); ++i) {
    const auto wants = static_cast<Wants>(function.wants[i]);
    const bool fits = wants == Wants::any || (wants == Wants::number && is_number(arguments[i])) ||
                      (wants == Wants::vector && holds<Vec3>(arguments[i]));
    if (fits) continue;
    throw CrtError(where,
                   fmt::format("argument {} of {} is {}", i + 1, name, describe(arguments[i])),
                   wants == Wants::number ? "a number" : "a vector");
  }
  return function.run({arguments, where, random_});
}

}  // namespace tessera
