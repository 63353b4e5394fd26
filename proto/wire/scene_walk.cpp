#include "proto/wire/scene_walk.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <cmath>
#include <unordered_set>
#include <vector>

#include "base/cancellation.h"
#include "proto/wire/scene_codec.h"
#include "proto/wire/scene_errors.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;
using pb::FieldDescriptor;
using Places = pb::TextFormat::ParseInfoTree;

double number(const pb::Message& message, const FieldDescriptor& field, int index) {
  const pb::Reflection& reflection = *message.GetReflection();
  const bool is_double = field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  if (field.is_repeated())
    return is_double ? reflection.GetRepeatedDouble(message, &field, index)
                     : reflection.GetRepeatedFloat(message, &field, index);
  return is_double ? reflection.GetDouble(message, &field) : reflection.GetFloat(message, &field);
}

int enum_number(const pb::Message& message, const FieldDescriptor& field, int index) {
  const pb::Reflection& reflection = *message.GetReflection();
  return field.is_repeated() ? reflection.GetRepeatedEnumValue(message, &field, index)
                             : reflection.GetEnumValue(message, &field);
}

std::string step(const FieldDescriptor& field, int index) {
  return field.is_repeated() ? fmt::format("{}[{}]", field.name(), index) : field.name();
}

/// What is wrong with a scalar, if anything; its path is the field's alone.
std::optional<SceneFault> fault_of_value(const pb::Message& message, const FieldDescriptor& field,
                                         int index) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
    // Proto3 keeps numbers that it has no name for; each reader would take them for another value.
    const int value = enum_number(message, field, index);
    if (field.enum_type()->FindValueByNumber(value)) return std::nullopt;
    return SceneFault{fmt::format("is {}", value), one_of(value_names(*field.enum_type()), ""),
                      step(field, index)};
  }
  if (std::isfinite(number(message, field, index))) return std::nullopt;
  return SceneFault{"is not finite", "a finite number", step(field, index)};
}

bool may_be_faulty(const FieldDescriptor& field) {
  const auto type = field.cpp_type();
  return !field.is_map() &&
         (type == FieldDescriptor::CPPTYPE_MESSAGE || type == FieldDescriptor::CPPTYPE_DOUBLE ||
          type == FieldDescriptor::CPPTYPE_FLOAT || type == FieldDescriptor::CPPTYPE_ENUM);
}

void end_if_cancelled() {
  const std::atomic<bool>* const cancelled = Cancellation::current();
  if (cancelled && *cancelled) throw WorkCancelled{};
}

/// `depth` is the number of messages that `message` lies in.
std::optional<SceneFault> fault_in(const pb::Message& message, Places* places, int depth) {
  end_if_cancelled();
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (!may_be_faulty(*field)) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const int position = field->is_repeated() ? i : -1;
      std::optional<SceneFault> fault;
      if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
        fault = fault_of_value(message, *field, i);
      } else if (depth < kMaxSceneDepth) {
        const pb::Message& inner = field->is_repeated()
                                       ? reflection.GetRepeatedMessage(message, field, i)
                                       : reflection.GetMessage(message, field);
        fault = fault_in(inner, places ? places->GetTreeForNested(field, position) : nullptr,
                         depth + 1);
        if (fault) fault->path = step(*field, i) + "." + fault->path;
      } else {
        fault = SceneFault{"is nested too deep", fmt::format("at most {} levels", kMaxSceneDepth),
                           step(*field, i)};
      }
      if (!fault) continue;
      if (places && fault->line == 0) {
        const pb::TextFormat::ParseLocation at = places->GetLocation(field, position);
        fault->line = at.line + 1;
        fault->column = at.column + 1;
      }
      return fault;
    }
  }
  return std::nullopt;
}

void collect_blobs(const v1::BlobRef& ref, std::unordered_set<std::string>& seen,
                   std::vector<v1::BlobRef>& out) {
  if (!ref.digest().empty() && seen.insert(ref.digest()).second) out.push_back(ref);
}

void collect_blobs(const pb::Message& message, std::unordered_set<std::string>& seen,
                   std::vector<v1::BlobRef>& out) {
  end_if_cancelled();
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE || field->is_map()) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const pb::Message& inner = field->is_repeated()
                                     ? reflection.GetRepeatedMessage(message, field, i)
                                     : reflection.GetMessage(message, field);
      if (inner.GetDescriptor() == v1::BlobRef::descriptor())
        collect_blobs(static_cast<const v1::BlobRef&>(inner), seen, out);
      else
        collect_blobs(inner, seen, out);
    }
  }
}

}  // namespace

std::optional<SceneFault> find_fault(const v1::Scene& scene, Places* places) {
  return fault_in(scene, places, 0);
}

std::optional<std::vector<v1::BlobRef>> referenced_blobs(const v1::Scene& scene) {
  std::unordered_set<std::string> seen;
  std::vector<v1::BlobRef> refs;
  collect_blobs(scene, seen, refs);
  for (const v1::BlobRef& ref : refs)
    if (!Digest::parse(ref.digest())) return std::nullopt;
  return refs;
}

}  // namespace tessera
