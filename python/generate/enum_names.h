#pragma once

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/lower_case.h"

namespace tessera {

/// What Python calls a value of an enumeration, as options spell it: lower case, without the
/// enumeration's name that some have before them. "front-only", and "on" for SHADOWS_ON of the
/// enumeration Shadows.
inline std::string python_name(const google::protobuf::EnumValueDescriptor& value) {
  std::string name = lower_case(value.name());
  const std::string prefix = lower_case(value.type()->name()) + "_";
  if (name.starts_with(prefix)) name.erase(0, prefix.size());
  std::ranges::replace(name, '_', '-');
  return name;
}
/// Those of all values, in their order.
inline std::vector<std::string> python_names(const google::protobuf::EnumDescriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.value_count(); ++i) names.push_back(python_name(*type.value(i)));
  return names;
}

}  // namespace tessera
