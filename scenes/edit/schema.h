#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <string_view>

#include "scenes/edit/outline.h"

namespace tessera::edit {

/// The comment of scene.proto on a message, field or enumeration value; empty where it has none.
std::string_view comment_on(const std::string& full_name);

/// What scene.proto says of a field: its kind, help, default, unit, range and choices, without a
/// place and value.
/// `holder`: the field of the ColorInput or FloatInput that it is the value of, whose default
/// counts.
Field describe(const google::protobuf::FieldDescriptor& field,
               const google::protobuf::FieldDescriptor* holder = nullptr);

/// The kind of entity that a message of this type is; `other` for what is part of another.
EntityKind entity_kind(const google::protobuf::Descriptor& type);

/// Vec2, Vec3 and Color, whose parts are numbers.
bool is_vector(const google::protobuf::Descriptor* type);
/// ColorInput and FloatInput, which set_field takes for their `value`.
bool is_input(const google::protobuf::Descriptor* type);

}  // namespace tessera::edit
