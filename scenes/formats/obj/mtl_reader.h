#pragma once

#include <functional>
#include <optional>
#include <string>

#include "scenes/formats/obj/line_reader.h"
#include "scenes/formats/obj/mtl_material.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// The name for Image.file of the picture that an MTL file calls `written` in the material of that
/// name, or nothing where it may not or can not be read.
using MtlPictureFinder = std::function<std::optional<std::string>(const std::string& written,
                                                                  const std::string& material)>;

/// Adds the materials of an MTL file (Wavefront's format, with the statements Pr, Pm, Pc, Pcr, Ke,
/// norm and their maps that programs added for physical materials). Colours are taken as linear.
/// How its numbers map to ours is in docs/scenes.md. Throws scene_error with the place.
void read_mtl(LineReader& reader, const MtlPictureFinder& find_picture, MtlLibrary& library,
              Warnings& warnings);

}  // namespace tessera
