#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// The JSON text of a glTF file, so that errors can name a place in it, and what there is to say of
/// the file.
struct GltfText {
  std::string name;         ///< of the file
  std::string_view text{};  ///< empty in a .glb, whose JSON is no text with lines
  Warnings warnings{};
  std::set<std::string> told{};  ///< the repairs of `warnings`, each told once
  int errors = 0;                ///< that were made, so that not all look for their place
};

/// A value of a glTF file's JSON, or of none where a member is absent. It knows where it stands.
/// What cannot be read without is a located error; another value that breaks a rule, as one of the
/// wrong type, is repaired, which is a located warning. Refers to the document.
class GltfValue {
 public:
  GltfValue(const nlohmann::json* json, GltfText* text, std::string path)
      : json_(json), text_(text), path_(std::move(path)) {}

  explicit operator bool() const { return json_ != nullptr; }
  /// Both give no value where there is none, nor of what is of another type. A null, which glTF
  /// does not permit, is none too, with a warning.
  GltfValue operator[](const char* key) const;
  GltfValue at(size_t index) const;
  size_t size() const;  ///< of an array; 0 where there is none
  std::vector<std::string> keys() const;

  /// The largest number, of either sign, that is read: that of single precision.
  static constexpr double kMost = std::numeric_limits<float>::max();
  double number(double without) const { return number_within(without, -kMost, kMost); }
  /// The number in [least, most], to which one outside is taken: in silence what rounding may have
  /// moved.
  double number_within(double without, double least, double most) const;
  /// At least 0.
  double amount(double without) const { return number_within(without, 0, kMost); }
  /// The number where it is above 0; nothing for no value and, with a warning, for another one.
  std::optional<double> above_zero() const;
  /// A whole number of 0 or more, with a warning for another value.
  std::optional<uint64_t> whole() const;
  /// The same without a warning.
  std::optional<uint64_t> if_whole() const;
  /// The same of one that has to be there; throws where it is none.
  uint64_t required_whole() const;
  /// An index below `count` of `what`, with a warning for another one; nothing for -1, which some
  /// programs write for none.
  std::optional<size_t> index(size_t count, const char* what,
                              std::string_view taken = "it is left out") const;
  std::string text(const std::string& without) const;
  bool flag(bool without) const;
  /// As many numbers in [least, most] as `without` has, and each of those stands for one that is
  /// not there; the first ones of more.
  std::vector<double> numbers(std::vector<double> without, double least = -kMost,
                              double most = kMost) const;

  const std::string& path() const { return path_; }
  /// An absent value has the place of the nearest one that is there.
  SourcePlace place() const;
  Error error(std::string_view found, std::string_view expected) const;
  /// Warns that the value is `found` where `expected` is the rule, and what is `taken` for it.
  void repair(std::string_view found, std::string_view expected, std::string_view taken) const;
  /// The value as messages show it: the number or, in quotes, the text; of others the type.
  std::string shown() const;

 private:
  GltfValue step(const nlohmann::json* to, std::string path) const;
  void leave_out(std::string_view expected) const;

  const nlohmann::json* json_;
  GltfText* text_;
  std::string path_;  ///< "meshes/0/name"
};

/// The line and column, from 1, of the value with that path in a well-formed JSON text; 0 where it
/// is not there.
std::pair<int, int> find_json_place(std::string_view text, std::string_view path);

}  // namespace tessera
