#include "scenes/import/plain_material.h"

namespace tessera {

v1::Material plain_material(const std::string& name, bool has_vertex_colors) {
  v1::Material material;
  material.set_name(name);
  v1::Classic& classic = *material.mutable_classic();
  for (v1::ColorInput* input : {classic.mutable_ambient(), classic.mutable_diffuse()}) {
    v1::Color& grey = *input->mutable_value();
    grey.set_r(.8);
    grey.set_g(.8);
    grey.set_b(.8);
  }
  classic.set_vertex_color_replaces_diffuse(has_vertex_colors);
  return material;
}

}  // namespace tessera
