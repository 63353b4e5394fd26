#pragma once

#include <string_view>
#include <vector>

#include "scenes/edit/edit.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// Of X3D in XML, or in the classic encoding.
std::vector<Entity> xml_entities(std::string_view text, const SyntaxTree& tree, bool is_classic);
std::vector<Field> all_xml_fields(const Outline& outline, int entity);

// The edits of X3D in XML: see edit.h.
Change set_xml_field(const Outline& outline, int entity, std::string_view field,
                     std::string_view value);
Change reset_xml_field(const Outline& outline, int entity, std::string_view field);
Change remove_xml(const Outline& outline, int entity);
Change duplicate_xml(const Outline& outline, int entity);
/// A node with values as check_value allows them; the refusal of the first that is none.
Change add_xml(const Outline& outline, const EntityTemplate& made);
Change write_xml_camera(const Outline& outline, std::string_view name, const CameraPose& pose);
std::vector<EntityTemplate> xml_templates();

}  // namespace tessera::edit
