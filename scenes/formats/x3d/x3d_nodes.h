#pragma once

#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// What a node type of X3D is to us.
struct X3dNodeType {
  enum class Use { read, ignored };

  std::string_view name;
  std::string_view container;  ///< the field of the parent that holds it by default
  Use use;
  std::string_view fields;  ///< the fields that it may have, between spaces
};

/// The type called `name`, or null.
const X3dNodeType* find_x3d_node_type(std::string_view name);
/// Every name, for suggestions.
std::span<const std::string> x3d_node_names();
/// Whether `type` has a field of that name; true where its fields are not on record.
bool has_x3d_field(const X3dNodeType& type, std::string_view field);

}  // namespace tessera
