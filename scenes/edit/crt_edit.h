#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/edit/edit.h"

namespace tessera::edit {

// The edits of CRT scripts: see edit.h.
Change set_crt_field(const Outline& outline, int entity, std::string_view field,
                     std::string_view value);
Change reset_crt_field(const Outline& outline, int entity, std::string_view field);
Change remove_crt(const Outline& outline, int entity);
Change duplicate_crt(const Outline& outline, int entity);
Change add_crt(const Outline& outline, const EntityTemplate& made);
Change write_crt_camera(const Outline& outline, std::string_view name, const CameraPose& pose);
std::vector<EntityTemplate> crt_templates();

/// A number as a script writes it, without an exponent; a float where the old one was.
std::string crt_number(std::string_view typed, std::string_view old);

}  // namespace tessera::edit
