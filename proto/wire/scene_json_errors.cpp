#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/scene_codec.h"
#include "proto/wire/scene_errors.h"
#include "proto/wire/scene_place.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;
using Json = nlohmann::json;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A number as JSON writes it, infinite where double precision does not hold it.
std::optional<double> number_of(std::string_view written) {
  const std::string_view digits = written.substr(written.starts_with('-') ? 1 : 0);
  const size_t fraction = digits.find('.') + 1;
  const bool is_written_so =
      !digits.empty() && is_digit(digits[0]) &&
      !(digits[0] == '0' && digits.size() > 1 && is_digit(digits[1])) &&
      (fraction == 0 || (fraction < digits.size() && is_digit(digits[fraction])));
  double number = 0;
  const char* const end = written.data() + written.size();
  const auto [read, error] = std::from_chars(written.data(), end, number);
  if (!is_written_so || read != end) return std::nullopt;
  return error == std::errc::result_out_of_range ? HUGE_VAL : number;
}

/// The value that a word or a text in quotes is; a discarded one where it is none.
Json scalar_json(std::string_view written) {
  if (written.starts_with('"')) return Json::parse(written, nullptr, false);
  if (written == "null") return nullptr;
  if (written == "true" || written == "false") return written == "true";
  const auto number = number_of(written);
  return number ? Json(*number) : Json(Json::value_t::discarded);
}

/// A number of that type, or one in quotes, as protobuf takes it.
template <class Number>
bool is_number(const Json& value) {
  double number = 0;
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    if (std::is_floating_point_v<Number> &&
        (text == "NaN" || text == "Infinity" || text == "-Infinity"))
      return true;
    Number exact{};
    const char* const end = text.data() + text.size();
    const auto [read, error] = std::from_chars(text.data(), end, exact);
    return error == std::errc{} && read == end;
  }
  if (!value.is_number()) return false;
  number = value.get<double>();
  if constexpr (std::is_floating_point_v<Number>)
    return std::abs(number) <= double{std::numeric_limits<Number>::max()};
  else {
    // 2^digits, beyond the greatest of the type, is exact.
    const double end = std::ldexp(1., std::numeric_limits<Number>::digits);
    return number == std::trunc(number) && number < end &&
           number >= (std::is_signed_v<Number> ? -end : 0);
  }
}

/// Whether `value`, no object and no list, may stand for the field or an element of it.
bool is_value_of(const pb::FieldDescriptor& field, const Json& value) {
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_MESSAGE:
      return false;
    case pb::FieldDescriptor::CPPTYPE_STRING:
      return value.is_string();
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      return value.is_boolean();
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return is_number<double>(value);
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return is_number<float>(value);
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      return value.is_string() ? field.enum_type()->FindValueByName(value) != nullptr
                               : is_number<int32_t>(value);
    case pb::FieldDescriptor::CPPTYPE_INT32:
      return is_number<int32_t>(value);
    case pb::FieldDescriptor::CPPTYPE_UINT32:
      return is_number<uint32_t>(value);
    case pb::FieldDescriptor::CPPTYPE_INT64:
      return is_number<int64_t>(value);
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      return is_number<uint64_t>(value);
  }
  return false;
}

/// What may stand for the field or an element of it, where that is not `written`.
std::string expected_value(const pb::FieldDescriptor& field, const std::string& written) {
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_MESSAGE:
      return fmt::format("the fields of a {} in braces", field.message_type()->name());
    case pb::FieldDescriptor::CPPTYPE_STRING:
      return "a text in double quotes";
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      return "true or false";
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return "a number";
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return "a number that single precision can hold";
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      return one_of(value_names(*field.enum_type()), written);
    default:
      return "an integer in the field's range";
  }
}

/// As a message names it: of what is long the beginning.
std::string shown(std::string_view written) {
  constexpr size_t kShown = 60;
  return std::string(written.substr(0, kShown)) + (written.size() > kShown ? "..." : "");
}

bool is_list(const pb::FieldDescriptor& field) { return field.is_repeated() && !field.is_map(); }

/// Where what is of `path` stands. Text that nobody wrote, of no file, has no lines to tell.
SourcePlace json_place(const std::string& file, std::string_view text, size_t at,
                       const std::string& path) {
  if (!file.empty()) return place_of(file, text, at);
  return {path.empty() ? "description" : path};
}

/// Walks JSON along the message type that it stands for. Protobuf's own parser reports paths but
/// no lines, so this finds the faults of form, names and types first, and the place of any path.
class SceneJson {
 public:
  SceneJson(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  void walk(std::string target) {
    target_ = std::move(target);
    faults_.attempt([&] {
      fields(*v1::Scene::descriptor(), "", 0);
      skip_space();
      if (at_ != text_.size()) fail("text after the scene's end", "nothing more");
    });
    faults_.throw_if_any();
  }
  /// Of the target, or of the innermost value around it.
  size_t target_offset() const { return target_offset_; }

 private:
  [[noreturn]] void fail_at(size_t at, std::string_view found, std::string_view expected) const {
    throw scene_error(place_of(file_, text_, at), found, expected);
  }
  /// Tells of what the rest of the text can be read beside, and which is of `path`.
  void note(size_t at, const std::string& path, std::string_view found, std::string_view expected) {
    if (faults_.has_more()) return;
    faults_.add(scene_error(json_place(file_, text_, at, path), found, expected));
  }
  [[noreturn]] void fail(std::string_view found, std::string_view expected) const {
    fail_at(at_, found, expected);
  }
  [[noreturn]] void fail_here(std::string_view expected) const {
    if (at_ >= text_.size()) fail("the text ends here", expected);
    fail(fmt::format("'{}'", text_[at_]), expected);
  }
  void skip_space() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != text_.npos) ++at_;
  }
  bool take(char c) {
    skip_space();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c, std::string_view expected) {
    if (!take(c)) fail_here(expected);
  }
  void meet(const std::string& path) {
    skip_space();
    if (path.size() <= met_ || !target_.starts_with(path)) return;
    if (path.size() < target_.size() &&
        std::string_view(".[").find(target_[path.size()]) == target_.npos)
      return;
    met_ = path.size();
    target_offset_ = at_;
  }

  /// What stands there: a text in quotes, or a word such as a number.
  std::string_view scalar(std::string_view expected) {
    skip_space();
    const size_t start = at_;
    if (at_ < text_.size() && text_[at_] == '"') {
      ++at_;
      while (at_ < text_.size() && text_[at_] != '"' && text_[at_] != '\n')
        at_ += text_[at_] == '\\' ? 2 : 1;
      if (at_ >= text_.size() || text_[at_] != '"')
        fail_at(start, "a text that does not end on its line", "'\"'");
      ++at_;
    } else {
      while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) ||
                                    std::string_view("+-.").find(text_[at_]) != text_.npos))
        ++at_;
    }
    if (start == at_) fail_here(expected);
    return text_.substr(start, at_ - start);
  }

  std::string key() {
    constexpr const char* kExpected = "a text in double quotes";
    skip_space();
    const size_t start = at_;
    if (at_ < text_.size() && text_[at_] != '"') fail_here(kExpected);
    const std::string_view written = scalar(kExpected);
    const Json parsed = scalar_json(written);
    if (!parsed.is_string()) fail_at(start, written, "a text as JSON writes it");
    return parsed;
  }

  /// Of `field`, as an element of it `in_list`; null: of nothing that is known.
  void value(const pb::FieldDescriptor* field, const std::string& path, int depth, bool in_list) {
    meet(path);
    const char first = at_ < text_.size() ? text_[at_] : ' ';
    if (first == '{' || first == '[') {
      const bool is_right =
          !field || (first == '[' ? is_list(*field) && !in_list
                                  : field->message_type() && (in_list || !is_list(*field)));
      if (!is_right) tell_type(at_, path, first == '{' ? "an object" : "a list", *field, in_list);
      if (first == '[') return array(is_right ? field : nullptr, path, depth);
      return object(is_right ? field : nullptr, path, depth);
    }
    const size_t start = at_;
    const std::string_view written = scalar("a value");
    const Json parsed = scalar_json(written);
    if (parsed.is_discarded() && written.starts_with('"'))
      return note(start, path, shown(written), "a text as JSON writes it");
    if (parsed.is_discarded() && !field) return note(start, path, written, "a value");
    if (parsed.is_number() && std::isinf(parsed.get<double>()))
      return note(start, path, written, "a number that double precision can hold");
    if (!field || parsed.is_null()) return;
    if (field->is_map() || (is_list(*field) && !in_list) || !is_value_of(*field, parsed))
      tell_type(start, path, shown(written), *field, in_list, parsed);
  }

  void tell_type(size_t at, const std::string& path, std::string_view written,
                 const pb::FieldDescriptor& field, bool in_list, const Json& parsed = nullptr) {
    if (is_list(field) && !in_list) return note(at, path, written, "a list in brackets");
    if (field.is_map()) return note(at, path, written, "names and values in braces");
    const std::string name = field.enum_type() && parsed.is_string() ? parsed : "";
    const std::string expected = expected_value(field, name);
    if (name.empty()) return note(at, path, written, expected);
    note(at, path, fmt::format("'{}' is no value of {}", name, field.name()), expected);
  }

  void array(const pb::FieldDescriptor* field, const std::string& path, int depth) {
    expect('[', "'['");
    if (take(']')) return;
    for (int i = 0;; ++i) {
      skip_space();
      if (at_ < text_.size() && text_[at_] == '[')
        throw scene_error(json_place(file_, text_, at_, path), "a list in a list", "a value");
      // Protobuf would leave it out, and count the others anew.
      const std::string element = fmt::format("{}[{}]", path, i);
      if (text_.substr(at_).starts_with("null")) note(at_, element, "null", "a value");
      value(field, element, depth, true);
      if (take(']')) return;
      expect(',', "',' or ']'");
    }
  }

  const pb::FieldDescriptor* field_of(const pb::Descriptor& type, const std::string& key, size_t at,
                                      const std::string& path) {
    if (const auto* field = type.FindFieldByName(key)) return field;
    for (int i = 0; i < type.field_count(); ++i)
      if (type.field(i)->json_name() == key) return type.field(i);
    const auto names = field_names(type);
    note(at, path, fmt::format("'{}' is no field of {}", key, type.name()), one_of(names, key));
    return nullptr;
  }

  void note_twice(size_t at, const std::string& path, const std::string& key) {
    note(at, path, fmt::format("'{}' is given twice", key), "each field once");
  }

  /// The names and values of a message, of a map, or of nothing that is known.
  void object(const pb::FieldDescriptor* of, const std::string& path, int depth) {
    if (depth == kMaxSceneDepth)
      throw scene_error(json_place(file_, text_, at_, path), "values nested too deep",
                        fmt::format("at most {} levels", kMaxSceneDepth));
    if (of && !of->is_map()) return fields(*of->message_type(), path, depth + 1);
    std::set<std::string> given;
    entries([&](size_t at, const std::string& key) {
      if (!given.insert(key).second) note_twice(at, path, key);
      value(of ? of->message_type()->map_value() : nullptr, path + "." + key, depth + 1, false);
    });
  }

  void fields(const pb::Descriptor& type, const std::string& path, int depth) {
    std::set<const pb::FieldDescriptor*> given;
    std::set<const pb::OneofDescriptor*> chosen;
    entries([&](size_t at, const std::string& key) {
      const auto* field = field_of(type, key, at, path);
      const bool is_new = !field || given.insert(field).second;
      if (!is_new) note_twice(at, path, key);
      skip_space();
      const bool is_choice = field && is_new && !text_.substr(at_).starts_with("null");
      const auto* kind = is_choice ? field->real_containing_oneof() : nullptr;
      if (kind && !chosen.insert(kind).second)
        note(at, path, fmt::format("'{}' beside another of its kind", key), "only one of them");
      const std::string& name = field ? field->name() : key;
      value(field, path.empty() ? name : path + "." + name, depth, false);
    });
  }

  template <class Visit>  // (offset of the name, name): goes past the value
  void entries(const Visit& visit) {
    expect('{', "'{'");
    if (take('}')) return;
    for (;;) {
      skip_space();
      const size_t at = at_;
      const std::string name = key();
      expect(':', "':'");
      visit(at, name);
      if (take('}')) return;
      expect(',', "',' or '}'");
    }
  }

  std::string_view text_;
  const std::string& file_;
  std::string target_;
  size_t met_ = 0;  ///< the longest beginning of `target_` that was found
  size_t target_offset_ = 0;
  AllFailures faults_{kMostFaults};
  size_t at_ = 0;
};

}  // namespace

void check_scene_json(std::string_view text, const std::string& file) {
  SceneJson(text, file).walk("");
}

SourcePlace place_in_json(const std::string& file, std::string_view text, const std::string& path) {
  SceneJson json(text, file);
  json.walk(path);
  return json_place(file, text, json.target_offset(), path);
}

Error scene_json_error(const std::string& file, std::string_view text, std::string_view message) {
  const size_t close = message.find("): ");
  if (!message.starts_with('(') || close == message.npos)
    return scene_error({file}, message, "a scene in JSON");
  std::string path;
  for (const char c : message.substr(1, close - 1)) {
    if (std::isupper(static_cast<unsigned char>(c))) path += '_';
    path += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return scene_error(place_in_json(file, text, path), shown(message.substr(close + 3)),
                     "a value of the field's type");
}

}  // namespace tessera
