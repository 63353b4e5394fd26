#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace tessera {

/// The JSON text of a glTF file, so that errors can name a place in it.
struct GltfText {
  std::string name;         ///< of the file
  std::string_view text{};  ///< empty in a .glb, whose JSON is no text with lines
};

/// A value of a glTF file's JSON, or of none where a member is absent. It knows where it stands:
/// what is of the wrong type, or out of range, is a located error. Refers to the document.
class GltfValue {
 public:
  GltfValue(const nlohmann::json* json, const GltfText* text, std::string path)
      : json_(json), text_(text), path_(std::move(path)) {}

  explicit operator bool() const { return json_ != nullptr; }
  /// Both give no value where there is none.
  GltfValue operator[](const char* key) const;
  GltfValue at(size_t index) const;
  size_t size() const;  ///< of an array; 0 where there is none
  std::vector<std::string> keys() const;

  double number(double without) const;
  std::optional<uint64_t> whole() const;
  uint64_t required_whole() const;
  /// An index below `count` of `what`.
  std::optional<size_t> index(size_t count, const char* what) const;
  std::string text(const std::string& without) const;
  bool flag(bool without) const;
  /// Exactly `count` finite numbers; nothing where there is no value.
  std::optional<std::vector<double>> numbers(size_t count) const;

  const std::string& path() const { return path_; }
  /// An absent value has the place of the nearest one that is there.
  SourcePlace place() const;
  Error error(std::string_view found, std::string_view expected) const;

 private:
  Error wrong_type(std::string_view expected) const;

  const nlohmann::json* json_;
  const GltfText* text_;
  std::string path_;  ///< "meshes/0/name"
};

/// The line and column, from 1, of the value with that path in a well-formed JSON text; 0 where it
/// is not there.
std::pair<int, int> find_json_place(std::string_view text, std::string_view path);

}  // namespace tessera
