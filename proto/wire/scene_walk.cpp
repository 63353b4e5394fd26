#include "proto/wire/scene_walk.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <cmath>
#include <unordered_set>
#include <vector>

#include "proto/wire/scene_codec.h"

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

std::string step(const FieldDescriptor& field, int index) {
  return field.is_repeated() ? fmt::format("{}[{}]", field.name(), index) : field.name();
}

std::optional<FieldPlace> infinite_in(const pb::Message& message, const FieldDescriptor& field,
                                      int index, Places* places) {
  const int position = field.is_repeated() ? index : -1;
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    const pb::Reflection& reflection = *message.GetReflection();
    const pb::Message& inner = field.is_repeated()
                                   ? reflection.GetRepeatedMessage(message, &field, index)
                                   : reflection.GetMessage(message, &field);
    auto found =
        find_infinite(inner, places ? places->GetTreeForNested(&field, position) : nullptr);
    if (found) found->path = step(field, index) + "." + found->path;
    return found;
  }
  if (std::isfinite(number(message, field, index))) return std::nullopt;
  FieldPlace place{step(field, index)};
  if (places) {
    const pb::TextFormat::ParseLocation at = places->GetLocation(&field, position);
    place.line = at.line + 1;
    place.column = at.column + 1;
  }
  return place;
}

void collect_blobs(const v1::BlobRef& ref, std::unordered_set<std::string>& seen,
                   std::vector<v1::BlobRef>& out) {
  if (!ref.digest().empty() && seen.insert(ref.digest()).second) out.push_back(ref);
}

void collect_blobs(const pb::Message& message, std::unordered_set<std::string>& seen,
                   std::vector<v1::BlobRef>& out) {
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

std::optional<FieldPlace> find_infinite(const pb::Message& message, Places* places) {
  std::vector<const FieldDescriptor*> fields;
  const pb::Reflection& reflection = *message.GetReflection();
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const auto type = field->cpp_type();
    if (field->is_map() ||
        (type != FieldDescriptor::CPPTYPE_MESSAGE && type != FieldDescriptor::CPPTYPE_DOUBLE &&
         type != FieldDescriptor::CPPTYPE_FLOAT))
      continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i)
      if (auto found = infinite_in(message, *field, i, places)) return found;
  }
  return std::nullopt;
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
