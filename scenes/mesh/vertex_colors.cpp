#include "scenes/mesh/vertex_colors.h"

#include "renderer/math/encodings.h"

namespace tessera {

float vertex_light(double component, VertexColorSource source) {
  switch (source) {
    case VertexColorSource::obj:
    case VertexColorSource::ply_integer:
      return static_cast<float>(srgb_to_linear(component));
    case VertexColorSource::ply_float:
    case VertexColorSource::gltf:
      break;
  }
  return static_cast<float>(component);
}

}  // namespace tessera
