#pragma once

#include <string>
#include <string_view>

#include "scenes/edit/edit.h"

namespace tessera::edit {

// The edits of .tessera and .json: see edit.h.
Change set_message_field(const Outline& outline, int entity, std::string_view field,
                         std::string_view value);
Change reset_message_field(const Outline& outline, int entity, std::string_view field);
Change remove_message(const Outline& outline, int entity);
Change duplicate_message(const Outline& outline, int entity);
Change add_message(const Outline& outline, int parent, const EntityTemplate& made);
Change write_message_camera(const Outline& outline, std::string_view name, const CameraPose& pose);
Change set_message_panorama(const Outline& outline, std::string_view file);
std::vector<EntityTemplate> message_templates();

Change refuse(std::string found, std::string expected, SourceRange range = {});

}  // namespace tessera::edit
