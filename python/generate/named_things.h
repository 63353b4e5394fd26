#pragma once

#include <map>
#include <string>

namespace tessera {

/// The message whose things a string field names, so that the thing itself may stand there: of the
/// field "Shape.materials" it is "Material". Empty: it names none.
inline std::string type_named_by(const std::string& field) {
  static const std::map<std::string, std::string> types = {
      {"ColorInput.texture", "Texture"},    {"FloatInput.texture", "Texture"},
      {"Material.normal_map", "Texture"},   {"Background.Panorama.texture", "Texture"},
      {"Background.Cube.front", "Texture"}, {"Background.Cube.back", "Texture"},
      {"Background.Cube.left", "Texture"},  {"Background.Cube.right", "Texture"},
      {"Background.Cube.top", "Texture"},   {"Background.Cube.bottom", "Texture"},
      {"Material.back", "Material"},        {"Shape.materials", "Material"},
      {"Include.material", "Material"},     {"Node.instance_of", "Object"}};
  const auto found = types.find(field);
  return found == types.end() ? std::string() : found->second;
}

}  // namespace tessera
