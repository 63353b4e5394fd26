#include "scenes/formats/gltf/gltf_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
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

/// How far single precision may move a number, of 1 or its own size.
constexpr double kSinglePrecision = 1e-6;

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
  if (json_ && !json_->is_object()) leave_out("an object");
  if (!json_ || !json_->is_object()) return {nullptr, text_, path_};
  const auto found = json_->find(key);
  const bool is_there = found != json_->end() && !found->is_null();
  std::string path = path_.empty() ? key : fmt::format("{}/{}", path_, key);
  return {is_there ? &*found : nullptr, text_, std::move(path)};
}

GltfValue GltfValue::at(size_t index) const {
  const nlohmann::json& element = (*json_)[index];
  return {element.is_null() ? nullptr : &element, text_, fmt::format("{}/{}", path_, index)};
}

size_t GltfValue::size() const {
  if (!json_) return 0;
  if (json_->is_array()) return json_->size();
  leave_out("an array");
  return 0;
}

std::vector<std::string> GltfValue::keys() const {
  std::vector<std::string> names;
  if (!json_ || !json_->is_object()) return names;
  for (const auto& item : json_->items()) names.push_back(item.key());
  return names;
}

double GltfValue::number(double without) const {
  if (!json_) return without;
  if (json_->is_number()) return json_->get<double>();
  leave_out("a number");
  return without;
}

double GltfValue::number_within(double without, double least, double most) const {
  const double value = number(without);
  if (value >= least && value <= most) return value;
  const double nearest = value < least ? least : most;
  // Exporters count in single precision.
  if (std::abs(value - nearest) > kSinglePrecision * std::max(1.0, std::abs(nearest)))
    repair(
        fmt::format("{}", value),
        std::isinf(most) ? fmt::format("{} or more", least) : fmt::format("{} to {}", least, most),
        fmt::format("{} is taken", nearest));
  return nearest;
}

double GltfValue::amount(double without) const {
  return number_within(without, 0, std::numeric_limits<double>::infinity());
}

std::optional<uint64_t> GltfValue::if_whole() const {
  if (!json_ || !json_->is_number()) return std::nullopt;
  if (json_->is_number_unsigned()) return json_->get<uint64_t>();
  // Some programs write whole numbers as 3.0.
  constexpr double kLargest = 9007199254740992;
  const double value = json_->get<double>();
  if (!(value >= 0 && value <= kLargest) ||
      std::abs(value - std::round(value)) > kSinglePrecision * std::max(1.0, value))
    return std::nullopt;
  return static_cast<uint64_t>(std::round(value));
}

std::optional<uint64_t> GltfValue::whole() const {
  const auto value = if_whole();
  if (json_ && !value) repair(shown(), "a whole number", "it is left out");
  return value;
}

uint64_t GltfValue::required_whole() const {
  const auto value = if_whole();
  if (!value) throw error(shown(), "a whole number");
  return *value;
}

std::optional<size_t> GltfValue::index(size_t count, const char* what,
                                       std::string_view taken) const {
  if (json_ && json_->is_number() && json_->get<double>() == -1) {
    repair("-1", fmt::format("a {}, or no value", what), taken);
    return std::nullopt;
  }
  const auto value = whole();
  if (!value || *value < count) return value;
  repair(fmt::format("{} {}", what, *value),
         count == 0 ? fmt::format("a file with {}s", what) : fmt::format("0 to {}", count - 1),
         taken);
  return std::nullopt;
}

std::string GltfValue::text(const std::string& without) const {
  if (!json_) return without;
  if (json_->is_string()) return json_->get_ref<const std::string&>();
  leave_out("text");
  return without;
}

bool GltfValue::flag(bool without) const {
  if (!json_) return without;
  if (json_->is_boolean()) return json_->get<bool>();
  leave_out("true or false");
  return without;
}

std::optional<std::vector<double>> GltfValue::numbers(size_t count) const {
  if (!json_ || (!json_->is_array() && size() == 0)) return std::nullopt;
  if (size() != count)
    repair(fmt::format("{} numbers", size()), fmt::format("{}", count),
           size() < count ? "they are left out" : "the first ones are taken");
  if (size() < count) return std::nullopt;
  std::vector<double> values;
  for (size_t i = 0; i < count; ++i) values.push_back(at(i).number(0));
  return values;
}

std::string GltfValue::shown() const {
  if (!json_) return "no value";
  return json_->is_number() ? fmt::format("{}", json_->get<double>()) : type_name(*json_);
}

void GltfValue::leave_out(std::string_view expected) const {
  repair(type_name(*json_), expected, "it is left out");
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
  constexpr int kMostPlaces = 50;  // finding one takes time in the length of the text
  return scene_error(text_->errors++ < kMostPlaces ? place() : SourcePlace{text_->name},
                     path_.empty() ? std::string(found) : fmt::format("{}: {}", path_, found),
                     expected);
}

void GltfValue::repair(std::string_view found, std::string_view expected,
                       std::string_view taken) const {
  if (!text_->told.insert(fmt::format("{}\n{}", path_, expected)).second) return;
  text_->warnings.repair(
      found, expected, taken, [&] { return place(); }, path_);
}

}  // namespace tessera
