#include "proto/wire/scene_walk.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <vector>

#include "base/cancellation.h"
#include "base/file.h"
#include "proto/wire/scene_codec.h"
#include "proto/wire/scene_errors.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;
using pb::FieldDescriptor;

using Types = std::unordered_map<const pb::Descriptor*, MessageType>;

/// The types of all messages that a scene may hold.
std::vector<const pb::Descriptor*> types_in_scenes() {
  std::vector<const pb::Descriptor*> types{v1::Scene::descriptor()};
  for (size_t i = 0; i < types.size(); ++i) {
    for (int k = 0; k < types[i]->field_count(); ++k) {
      const pb::Descriptor* inner = types[i]->field(k)->message_type();
      if (inner && std::ranges::find(types, inner) == types.end()) types.push_back(inner);
    }
  }
  return types;
}

/// These types with those of their fields that are wanted, by their numbers.
Types types_with(const std::function<bool(const FieldDescriptor&)>& is_wanted) {
  Types types;
  pb::MessageFactory& factory = *pb::MessageFactory::generated_factory();
  for (const pb::Descriptor* descriptor : types_in_scenes())
    types[descriptor].reflection = factory.GetPrototype(descriptor)->GetReflection();
  for (auto& [descriptor, type] : types) {
    for (int k = 0; k < descriptor->field_count(); ++k) {
      const FieldDescriptor& field = *descriptor->field(k);
      const pb::Descriptor* const inner = field.message_type();
      if (is_wanted(field)) type.fields.push_back({&field, inner ? &types.at(inner) : nullptr});
    }
    std::ranges::sort(type.fields, {}, [](const auto& field) { return field.field->number(); });
  }
  return types;
}

/// How many values or messages of the field `message` has. A number that is not set is 0, and an
/// enumeration's value its first: one.
int count_of(const pb::Reflection& reflection, const pb::Message& message,
             const FieldDescriptor& field) {
  if (field.is_repeated()) return reflection.FieldSize(message, &field);
  return field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE ||
         reflection.HasField(message, &field);
}

const pb::Message& message_in(const pb::Reflection& reflection, const pb::Message& message,
                              const FieldDescriptor& field, int index) {
  return field.is_repeated() ? reflection.GetRepeatedMessage(message, &field, index)
                             : reflection.GetMessage(message, &field);
}

double number(const pb::Reflection& reflection, const pb::Message& message,
              const FieldDescriptor& field, int index) {
  const bool is_double = field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  if (field.is_repeated())
    return is_double ? reflection.GetRepeatedDouble(message, &field, index)
                     : reflection.GetRepeatedFloat(message, &field, index);
  return is_double ? reflection.GetDouble(message, &field) : reflection.GetFloat(message, &field);
}

int enum_number(const pb::Reflection& reflection, const pb::Message& message,
                const FieldDescriptor& field, int index) {
  return field.is_repeated() ? reflection.GetRepeatedEnumValue(message, &field, index)
                             : reflection.GetEnumValue(message, &field);
}

std::string text(const pb::Reflection& reflection, const pb::Message& message,
                 const FieldDescriptor& field, int index) {
  return field.is_repeated() ? reflection.GetRepeatedString(message, &field, index)
                             : reflection.GetString(message, &field);
}

std::string step(const FieldDescriptor& field, int index) {
  return field.is_repeated() ? fmt::format("{}[{}]", field.name(), index) : field.name();
}

/// What is wrong with a scalar, if anything; its path is the field's alone.
std::optional<SceneFault> fault_of_value(const pb::Reflection& reflection,
                                         const pb::Message& message, const FieldDescriptor& field,
                                         int index) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
    // Proto3 keeps numbers that it has no name for; each reader would take them for another value.
    const int value = enum_number(reflection, message, field, index);
    if (field.enum_type()->FindValueByNumber(value)) return std::nullopt;
    return SceneFault{fmt::format("is {}", value), one_of(value_names(*field.enum_type()), ""),
                      step(field, index)};
  }
  if (field.type() == FieldDescriptor::TYPE_STRING) {
    if (find_invalid_utf8(text(reflection, message, field, index)) == std::string_view::npos)
      return std::nullopt;
    return SceneFault{"is not UTF-8", "text", step(field, index)};
  }
  if (std::isfinite(number(reflection, message, field, index))) return std::nullopt;
  return SceneFault{"is not finite", "a finite number", step(field, index)};
}

bool may_be_faulty(const FieldDescriptor& field) {
  const auto type = field.cpp_type();
  return type == FieldDescriptor::CPPTYPE_MESSAGE || type == FieldDescriptor::CPPTYPE_DOUBLE ||
         type == FieldDescriptor::CPPTYPE_FLOAT || type == FieldDescriptor::CPPTYPE_ENUM ||
         field.type() == FieldDescriptor::TYPE_STRING;
}

/// `depth` is the number of messages that `message` lies in.
std::optional<SceneFault> fault_in(const pb::Message& message, const MessageType& type, int depth) {
  Cancellation::check();
  // It might change the picture: better no scene than another one.
  const pb::UnknownFieldSet& unknown = type.reflection->GetUnknownFields(message);
  if (!unknown.empty()) {
    return SceneFault{fmt::format("has a field {}", unknown.field(0).number()),
                      "none of a later version", ""};
  }
  for (const auto& [field, inner] : type.fields) {
    const int count = count_of(*type.reflection, message, *field);
    for (int i = 0; i < count; ++i) {
      std::optional<SceneFault> fault;
      if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
        fault = fault_of_value(*type.reflection, message, *field, i);
      } else if (depth < kMaxSceneDepth) {
        fault = fault_in(message_in(*type.reflection, message, *field, i), *inner, depth + 1);
        if (fault) fault->path = step(*field, i) + (fault->path.empty() ? "" : "." + fault->path);
      } else {
        fault = SceneFault{"is nested too deep", fmt::format("at most {} levels", kMaxSceneDepth),
                           step(*field, i)};
      }
      if (fault) return fault;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<SceneFault> find_fault(const v1::Scene& scene) {
  static const Types checked = types_with(may_be_faulty);
  return fault_in(scene, checked.at(v1::Scene::descriptor()), 0);
}

MessageFinder::MessageFinder(const pb::Descriptor* wanted) : wanted_(wanted) {
  std::unordered_set<const pb::Descriptor*> leads;  // types that may hold a wanted one
  const auto leads_on = [&](const FieldDescriptor& field) {
    const pb::Descriptor* inner = field.message_type();
    return inner && (inner == wanted || leads.contains(inner));
  };
  for (size_t before = 1; before != leads.size();) {
    before = leads.size();
    for (const auto& [descriptor, type] : types_with(leads_on))
      if (!type.fields.empty()) leads.insert(descriptor);
  }
  types_ = types_with(leads_on);
}

bool MessageFinder::any(const v1::Scene& scene,
                        const std::function<bool(const pb::Message&)>& visit) const {
  const MessageType& type = types_.at(v1::Scene::descriptor());
  return any(scene, type, types_.at(wanted_), visit);
}

bool MessageFinder::any(const pb::Message& message, const MessageType& type,
                        const MessageType& wanted,
                        const std::function<bool(const pb::Message&)>& visit) {
  Cancellation::check();
  if (&type == &wanted && visit(message)) return true;
  for (const auto& [field, inner] : type.fields) {
    const int count = count_of(*type.reflection, message, *field);
    for (int i = 0; i < count; ++i)
      if (any(message_in(*type.reflection, message, *field, i), *inner, wanted, visit)) return true;
  }
  return false;
}

std::optional<std::vector<v1::BlobRef>> referenced_blobs(const v1::Scene& scene) {
  static const MessageFinder finder(v1::BlobRef::descriptor());
  std::unordered_set<std::string> seen;
  std::vector<v1::BlobRef> refs;
  const bool has_bad = finder.any(scene, [&](const pb::Message& message) {
    const auto& ref = static_cast<const v1::BlobRef&>(message);
    if (ref.digest().empty() || !seen.insert(ref.digest()).second) return false;
    refs.push_back(ref);
    return !Digest::parse(ref.digest());
  });
  if (has_bad) return std::nullopt;
  return refs;
}

}  // namespace tessera
