#include "scenes/formats/gltf/gltf_value.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/file.h"

namespace tessera {
namespace {

/// Walks over JSON that a parser has found to be well-formed.
class JsonScanner {
 public:
  explicit JsonScanner(std::string_view text) : text_(text) {}

  /// Goes to the member `step` of the value here; false where there is none.
  bool enter(std::string_view step) {
    space();
    const bool object = peek() == '{';
    if (!object && peek() != '[') return false;
    ++at_;
    for (size_t i = 0; at_ < text_.size(); ++i) {
      space();
      if (peek() == '}' || peek() == ']') return false;
      std::string_view key;
      if (object) {
        const size_t begin = at_;
        skip();
        key = text_.substr(begin + 1, at_ - begin - 2);
        space();
        ++at_;  // the colon
        space();
      }
      if (object ? key == step : std::to_string(i) == step) return true;
      skip();
      space();
      if (peek() == ',') ++at_;
    }
    return false;
  }

  size_t offset() const { return at_; }

 private:
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void space() {
    while (peek() == ' ' || peek() == '\t' || peek() == '\n' || peek() == '\r') ++at_;
  }

  /// Goes behind the value here.
  void skip() {
    int depth = 0;
    do {
      space();
      if (peek() == '"') {
        for (++at_; at_ < text_.size() && peek() != '"'; ++at_)
          if (peek() == '\\') ++at_;
        ++at_;
      } else if (peek() == '{' || peek() == '[') {
        ++depth, ++at_;
      } else if (peek() == '}' || peek() == ']') {
        --depth, ++at_;
      } else if (peek() == ',' || peek() == ':') {
        ++at_;
      } else {
        while (at_ < text_.size() && std::string_view(" \t\r\n,:{}[]\"").find(peek()) == text_.npos)
          ++at_;
      }
    } while (depth > 0 && at_ < text_.size());
  }

  std::string_view text_;
  size_t at_ = 0;
};

std::string type_name(const nlohmann::json& json) {
  return fmt::format("a value of type {}", json.type_name());
}

}  // namespace

std::pair<int, int> find_json_place(std::string_view text, std::string_view path) {
  JsonScanner scanner(text);
  while (!path.empty()) {
    const size_t slash = path.find('/');
    if (!scanner.enter(path.substr(0, slash))) return {0, 0};
    path = slash == std::string_view::npos ? "" : path.substr(slash + 1);
  }
  int line = 1;
  size_t begin = 0;
  for (size_t i = 0; i < scanner.offset(); ++i)
    if (text[i] == '\n') ++line, begin = i + 1;
  return {line, static_cast<int>(scanner.offset() - begin) + 1};
}

GltfValue GltfValue::operator[](const char* key) const {
  if (!json_) return {nullptr, text_, path_};
  if (!json_->is_object()) throw wrong_type("an object");
  const auto found = json_->find(key);
  std::string path = path_.empty() ? key : fmt::format("{}/{}", path_, key);
  return {found == json_->end() ? nullptr : &*found, text_, std::move(path)};
}

GltfValue GltfValue::at(size_t index) const {
  return {&(*json_)[index], text_, fmt::format("{}/{}", path_, index)};
}

size_t GltfValue::size() const {
  if (!json_) return 0;
  if (!json_->is_array()) throw wrong_type("an array");
  return json_->size();
}

std::vector<std::string> GltfValue::keys() const {
  std::vector<std::string> names;
  if (!json_) return names;
  if (!json_->is_object()) throw wrong_type("an object");
  for (const auto& item : json_->items()) names.push_back(item.key());
  return names;
}

double GltfValue::number(double without) const {
  if (!json_) return without;
  if (!json_->is_number()) throw wrong_type("a number");
  const double value = json_->get<double>();
  if (!std::isfinite(value)) throw error("an endless number", "a finite one");
  return value;
}

std::optional<uint64_t> GltfValue::whole() const {
  if (!json_) return std::nullopt;
  if (json_->is_number_unsigned()) return json_->get<uint64_t>();
  // Some programs write whole numbers as 3.0.
  constexpr double kLargest = 9007199254740992;
  const double value = number(0);
  if (!(value >= 0 && value <= kLargest) || value != std::floor(value))
    throw error(fmt::format("{}", value), "a whole number");
  return static_cast<uint64_t>(value);
}

uint64_t GltfValue::required_whole() const {
  const auto value = whole();
  if (!value) throw error("no value", "a whole number");
  return *value;
}

std::optional<size_t> GltfValue::index(size_t count, const char* what) const {
  const auto value = whole();
  if (value && *value >= count)
    throw error(fmt::format("{} {}", what, *value), count == 0
                                                        ? fmt::format("a file with {}s", what)
                                                        : fmt::format("0 to {}", count - 1));
  return value;
}

std::string GltfValue::text(const std::string& without) const {
  if (!json_) return without;
  if (!json_->is_string()) throw wrong_type("text");
  return json_->get_ref<const std::string&>();
}

bool GltfValue::flag(bool without) const {
  if (!json_) return without;
  if (!json_->is_boolean()) throw wrong_type("true or false");
  return json_->get<bool>();
}

std::optional<std::vector<double>> GltfValue::numbers(size_t count) const {
  if (!json_) return std::nullopt;
  if (size() != count) throw error(fmt::format("{} numbers", size()), fmt::format("{}", count));
  std::vector<double> values;
  for (size_t i = 0; i < count; ++i) values.push_back(at(i).number(0));
  return values;
}

Error GltfValue::wrong_type(std::string_view expected) const {
  return error(type_name(*json_), expected);
}

SourcePlace GltfValue::place() const {
  SourcePlace place{text_->name};
  for (std::string path = path_; place.line == 0 && !path.empty();) {
    std::tie(place.line, place.column) = find_json_place(text_->text, path);
    const size_t slash = path.rfind('/');
    path.resize(slash == std::string::npos ? 0 : slash);
  }
  return place;
}

Error GltfValue::error(std::string_view found, std::string_view expected) const {
  return scene_error(
      place(), path_.empty() ? std::string(found) : fmt::format("{}: {}", path_, found), expected);
}

}  // namespace tessera
