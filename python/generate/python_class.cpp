#include "python/generate/python_class.h"

#include <google/protobuf/descriptor.pb.h>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "python/generate/enum_names.h"
#include "python/generate/named_things.h"
#include "python/generate/python_words.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;

/// Messages that are plain Python values: what takes their place in annotations.
const std::map<std::string, std::string> kPlain = {{"Vec2", "VectorLike"},
                                                   {"Vec3", "VectorLike"},
                                                   {"Color", "ColorLike"},
                                                   {"BlobRef", "ArrayLike"},
                                                   {"Blob", ""}};
/// What is taken beside the class itself, or the class derived from it that users see.
const std::map<std::string, std::string> kTaken = {{"ColorInput", "ColorInputLike"},
                                                   {"FloatInput", "FloatInputLike"},
                                                   {"Node", "NodeLike"},
                                                   {"Shape", "_placing.Shape"},
                                                   {"Transform", "_transforms.Transform"},
                                                   {"Background", "_view.Background"},
                                                   {"Camera", "_view.Camera"},
                                                   {"Lens", "_view.Lens"}};
/// String fields that are words of the command line.
const std::map<std::string, std::string> kWords = {{"Settings.accelerator", "Accelerator"},
                                                   {"IntegratorSettings.kind", "Integrator"}};
const std::map<std::string, std::string> kRenamed = {{"TriangleMesh", "Mesh"},
                                                     {"Texture.GradientRamp", "GradientTexture"},
                                                     {"Light.Cylinder", "BeamLight"}};

std::string short_name(const std::string& full_name) {
  return full_name.substr(std::string("tessera.v1.").size());
}

std::string class_name(const pb::Descriptor& message) {
  const auto renamed = kRenamed.find(short_name(message.full_name()));
  if (renamed != kRenamed.end()) return renamed->second;
  const pb::Descriptor* parent = message.containing_type();
  if (!parent) return message.name();
  return is_union(*parent) ? message.name() + parent->name() : parent->name() + message.name();
}

/// What of a field ValueReader and ValueWriter do not know; empty: nothing.
std::string unknown_kind(const pb::FieldDescriptor& field) {
  using Field = pb::FieldDescriptor;
  const auto type = field.cpp_type();
  if (field.is_map()) {
    return short_name(field.full_name()) == "Metadata.properties" ? "" : "a second map";
  }
  if (type == Field::CPPTYPE_INT64 || type == Field::CPPTYPE_UINT64) return "a number of 64 bits";
  if (field.type() == Field::TYPE_BYTES) return "bytes";
  const bool may_be_many = type == Field::CPPTYPE_DOUBLE || type == Field::CPPTYPE_FLOAT ||
                           type == Field::CPPTYPE_UINT32 || type == Field::CPPTYPE_STRING ||
                           type == Field::CPPTYPE_MESSAGE;
  return field.is_repeated() && !may_be_many ? fmt::format("many of type {}", field.cpp_type_name())
                                             : "";
}

/// The comments before and behind it, as one paragraph.
template <class D>
std::string comment(const D& described) {
  pb::SourceLocation place;
  if (!described.GetSourceLocation(&place)) return "";
  std::string text, words;
  for (const std::string& part : {place.leading_comments, place.trailing_comments}) {
    if (part.find("-----") != std::string::npos) continue;  // the heading of a section
    text += part + " ";
  }
  for (const char c : text) {
    const bool space = c == ' ' || c == '\n' || c == '\t';
    if (!space) {
      words += c;
    } else if (!words.empty() && words.back() != ' ') {
      words += ' ';
    }
  }
  if (!words.empty() && words.back() == ' ') words.pop_back();
  std::string escaped;
  for (const char c : words) escaped += c == '\\' ? "\\\\" : std::string(1, c);
  return with_python_words(escaped, *described.file());
}

/// Whether a comment says what a field is where a scene does not: "default 1", or "0: no bound".
bool tells_default(const std::string& words) {
  for (const char* sign : {"default", "0:", "none:", "None:", "empty:", "left out:", "absent"}) {
    if (words.find(sign) != words.npos) return true;
  }
  return false;
}

/// "SamplingFilter" for the enumeration Sampling.Filter.
std::string enum_name(const pb::EnumDescriptor& type) {
  return type.containing_type() ? class_name(*type.containing_type()) + type.name() : type.name();
}

std::string element_type(const pb::FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return "float";
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      return "bool";
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      return enum_name(*field.enum_type());
    case pb::FieldDescriptor::CPPTYPE_STRING: {
      const std::string name = short_name(field.full_name());
      if (kWords.contains(name)) return kWords.at(name);
      const std::string named = type_named_by(name);
      if (named == "Texture") return "TextureLike";
      return named.empty() ? "str" : fmt::format("Union[str, {}]", named);
    }
    case pb::FieldDescriptor::CPPTYPE_MESSAGE: {
      const std::string name = short_name(field.message_type()->full_name());
      if (kPlain.contains(name)) return kPlain.at(name);
      if (kTaken.contains(name)) return kTaken.at(name);
      return class_name(*field.message_type());
    }
    default:
      return "int";
  }
}

/// What a field is where a scene does not say; empty: its comment tells.
std::string default_of(const pb::FieldDescriptor& field) {
  using Field = pb::FieldDescriptor;
  if (field.real_containing_oneof() && !field.enum_type()) return "none";
  if (tells_default(comment(field)) || field.enum_type()) return "";
  const pb::Descriptor* message = field.message_type();
  if (message && message->name() == "Vec3" && !field.is_repeated()) return "0 0 0";
  if (message && message->name() == "Color" && !field.is_repeated()) return "black";
  if (field.is_repeated() || message || field.cpp_type() == Field::CPPTYPE_STRING) return "none";
  return field.cpp_type() == Field::CPPTYPE_BOOL ? "False" : "0";
}

/// The field's comment, what it is by default, and the values that it can have with theirs, of
/// which the first is the default.
std::string field_doc(const pb::FieldDescriptor& field) {
  std::string doc = comment(field);
  if (const std::string otherwise = default_of(field); !otherwise.empty()) {
    if (doc.ends_with('.')) doc.pop_back();
    doc += fmt::format("; default {}", otherwise);
  }
  const pb::EnumDescriptor* type = field.enum_type();
  for (int i = 0; type && i < type->value_count(); ++i) {
    std::string said = comment(*type->value(i));
    if (said.ends_with('.')) said.pop_back();  // more follows
    const std::string name = python_name(*type->value(i));
    doc += fmt::format("{}\"{}\"{}{}{}", doc.empty() ? "" : "; ", name,
                       i == 0 && name != "default" ? " (default)" : "", said.empty() ? "" : ": ",
                       said);
  }
  return doc;
}

void add_holders(const pb::Descriptor& in, const pb::Descriptor& held,
                 std::set<std::string>& names) {
  for (int i = 0; i < in.nested_type_count(); ++i) add_holders(*in.nested_type(i), held, names);
  for (int i = 0; i < in.field_count(); ++i) {
    if (in.field(i)->message_type() != &held) continue;
    names.insert(is_union(in) && in.field(i)->real_containing_oneof()
                     ? fmt::format("a kind of {}", class_name(in))
                     : fmt::format("of `{}.{}`", class_name(in), in.field(i)->name()));
  }
}

/// The message's comment, or else the fields that hold it.
std::string class_doc(const pb::Descriptor& message) {
  const std::string said = comment(message);
  if (!said.empty()) return said;
  std::set<std::string> names;
  for (int i = 0; i < message.file()->message_type_count(); ++i) {
    add_holders(*message.file()->message_type(i), message, names);
  }
  return fmt::format("{}{}{}.", class_name(message), names.empty() ? "" : ": ",
                     fmt::join(names, " or "));
}

PythonField make_field(const pb::FieldDescriptor& field) {
  PythonField made{.name = field.name(), .type = "", .doc = field_doc(field)};
  made.is_map = field.is_map();
  made.is_list = field.is_repeated() && !field.is_map();
  made.type = made.is_map ? "str" : element_type(field);
  return made;
}

/// The fields of a message but for those of its kinds and the blobs, which are arrays in place.
std::vector<PythonField> fields_of(const pb::Descriptor& message, bool with_kinds) {
  std::vector<PythonField> fields;
  for (int i = 0; i < message.field_count(); ++i) {
    const pb::FieldDescriptor& field = *message.field(i);
    const bool is_kind = field.real_containing_oneof() != nullptr;
    const bool is_blob = field.message_type() && field.message_type()->name() == "Blob";
    if ((with_kinds || !is_kind) && !is_blob) fields.push_back(make_field(field));
  }
  return fields;
}

/// The types of a message's enumerations, and of those of messages in it.
void add_enumerations(const pb::Descriptor& message, std::string& text) {
  for (int i = 0; i < message.nested_type_count(); ++i) {
    add_enumerations(*message.nested_type(i), text);
  }
  for (int i = 0; i < message.enum_type_count(); ++i) {
    const pb::EnumDescriptor& type = *message.enum_type(i);
    text += fmt::format("{} = Literal[\"{}\"]\n", enum_name(type),
                        fmt::join(python_names(type), "\", \""));
  }
}

const pb::OneofDescriptor* kinds_of(const pb::Descriptor& message) {
  return message.real_oneof_decl_count() == 1 ? message.oneof_decl(0) : nullptr;
}

void add_union(const pb::Descriptor& message, std::vector<PythonClass>& classes) {
  PythonClass base{.name = class_name(message),
                   .base = "Value",
                   .doc = class_doc(message),
                   .message = message.full_name(),
                   .kind = "",
                   .own = {},
                   .common = fields_of(message, false)};
  if (message.name() == "Shape") {
    base.common.push_back({.name = "transform",
                           .type = kTaken.at("Transform"),
                           .doc = "comes behind the transform of the node that holds the "
                                  "shape; default none"});
  }
  classes.push_back(base);
  const pb::OneofDescriptor& kinds = *kinds_of(message);
  for (int i = 0; i < kinds.field_count(); ++i) {
    const pb::Descriptor& kind = *kinds.field(i)->message_type();
    classes.push_back({.name = class_name(kind),
                       .base = base.name,
                       .doc = class_doc(kind),
                       .message = base.message,
                       .kind = kinds.field(i)->name(),
                       .own = fields_of(kind, true),
                       .common = base.common});
  }
}

void add_classes(const pb::Descriptor& message, std::set<std::string>& kinds,
                 std::vector<PythonClass>& classes) {
  if (message.options().map_entry() || kPlain.contains(short_name(message.full_name()))) return;
  for (int i = 0; i < message.nested_type_count(); ++i) {
    add_classes(*message.nested_type(i), kinds, classes);
  }
  if (is_union(message)) {
    add_union(message, classes);
  } else if (!kinds.contains(message.full_name())) {
    classes.push_back({.name = class_name(message),
                       .base = "Value",
                       .doc = class_doc(message),
                       .message = message.full_name(),
                       .kind = "",
                       .own = fields_of(message, true),
                       .common = {}});
  }
}

/// `text` in lines of at most 100 columns, each indented.
std::string wrap(const std::string& text, const std::string& indent) {
  std::string lines, line = indent;
  size_t at = 0;
  while (at < text.size()) {
    const size_t end = std::min(text.find(' ', at), text.size());
    if (line.size() + (end - at) > 98 && line != indent) {
      lines += line + "\n";
      line = indent + "    ";
    }
    if (line.back() != ' ') line += ' ';
    line += text.substr(at, end - at);
    at = end + 1;
  }
  return lines + line + "\n";
}

std::string attribute_type(const PythonField& field) {
  if (field.is_map) return fmt::format("Dict[str, {}]", field.type);
  return fmt::format("{}[{}]", field.is_list ? "List" : "Optional", field.type);
}

std::string argument(const PythonField& field) {
  const char* form = field.is_map    ? "Optional[Mapping[str, {}]]"
                     : field.is_list ? "Optional[Iterable[{}]]"
                                     : "Optional[{}]";
  return fmt::format("                 {}: {} = None", field.name,
                     fmt::format(fmt::runtime(form), field.type));
}

std::string assignment(const PythonField& field) {
  const std::string& name = field.name;
  if (field.is_map) return fmt::format("dict({0}) if {0} is not None else {{}}", name);
  if (field.is_list) return fmt::format("several({0}, \"{0}\") if {0} is not None else []", name);
  return name;
}

std::string docstring(const PythonClass& made) {
  const std::string text = wrap(made.doc, "    ");
  std::string body = "    \"\"\"" + text.substr(4);
  if (!made.own.empty() || !made.common.empty()) body += "\n    Attributes:\n";
  for (const auto* fields : {&made.own, &made.common}) {
    for (const PythonField& field : *fields) {
      if (field.name.starts_with("inline_")) continue;  // of files; scripts have arrays
      const std::string doc = field.doc.empty() ? attribute_type(field) : field.doc;
      body += wrap(fmt::format("{}: {}", field.name, doc), "        ");
    }
  }
  return body + "    \"\"\"\n\n";
}

std::string constructor(const PythonClass& made) {
  std::string arguments = "self", body = "        self._place = here()\n";
  for (const PythonField& field : made.own) arguments += ",\n" + argument(field);
  if (!made.common.empty()) arguments += ",\n                 *";
  for (const PythonField& field : made.common) arguments += ",\n" + argument(field);
  const bool is_shape = made.message == "tessera.v1.Shape";
  if (is_shape) arguments += ",\n                 material: Optional[Union[str, Material]] = None";
  arguments += ",\n                 **unknown: NoReturn";
  body += "        if unknown:\n            refuse_keywords(self, unknown)\n";
  for (const auto* fields : {&made.own, &made.common}) {
    for (const PythonField& field : *fields) {
      body += fmt::format("        self.{} = {}\n", field.name, assignment(field));
    }
  }
  if (is_shape) {
    body += R"(        if material is not None:
            if self.materials:
                raise TypeError("material beside materials; expected one of them")
            self.materials = [material]
)";
  }
  return "    def __init__(" + arguments + ") -> None:\n" + body;
}

std::string quoted(const std::vector<PythonField>& fields) {
  std::string names;
  for (const PythonField& field : fields) names += fmt::format("\"{}\", ", field.name);
  return names;
}

}  // namespace

bool is_union(const pb::Descriptor& message) {
  const pb::OneofDescriptor* kinds = kinds_of(message);
  return kinds && kinds->name() == "kind" && message.FindFieldByName("name") != nullptr;
}

std::string untold_field(const pb::Descriptor& message) {
  if (kPlain.contains(short_name(message.full_name())) || message.options().map_entry()) return "";
  for (int i = 0; i < message.field_count(); ++i) {
    const pb::FieldDescriptor& field = *message.field(i);
    const pb::Descriptor* type = field.message_type();
    if (field.name().starts_with("inline_") || (type && type->name() == "Blob")) continue;
    if (is_union(message) && field.real_containing_oneof()) continue;  // its class tells
    const bool may_be_missing = type ? type->name().ends_with("Input") : field.has_presence();
    const bool has_default = !may_be_missing || field.real_containing_oneof() ||
                             field.enum_type() || tells_default(comment(field));
    if (comment(field).empty() && !field.enum_type())
      return field.full_name() + ": no comment; expected what it is, with unit and range";
    if (!has_default) return field.full_name() + ": no default in its comment; expected one";
  }
  for (int i = 0; i < message.nested_type_count(); ++i) {
    const std::string inside = untold_field(*message.nested_type(i));
    if (!inside.empty()) return inside;
  }
  return "";
}

std::string unknown_field(const pb::Descriptor& message) {
  if (kPlain.contains(short_name(message.full_name()))) return "";
  for (int i = 0; i < message.field_count(); ++i) {
    const pb::FieldDescriptor& field = *message.field(i);
    const std::string kind = unknown_kind(field);
    if (!kind.empty())
      return fmt::format("{}: {}; expected what values of Python are made of", field.full_name(),
                         kind);
  }
  for (int i = 0; i < message.nested_type_count(); ++i) {
    const std::string inside = unknown_field(*message.nested_type(i));
    if (!inside.empty()) return inside;
  }
  return "";
}

std::vector<PythonClass> python_classes(const pb::FileDescriptor& file) {
  std::set<std::string> kinds;  // messages that are a kind of a union, and no class besides
  for (int i = 0; i < file.message_type_count(); ++i) {
    const pb::Descriptor& message = *file.message_type(i);
    if (!is_union(message)) continue;
    for (int k = 0; k < kinds_of(message)->field_count(); ++k) {
      kinds.insert(kinds_of(message)->field(k)->message_type()->full_name());
    }
  }
  std::vector<PythonClass> classes;
  for (int i = 0; i < file.message_type_count(); ++i) {
    add_classes(*file.message_type(i), kinds, classes);
  }
  return classes;
}

std::string enumerations(const pb::FileDescriptor& file) {
  std::string text;
  for (int i = 0; i < file.message_type_count(); ++i) add_enumerations(*file.message_type(i), text);
  return text;
}

std::string to_python(const PythonClass& made) {
  const bool is_base = made.kind.empty() && !made.common.empty();
  const std::vector<PythonField>& slots = is_base ? made.common : made.own;
  std::string text = fmt::format("\n\nclass {}({}):\n", made.name, made.base);
  text += docstring(made);
  text += fmt::format("    __slots__ = ({})\n", quoted(slots));
  text += fmt::format("    _MESSAGE = \"{}\"\n    _KIND = \"{}\"\n", made.message, made.kind);
  text +=
      fmt::format("    _FIELDS: Tuple[str, ...] = ({})\n", quoted(made.own) + quoted(made.common));
  for (const PythonField& field : slots) {
    text += fmt::format("    {}: {}\n", field.name, attribute_type(field));
  }
  return text + "\n" + constructor(made);
}

}  // namespace tessera
