#pragma once

#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/formats/crt/crt_value.h"

namespace tessera {

/// An attribute as the script gives it, evaluated.
struct CrtAttribute {
  std::string_view name;
  CrtSpan name_span, value_span;
  CrtValue value;
};

struct CrtRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false, below_max = false;  ///< the ends themselves are not allowed
};
inline constexpr CrtRange kCrtNotNegative{.min = 0};
inline constexpr CrtRange kCrtPositive{.min = 0, .above_min = true};
inline constexpr CrtRange kCrtShare{.min = 0, .max = 1};

/// The attributes of one object: each is asked for once by name and type. What is missing, of
/// another type or out of range is reported and replaced by something harmless; finish() tells.
class CrtAttributes {
 public:
  CrtAttributes(std::string_view object, CrtSpan where, std::vector<CrtAttribute> attributes,
                CrtDiagnostics& diagnostics);

  /// The last one of that name, or null.
  const CrtAttribute* find(std::string_view name);
  bool has(std::string_view name) { return find(name) != nullptr; }
  /// Without a fallback the attribute is required.
  double number(std::string_view name, CrtRange range = {}, std::optional<double> fallback = {});
  int32_t integer(std::string_view name, int32_t fallback);
  bool boolean(std::string_view name);
  std::string text(std::string_view name, std::string_view fallback);
  Vec3 vector(std::string_view name, std::optional<Vec3> fallback = {});
  /// A vector of any length but 0, made a unit one.
  Vec3 direction(std::string_view name, std::optional<Vec3> fallback = {});
  Color color(std::string_view name, std::optional<Color> fallback = {});
  /// A pointer to a light, camera, material ...; null where it is missing and not required.
  template <typename T>
  const T* thing(std::string_view name, std::string_view expected, bool required) {
    const CrtAttribute* found = asked(name, expected, required);
    if (!found) return nullptr;
    if (const T* const* value = std::get_if<const T*>(&found->value)) return *value;
    wrong(*found, expected);
    return nullptr;
  }

  void wrong(const CrtAttribute& attribute, std::string_view expected);
  void fail(CrtSpan where, std::string_view found, std::string_view expected);
  CrtSpan where() const { return where_; }
  const std::vector<CrtAttribute>& all() const { return attributes_; }
  CrtDiagnostics& diagnostics() { return diagnostics_; }
  /// Warns of attributes that nothing asked for. False where anything was wrong.
  bool finish();

 private:
  const CrtAttribute* asked(std::string_view name, std::string_view expected, bool required);

  std::string object_;
  CrtSpan where_;
  std::vector<CrtAttribute> attributes_;
  CrtDiagnostics& diagnostics_;
  std::set<std::string, std::less<>> known_;
  bool failed_ = false;
};

}  // namespace tessera
