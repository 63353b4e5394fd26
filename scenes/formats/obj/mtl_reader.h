#pragma once

#include <map>
#include <string>

#include "proto/tessera/v1/scene.pb.h"
#include "scenes/formats/obj/line_reader.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// Materials by name; where a name comes twice, the first one holds.
using MtlMaterials = std::map<std::string, v1::Material>;

/// Adds the materials of an MTL file (Wavefront's format). Colours are taken as linear. How its
/// numbers map to ours is in docs/scenes.md. Throws scene_error with the place.
void read_mtl(LineReader& reader, MtlMaterials& materials, Warnings& warnings);

}  // namespace tessera
