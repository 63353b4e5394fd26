#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "proto/tessera/v1/scene.pb.h"
#include "scenes/formats/obj/mtl_map.h"
#include "scenes/import/loaded_scene.h"
#include "scenes/import/texture_set.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// One newmtl block as written.
struct MtlEntry {
  using Rgb = std::array<float, 3>;

  std::string name;
  std::optional<Rgb> ambient, diffuse, specular, emission, filter;
  std::map<std::string, float> numbers;  ///< by statement: Ns, Ni, d, Tr, Pr, Pm, Pc, Pcr
  SourcePlace transparency_place;        ///< of the number of Tr, where there is one
  std::optional<int> illumination;
  std::map<std::string, MtlMap> maps;  ///< by statement in lower case; bump for all its spellings
};

/// What is in one or more MTL files.
struct MtlLibrary {
  std::map<std::string, v1::Material> materials;  ///< where a name comes twice, the first one holds
  TextureSet textures;                            ///< those that the materials name
  std::map<std::string, PictureChannel> picture_channels;  ///< as LoadedScene has them
};

/// Adds the entry as a material of our own with its textures, whose files are named as in the
/// entry. Bumps are in hundredths of the model's size, which is not known here.
void add_mtl_material(const MtlEntry& entry, MtlLibrary& library, Warnings& warnings);

}  // namespace tessera
