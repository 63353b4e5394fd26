#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <set>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/scene_codec.h"
#include "proto/wire/scene_errors.h"
#include "proto/wire/scene_place.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;

/// Names of fields as scene.proto writes them: "edge_u" for "edgeU".
std::string with_proto_names(std::string_view path) {
  std::string result;
  for (const char c : path) {
    if (std::isupper(static_cast<unsigned char>(c))) result += '_';
    result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return result;
}

/// Walks JSON along the message type that it stands for. Protobuf's own parser reports paths but
/// no lines, so this finds the faults of form and of names first, and the place of any path.
class SceneJson {
 public:
  SceneJson(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  void walk(std::string target) {
    target_ = std::move(target);
    faults_.attempt([&] {
      object(v1::Scene::descriptor(), "", 0);
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
  /// Tells of what the rest of the text can be read beside.
  void note(size_t at, std::string_view found, std::string_view expected) {
    if (!faults_.has_more()) faults_.add(scene_error(place_of(file_, text_, at), found, expected));
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

  std::string string() {
    skip_space();
    const size_t open = at_;
    expect('"', "a text in double quotes");
    while (at_ < text_.size() && text_[at_] != '"' && text_[at_] != '\n')
      at_ += text_[at_] == '\\' ? 2 : 1;
    if (at_ >= text_.size() || text_[at_] != '"')
      fail_at(open, "a text that does not end on its line", "'\"'");
    ++at_;
    return std::string(text_.substr(open + 1, at_ - open - 2));
  }

  void scalar() {
    if (at_ < text_.size() && text_[at_] == '"') {
      string();
      return;
    }
    const size_t start = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) ||
                                  std::string_view("+-.").find(text_[at_]) != text_.npos))
      ++at_;
    if (start == at_) fail_here("a value");
    double number = 0;
    const auto parsed = std::from_chars(text_.data() + start, text_.data() + at_, number);
    if (parsed.ec == std::errc::result_out_of_range)
      note(start, text_.substr(start, at_ - start), "a number that double precision can hold");
  }

  void value(const pb::FieldDescriptor* field, const std::string& path, int depth) {
    meet(path);
    if (at_ < text_.size() && text_[at_] == '{') {
      if (depth == kMaxSceneDepth)
        fail("values nested too deep", fmt::format("at most {} levels", kMaxSceneDepth));
      return object(field && !field->is_map() ? field->message_type() : nullptr, path, depth + 1);
    }
    if (at_ < text_.size() && text_[at_] == '[') return array(field, path, depth);
    const size_t start = at_;
    scalar();
    const std::string_view written = text_.substr(start, at_ - start);
    if (field && field->cpp_type() == pb::FieldDescriptor::CPPTYPE_BOOL && !field->is_map() &&
        written != "true" && written != "false" && written != "null")
      note(start, written, "true or false");
    if (!field || !field->enum_type() || text_[start] != '"') return;
    const std::string name(text_.substr(start + 1, at_ - start - 2));
    if (field->enum_type()->FindValueByName(name)) return;
    const auto names = value_names(*field->enum_type());
    note(start, fmt::format("'{}' is no value of {}", name, field->name()), one_of(names, name));
  }

  void array(const pb::FieldDescriptor* field, const std::string& path, int depth) {
    expect('[', "'['");
    if (take(']')) return;
    for (int i = 0;; ++i) {
      skip_space();
      if (at_ < text_.size() && text_[at_] == '[') fail("a list in a list", "a value");
      // Protobuf would leave it out, and count the others anew.
      if (text_.substr(at_).starts_with("null")) note(at_, "null", "a value");
      value(field, fmt::format("{}[{}]", path, i), depth);
      if (take(']')) return;
      expect(',', "',' or ']'");
    }
  }

  const pb::FieldDescriptor* field_of(const pb::Descriptor* type, const std::string& key,
                                      size_t at) {
    if (!type) return nullptr;
    if (const auto* field = type->FindFieldByName(key)) return field;
    for (int i = 0; i < type->field_count(); ++i)
      if (type->field(i)->json_name() == key) return type->field(i);
    const auto names = field_names(*type);
    note(at, fmt::format("'{}' is no field of {}", key, type->name()), one_of(names, key));
    return nullptr;
  }

  void object(const pb::Descriptor* type, const std::string& path, int depth) {
    expect('{', "'{'");
    if (take('}')) return;
    std::set<std::string> given;
    for (;;) {
      skip_space();
      const size_t at = at_;
      const std::string key = string();
      const auto* field = field_of(type, key, at);
      expect(':', "':'");
      const std::string& name = field ? field->name() : key;
      if (!given.insert(name).second)
        note(at, fmt::format("'{}' is given twice", key), "each field once");
      value(field, path.empty() ? name : path + "." + name, depth);
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
  return place_of(file, text, json.target_offset());
}

Error scene_json_error(const std::string& file, std::string_view text, const std::string& message) {
  const size_t open = message.find('(');
  const size_t close = message.find(')', open);
  const std::string first_line = message.substr(0, message.find('\n'));
  if (open != 0 || close == std::string::npos)
    return scene_error({file}, first_line, "a scene in JSON");
  const std::string path = message.substr(1, close - 1);
  std::string found = message.substr(std::min(message.size(), close + 1));
  if (found.starts_with(": ")) found = found.substr(2);
  std::string expected = "a value of the field's type";
  if (const size_t type = found.find(" for type "); type != std::string::npos) found.resize(type);
  if (const size_t oneof = found.find("oneof field '_"); oneof != std::string::npos) {
    found = "a field is given twice";
    expected = "each field once";
  } else if (found.find("oneof field '") != std::string::npos) {
    found = found.substr(found.find("Cannot set '") + 11) + " beside another of its kind";
    expected = "only one of them";
  }
  return scene_error(place_in_json(file, text, with_proto_names(path)),
                     fmt::format("{}: {}", path, found), expected);
}

}  // namespace tessera
