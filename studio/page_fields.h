#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "studio/view_filter.h"

namespace tessera::page {

/// What is thrown where a page says something that it may not. Of a long one its beginning is told.
Error wrong(std::string_view what, std::string_view found, std::string_view expected);

/// The fields of one message, which must outlive this. Absent ones, and those that are null, keep
/// the value that they have; get() throws wrong() for one of another type.
class Fields {
 public:
  explicit Fields(const nlohmann::json& object) : object_(object) {}

  void get(const char* name, std::string& value) const;
  void get(const char* name, bool& value) const;
  void get(const char* name, double& value) const;
  void get(const char* name, std::array<double, 3>& value) const;
  /// An object whose values are numbers, texts or flags, as options of a command are typed.
  void get(const char* name, std::vector<std::pair<std::string, std::string>>& value) const;
  /// [[file, entity], ...]
  void get(const char* name, std::vector<EntityRef>& value) const;
  template <typename Whole>
  void get_whole(const char* name, Whole& value, int64_t least, int64_t most) const {
    if (const nlohmann::json* field = find(name))
      value = static_cast<Whole>(whole(name, *field, least, most));
  }
  /// Three texts, or three flags.
  template <typename Part>
  void get_three(const char* name, std::array<Part, 3>& parts) const {
    const nlohmann::json* field = find(name);
    if (!field) return;
    if (!field->is_array() || field->size() != 3) throw wrong(name, field->dump(), "three values");
    for (size_t i = 0; i < 3; ++i) {
      const nlohmann::json& part = (*field)[i];
      if (std::is_same_v<Part, bool> ? !part.is_boolean() : !part.is_string())
        throw wrong(name, part.dump(), std::is_same_v<Part, bool> ? "three flags" : "three texts");
      parts[i] = part.get<Part>();
    }
  }
  /// Null where it is absent or null.
  const nlohmann::json* find(const char* name) const;

  static double number(const char* name, const nlohmann::json& field);
  static int64_t whole(const char* name, const nlohmann::json& field, int64_t least, int64_t most);

 private:
  const nlohmann::json& object_;
};

}  // namespace tessera::page
