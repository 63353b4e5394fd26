#include "scenes/formats/gltf/gltf_value.h"

#include <fmt/format.h>

#include <algorithm>
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

/// How far single precision may move a number, of 1 or its own size.
constexpr double kSinglePrecision = 1e-6;

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

GltfValue GltfValue::step(const nlohmann::json* to, std::string path) const {
  GltfValue value{to, text_, std::move(path)};
  if (to && to->is_null()) {
    value.leave_out("a value");
    value.json_ = nullptr;
  }
  return value;
}

GltfValue GltfValue::operator[](const char* key) const {
  if (json_ && !json_->is_object()) leave_out("an object");
  const bool is_object = json_ && json_->is_object();
  const auto found = is_object ? json_->find(key) : nlohmann::json::const_iterator();
  return step(is_object && found != json_->end() ? &*found : nullptr,
              path_.empty() ? key : fmt::format("{}/{}", path_, key));
}

GltfValue GltfValue::at(size_t index) const {
  return step(&(*json_)[index], fmt::format("{}/{}", path_, index));
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

double GltfValue::number_within(double without, double least, double most) const {
  if (!json_) return without;
  if (!json_->is_number()) {
    leave_out("a finite number");
    return without;
  }
  const double value = json_->get<double>(), nearest = std::clamp(value, least, most);
  // Exporters count in single precision.
  if (std::abs(value - nearest) > kSinglePrecision * std::max(1.0, std::abs(nearest)))
    repair(shown(),
           std::abs(nearest) == kMost ? "a number that single precision can hold"
           : most == kMost            ? fmt::format("{} or more", least)
                                      : fmt::format("{} to {}", least, most),
           fmt::format("{} is taken", nearest));
  return nearest;
}

std::optional<double> GltfValue::above_zero() const {
  const double value = number(std::numeric_limits<double>::quiet_NaN());
  if (value > 0) return value;
  if (value <= 0) leave_out("a number above 0");
  return std::nullopt;
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

std::vector<double> GltfValue::numbers(std::vector<double> without, double least,
                                       double most) const {
  const size_t given = size();
  if (!json_ || !json_->is_array()) return without;
  if (given != without.size())
    repair(fmt::format("an array of {}", given), fmt::format("{} numbers", without.size()),
           given < without.size() ? "the others are the default" : "the first ones are taken");
  for (size_t i = 0; i < std::min(given, without.size()); ++i)
    without[i] = at(i).number_within(without[i], least, most);
  return without;
}

std::string GltfValue::shown() const {
  constexpr size_t kLongest = 40;
  if (!json_) return "no value";
  if (json_->is_structured()) return fmt::format("an {}", json_->type_name());
  if (!json_->is_string())
    return json_->is_number() ? fmt::format("{}", json_->get<double>()) : json_->dump();
  const auto& text = json_->get_ref<const std::string&>();
  return fmt::format("'{}{}'", to_utf8(text.substr(0, kLongest)),
                     text.size() > kLongest ? "..." : "");
}

void GltfValue::leave_out(std::string_view expected) const {
  repair(shown(), expected, "it is left out");
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
