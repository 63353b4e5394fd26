#include "scenes/edit/schema.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;
using Type = pb::FieldDescriptor;

struct Comment {
  std::string_view name, words;
};
/// In the order of their names.
constexpr Comment kComments[] = {
#include "scenes/edit/schema_comments.inc"
};

bool says(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

/// The number that `words` begins with, "2^14" among them; moves behind it.
std::optional<double> take_number(std::string_view& words) {
  double value = 0;
  const auto [end, error] = std::from_chars(words.data(), words.data() + words.size(), value);
  if (error != std::errc()) return {};
  words.remove_prefix(static_cast<size_t>(end - words.data()));
  double exponent = 0;
  if (!words.starts_with('^')) return value;
  const auto power = std::from_chars(words.data() + 1, words.data() + words.size(), exponent);
  if (power.ec != std::errc()) return value;
  words.remove_prefix(static_cast<size_t>(power.ptr - words.data()));
  double product = 1;
  for (int i = 0; i < static_cast<int>(exponent); ++i) product *= value;
  return product;
}

/// The range in "in (0, 180)", "> 0", "1 to 65536", "at most 2^14".
FieldLimits limits_in(std::string_view words) {
  FieldLimits limits;
  for (size_t at = 0; at < words.size(); ++at) {
    const bool begins = at == 0 || words[at - 1] == ' ';
    std::string_view rest = words.substr(at);
    if (!begins || (at > 0 && says(words.substr(0, at), ":"))) continue;
    if (rest.starts_with("in (") || rest.starts_with("in [")) {
      FieldLimits found;
      found.above_least = rest[3] == '(';
      rest.remove_prefix(4);
      found.least = take_number(rest);
      if (!found.least || !rest.starts_with(", ")) continue;
      rest.remove_prefix(2);
      found.most = take_number(rest);
      found.below_most = rest.starts_with(')');
      if (found.most) return found;
    } else if (rest.starts_with("> ") || rest.starts_with(">= ")) {
      limits.above_least = rest[1] == ' ';
      rest.remove_prefix(limits.above_least ? 2 : 3);
      limits.least = take_number(rest);
      if (rest.starts_with(" where")) limits = {};
      return limits;
    } else if (rest.starts_with("at most ")) {
      rest.remove_prefix(8);
      if (const auto most = take_number(rest)) return {.least = {}, .most = most};
    } else if (const auto least = take_number(rest); least && rest.starts_with(" to ")) {
      rest.remove_prefix(4);
      if (const auto most = take_number(rest)) return {.least = least, .most = most};
    }
  }
  return limits;
}

std::string default_in(std::string_view words) {
  const size_t at = words.find("default ");
  if (at == std::string_view::npos) return "";
  std::string_view rest = words.substr(at + 8);
  size_t end = rest.find_first_of(",;:()");
  rest = rest.substr(0, end);
  if (rest.ends_with('.')) rest.remove_suffix(1);
  if (rest == "white") return "1 1 1";
  if (rest == "black") return "0 0 0";
  if (rest == "+x") return "1 0 0";
  if (rest == "+y") return "0 1 0";
  if (rest == "+z") return "0 0 1";
  if (rest == ".8 grey") return ".8 .8 .8";
  std::string_view number = rest;
  if (take_number(number) && !number.starts_with(' ')) return std::string(rest);
  if (rest.find_first_not_of("-.0123456789 ") == std::string_view::npos) return std::string(rest);
  return "";
}

std::string unit_of(const Type& field, std::string_view words) {
  const std::string& name = field.name();
  if (says(words, "per metre")) return "1/m";
  if (says(words, "pixels")) return "px";
  if (says(words, "stops")) return "stops";
  if (says(name, "angle") || says(name, "field_of_view") || name == "beam_width" ||
      name == "cut_off")
    return "deg";
  constexpr std::array<std::string_view, 14> kLengths{
      "radius",       "height",       "center",      "position",        "eye",
      "target",       "corner",       "translate",   "inner_radius",    "top_radius",
      "major_radius", "minor_radius", "beam_radius", "visibility_range"};
  const bool is_length = std::find(kLengths.begin(), kLengths.end(), name) != kLengths.end();
  if (is_length || says(words, "metres") || name.ends_with("_distance")) return "m";
  if (name == "time") return "s";
  return "";
}

bool is_reference(const Type& field) {
  const std::string& name = field.name();
  const std::string& type = field.containing_type()->name();
  if (name == "texture" || name == "normal_map" || name == "back" || name == "instance_of")
    return true;
  return name == "materials" || (type == "Include" && name == "material");
}

ValueKind kind_of(const Type& field) {
  switch (field.cpp_type()) {
    case Type::CPPTYPE_DOUBLE:
    case Type::CPPTYPE_FLOAT:
      return ValueKind::number;
    case Type::CPPTYPE_BOOL:
      return ValueKind::boolean;
    case Type::CPPTYPE_ENUM:
      return ValueKind::choice;
    case Type::CPPTYPE_STRING:
      if (field.type() == Type::TYPE_BYTES || field.name() == "digest") return ValueKind::data;
      if (field.name() == "file") return ValueKind::file;
      if (is_reference(field)) return ValueKind::reference;
      return field.name() == "accelerator" ||
                     field.full_name() == "tessera.v1.IntegratorSettings.kind"
                 ? ValueKind::choice
                 : ValueKind::text;
    case Type::CPPTYPE_MESSAGE:
      if (field.message_type()->name() == "FloatInput") return ValueKind::number;
      if (field.message_type()->name().starts_with("Color")) return ValueKind::color;
      return is_vector(field.message_type()) ? ValueKind::vector : ValueKind::data;
    default:
      return ValueKind::integer;
  }
}

std::vector<std::string> choices_of(const Type& field) {
  std::vector<std::string> choices;
  if (const pb::EnumDescriptor* type = field.enum_type())
    for (int i = 0; i < type->value_count(); ++i) choices.push_back(type->value(i)->name());
  if (field.cpp_type() == Type::CPPTYPE_BOOL) return {"false", "true"};
  if (field.name() == "accelerator")
    return {"bvh", "bvh-splits", "octree", "nonuniform-octree", "embree", "linear"};
  if (field.full_name() == "tessera.v1.IntegratorSettings.kind")
    return {"auto", "whitted", "path", "normals", "depth"};
  return choices;
}

}  // namespace

std::string_view comment_on(const std::string& full_name) {
  const auto* found = std::lower_bound(
      std::begin(kComments), std::end(kComments), full_name,
      [](const Comment& a, const std::string& b) { return a.name < std::string_view(b); });
  return found != std::end(kComments) && found->name == full_name ? found->words
                                                                  : std::string_view{};
}

Field describe(const Type& field, const Type* holder) {
  Field made;
  made.name = field.name();
  made.is_present = false;
  made.kind = kind_of(field);
  made.choices = choices_of(field);
  const std::string_view words = comment_on(field.full_name());
  made.help = words;
  made.unit = unit_of(field, words);
  if (made.kind == ValueKind::number || made.kind == ValueKind::integer)
    made.limits = limits_in(words);
  if (made.kind == ValueKind::integer) {
    const bool is_signed = field.cpp_type() == Type::CPPTYPE_INT32;
    if (!made.limits.least) made.limits.least = is_signed ? double{INT32_MIN} : 0;
    if (!made.limits.most) made.limits.most = is_signed ? double{INT32_MAX} : double{UINT32_MAX};
  }
  made.fallback = default_in(words);
  const bool is_input_field = field.name() == "value" && is_input(field.containing_type());
  if (made.fallback.empty() && !field.is_repeated() && !is_input_field) {
    if (made.kind == ValueKind::number || made.kind == ValueKind::integer) made.fallback = "0";
    if (made.kind == ValueKind::choice) made.fallback = made.choices.front();
    if (made.kind == ValueKind::boolean) made.fallback = "false";
    if (made.kind == ValueKind::vector || made.kind == ValueKind::color)
      made.fallback = field.message_type()->field_count() == 2 ? "0 0" : "0 0 0";
  }
  if (field.full_name() == "tessera.v1.LookAt.up") made.fallback = "0 1 0";
  if (is_input_field && holder) {
    const std::string_view outer = comment_on(holder->full_name());
    made.help = outer;
    made.fallback = default_in(outer);
    if (made.unit.empty()) made.unit = unit_of(*holder, outer);
    if (made.kind == ValueKind::number) made.limits = limits_in(outer);
  }
  if (made.kind == ValueKind::data) made.locked = "bytes are shown and not set";
  made.text = made.fallback;
  return made;
}

EntityKind entity_kind(const pb::Descriptor& type) {
  constexpr std::pair<std::string_view, EntityKind> kKinds[] = {
      {"Scene", EntityKind::scene},
      {"Metadata", EntityKind::metadata},
      {"Settings", EntityKind::settings},
      {"Camera", EntityKind::camera},
      {"Background", EntityKind::background},
      {"Fog", EntityKind::fog},
      {"Light", EntityKind::light},
      {"Material", EntityKind::material},
      {"Texture", EntityKind::texture},
      {"Object", EntityKind::object},
      {"Node", EntityKind::node},
      {"Shape", EntityKind::shape},
      {"Step", EntityKind::step},
      {"TransformKey", EntityKind::key},
      {"Include", EntityKind::include},
      {"Blob", EntityKind::blob}};
  for (const auto& [name, kind] : kKinds)
    if (type.name() == name) return kind;
  return EntityKind::other;
}

bool is_vector(const pb::Descriptor* type) {
  return type && (type->name() == "Vec2" || type->name() == "Vec3" || type->name() == "Color");
}

bool is_input(const pb::Descriptor* type) {
  return type && (type->name() == "ColorInput" || type->name() == "FloatInput");
}

}  // namespace tessera::edit
