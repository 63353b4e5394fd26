#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenes/formats/crt/crt_value.h"

namespace tessera {

/// What a script asks for, after it was run. Pointers go into the heap that it was run with.
struct CrtProgram {
  struct Image {
    std::optional<uint32_t> width, height;
  };
  v1::Metadata metadata;
  std::vector<const CrtLight*> lights;
  const CrtCamera* camera = nullptr;
  const CrtBackground* background = nullptr;  ///< null: white
  uint32_t supersampling = 1;                 ///< the side of the grid of samples in a pixel
  uint32_t dof_samples = 1;
  uint32_t recursion_depth = 3;
  Image image;
  std::vector<const CrtEntity*> entities;
  /// The variable that a thing was first assigned to.
  std::map<const void*, std::string> names;
  bool uses_time = false;  ///< the script reads t: another frame is another scene
};

}  // namespace tessera
