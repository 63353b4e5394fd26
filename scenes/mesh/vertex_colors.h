#pragma once

#include <cstdint>

namespace tessera {

/// Who wrote the numbers of a vertex's colour, 1 being all of a channel.
enum class VertexColorSource : uint8_t {
  obj,          ///< sRGB codes, as Blender, three.js and MeshLab write and read them
  ply_integer,  ///< sRGB codes, as scanners write them
  ply_float,    ///< linear
  gltf          ///< linear (glTF 2.0 specification, 3.9.2)
};

/// The light that a component of red, green or blue stands for. Alpha needs no such.
float vertex_light(double component, VertexColorSource source);

}  // namespace tessera
