#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// What a node type of X3D is to us.
struct X3dNodeType {
  enum class Use { read, ignored };

  std::string_view name;
  std::string_view container;  ///< the field of the parent that holds it by default
  Use use;
  std::string_view fields;       ///< the fields that it may have, between spaces
  std::string_view node_fields;  ///< those that hold nodes

  /// True for any where its fields are not on record.
  bool has_field(std::string_view field) const;
  bool has_node_field(std::string_view field) const;
  /// Of both kinds, for suggestions.
  std::vector<std::string> field_names() const;
};

/// The type called `name`, or null.
const X3dNodeType* find_x3d_node_type(std::string_view name);
/// Whether the node places what it holds by a transform of its own.
bool has_x3d_transform(std::string_view name);
/// Every name, for suggestions.
std::span<const std::string> x3d_node_names();

}  // namespace tessera
