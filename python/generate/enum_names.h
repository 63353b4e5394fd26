#pragma once

#include <google/protobuf/descriptor.h>

#include <string>

#include "base/lower_case.h"

namespace tessera {

/// What Python calls a value of an enumeration: lower case, without the enumeration's name that
/// some have before them. "front_only", and "on" for SHADOWS_ON of the enumeration Shadows.
inline std::string python_name(const google::protobuf::EnumValueDescriptor& value) {
  std::string name = lower_case(value.name());
  const std::string prefix = lower_case(value.type()->name()) + "_";
  return name.starts_with(prefix) ? name.substr(prefix.size()) : name;
}

}  // namespace tessera
