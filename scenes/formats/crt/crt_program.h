#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
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
  /// What an entity was made in: a call of a macro or a turn of a loop.
  struct Making {
    CrtSpan where;
    uint32_t turn = 0;   ///< from 1; 0: a call
    uint32_t above = 0;  ///< what that was made in: a number of makings from 1; 0: nothing
  };
  std::vector<Making> makings;
  /// Where the text of an entity stands, and what it was made in.
  struct Made {
    CrtSpan where;
    uint32_t in = 0;
  };
  std::unordered_map<const CrtEntity*, Made> made;  ///< where origins are kept
  bool uses_time = false;  ///< the script reads t: another frame is another scene
};

}  // namespace tessera
