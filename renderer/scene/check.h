#pragma once

#include <limits>
#include <string>
#include <string_view>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/color.h"
#include "renderer/math/vec.h"

namespace tessera {

/// A place in the description, as a chain on the stack: spelt out only when an error needs it.
struct Where {
  const Where* parent = nullptr;
  const char* kind = "";  ///< "material", "node" ...
  std::string_view name{};
  int index = -1;  ///< counts from 0; shown where there is no name

  /// "node 'hall' > node 3 > shape".
  std::string str() const;
};

/// Throws a scene error: "WHERE: FIELD is VALUE; expected EXPECTED".
[[noreturn]] void fail_value(const Where& where, std::string_view field, std::string_view value,
                             std::string_view expected);
/// Throws a scene error: "WHERE: NAME is not supported yet".
[[noreturn]] void fail_unsupported(const Where& where, std::string_view name);

/// What a number may be.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false;  ///< min itself is not allowed
  bool below_max = false;  ///< max itself is not allowed
};
inline constexpr Range kAnyNumber{};
inline constexpr Range kNotNegative{.min = 0};
inline constexpr Range kPositive{.min = 0, .above_min = true};
inline constexpr Range kUnitRange{.min = 0, .max = 1};
/// Of what a shape's test squares.
inline constexpr Range kLength{.min = 0, .max = 1e150, .above_min = true};

// Each returns the value, converted, or throws a scene error that names it. All must be finite.
double checked(const Where& where, std::string_view field, double value,
               const Range& range = kAnyNumber);
Vec3 checked(const Where& where, std::string_view field, const v1::Vec3& value);
Point3 checked_point(const Where& where, std::string_view field, const v1::Vec3& value);
/// A vector of any length but 0, made a unit one.
Vec3 checked_direction(const Where& where, std::string_view field, const v1::Vec3& value);
Color checked(const Where& where, std::string_view field, const v1::Color& value,
              const Range& range = kNotNegative);

}  // namespace tessera
