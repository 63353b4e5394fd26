#pragma once

#include <string_view>
#include <vector>

#include "scenes/edit/edit.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// The items of the lists of a glTF document with the numbers, texts and choices inside of them.
std::vector<Entity> gltf_entities(std::string_view text, const SyntaxTree& tree);
/// Sets a scalar that is there; accessors and buffers are shown and not set.
Change set_gltf_field(const Outline& outline, int entity, std::string_view field,
                      std::string_view value);
/// Its node may hold nothing else, which would move with it.
Change write_gltf_camera(const Outline& outline, std::string_view name, const CameraPose& pose);

}  // namespace tessera::edit
