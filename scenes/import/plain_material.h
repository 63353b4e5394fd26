#pragma once

#include <string>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// What a surface is made of whose file does not say: matte grey of .8, or the colours of its
/// vertices in its place.
v1::Material plain_material(const std::string& name, bool has_vertex_colors);

}  // namespace tessera
