#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/scene_codec.h"
#include "proto/wire/scene_errors.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;

/// How the parser's warnings of what no scene has begin.
constexpr std::string_view kUnknownField = "Message type";
constexpr std::string_view kUnknownExtension = "Ignoring extension";

/// The parts of `message` in double quotes.
std::vector<std::string> quoted_parts(const std::string& message) {
  std::vector<std::string> parts;
  for (size_t open = message.find('"'); open != std::string::npos;) {
    const size_t close = message.find('"', open + 1);
    if (close == std::string::npos) break;
    parts.push_back(message.substr(open + 1, close - open - 1));
    open = message.find('"', close + 1);
  }
  return parts;
}

/// Some enumeration of the scene that a field of that name has; null where there is none.
const pb::EnumDescriptor* enum_of_field(const pb::Descriptor& type, const std::string& field) {
  for (int i = 0; i < type.field_count(); ++i)
    if (type.field(i)->name() == field && type.field(i)->enum_type())
      return type.field(i)->enum_type();
  for (int i = 0; i < type.nested_type_count(); ++i)
    if (const auto* found = enum_of_field(*type.nested_type(i), field)) return found;
  return nullptr;
}

const pb::EnumDescriptor* enum_of_field(const std::string& field) {
  const pb::FileDescriptor& file = *v1::Scene::descriptor()->file();
  for (int i = 0; i < file.message_type_count(); ++i)
    if (const auto* found = enum_of_field(*file.message_type(i), field)) return found;
  return nullptr;
}

struct Complaint {
  std::string found, expected;
  std::string culprit;  ///< what stands at the place meant, where the parser is already past it
};

/// "Expected X, got: Y" and "Expected X, found Y."
Complaint expectation(const std::string& message) {
  const size_t comma = message.find(", ");
  std::string expected = message.substr(9, comma - 9);
  std::string found = comma == std::string::npos ? "" : message.substr(comma + 2);
  if (found.starts_with("got: ")) found = found.substr(5);
  if (found.starts_with("found ")) found = found.substr(6, found.size() - 7);
  if (found.size() >= 2 && found.front() == '"') found = found.substr(1, found.size() - 2);
  if (expected.size() >= 2 && expected.front() == '"')
    expected = fmt::format("'{}'", expected.substr(1, expected.size() - 2));
  if (expected == "identifier") expected = "a field's name";
  if (expected == "integer") expected = "an integer in the field's range";
  if (expected == "double" || expected == "float") expected = "a number";
  if (expected == "string") expected = "a text in quotes";
  return {found.empty() ? "the text ends here" : fmt::format("'{}'", found), expected, ""};
}

Complaint reword(const std::string& message) {
  const auto quoted = quoted_parts(message);
  if (message.starts_with(kUnknownField) && quoted.size() == 2) {
    const auto* type = v1::Scene::descriptor()->file()->pool()->FindMessageTypeByName(quoted[0]);
    const auto names = type ? field_names(*type) : std::vector<std::string>{};
    const size_t dot = quoted[0].rfind('.');
    return {fmt::format("'{}' is no field of {}", quoted[1], quoted[0].substr(dot + 1)),
            one_of(names, quoted[1]), quoted[1]};
  }
  if (message.starts_with("Unknown enumeration") && quoted.size() == 2) {
    const auto* type = enum_of_field(quoted[1]);
    const auto names = type ? value_names(*type) : std::vector<std::string>{};
    return {fmt::format("'{}' is no value of {}", quoted[0], quoted[1]), one_of(names, quoted[0]),
            quoted[0]};
  }
  if (message.starts_with("Field") && quoted.size() == 3)
    return {fmt::format("'{}' beside '{}'", quoted[0], quoted[1]),
            fmt::format("only one {}", quoted[2]), quoted[0]};
  if (message.starts_with("Non-repeated") && quoted.size() == 1)
    return {fmt::format("'{}' a second time", quoted[0]), "it once", quoted[0]};
  if (message.starts_with("Invalid value for boolean") && quoted.size() == 2)
    return {fmt::format("'{}'", quoted[1]), "true or false", quoted[1]};
  if (message.starts_with("Extension") || message.starts_with(kUnknownExtension))
    return {"'['", "a field's name", "["};
  // "Invalid float number: X" and "Cannot skip field value, unexpected token: X"
  if (message.starts_with("Invalid float") || message.starts_with("Cannot skip"))
    return {fmt::format("'{}'", message.substr(message.find(": ") + 2)), "a value", ""};
  if (message.starts_with("Message is too deep"))
    return {"messages nested too deep", fmt::format("at most {} levels", kMaxSceneDepth), ""};
  if (message.starts_with("Expected ")) return expectation(message);
  return {message, "", ""};
}

}  // namespace

size_t offset_of(std::string_view text, int line, int column) {
  size_t at = 0;
  for (; line > 0; --line) {
    const size_t end = text.find('\n', at);
    if (end == std::string_view::npos) return text.size();
    at = end + 1;
  }
  for (int reached = 0; reached < column && at < text.size() && text[at] != '\n'; ++at)
    reached = text[at] == '\t' ? (reached / 8 + 1) * 8 : reached + 1;
  return at;
}

SourcePlace place_of(const std::string& file, std::string_view text, size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
  return {file, 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')),
          static_cast<int>(before.size() - line_start) + 1};
}

std::vector<std::string> field_names(const pb::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  return names;
}

std::vector<std::string> value_names(const pb::EnumDescriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.value_count(); ++i) names.push_back(type.value(i)->name());
  return names;
}

std::string one_of(const std::vector<std::string>& names, const std::string& written) {
  if (names.empty()) return "";
  return fmt::format("one of {}{}", fmt::join(names, ", "), suggestion(written, names));
}

size_t TextErrors::place(int line, int column, const std::string& culprit) const {
  const size_t at = offset_of(text_, line, column);
  if (culprit.empty()) return at;
  const auto is_of_word = [this](size_t i) {
    return i < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[i])) || text_[i] == '_');
  };
  for (size_t found = text_.rfind(culprit, at); found != text_.npos;
       found = found == 0 ? text_.npos : text_.rfind(culprit, found - 1)) {
    // Not the beginning of another word.
    const size_t end = found + culprit.size();
    if (!is_of_word(end - 1) || !is_of_word(end)) return found;
  }
  return at;
}

void TextErrors::AddError(int line, int column, const std::string& message) {
  if (all_.has_more()) return;
  if (line < 0) return all_.add(scene_error({file_}, message, "a scene in text format"));
  const Complaint complaint = reword(message);
  const size_t at = place(line, column, complaint.culprit);
  // That an unknown field has no value is no fault of its own: its name may be half typed.
  const bool is_of_unknown =
      unknown_end_ <= at &&
      text_.substr(unknown_end_, at - unknown_end_).find_first_not_of(": \t\r\n") == text_.npos;
  if (is_of_unknown) return;
  all_.add(scene_error(place_of(file_, text_, at), complaint.found, complaint.expected));
}

void TextErrors::AddWarning(int line, int column, const std::string& message) {
  const bool is_of_unknown =
      message.starts_with(kUnknownField) || message.starts_with(kUnknownExtension);
  if (all_.has_more() || !is_of_unknown) return;
  unknown_end_ = std::string_view::npos;
  AddError(line, column, message);
  const Complaint complaint = reword(message);
  unknown_end_ = place(line, column, complaint.culprit) + complaint.culprit.size();
}

}  // namespace tessera
