#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/film/tile.h"

namespace tessera {

/// Which worker did what when while a frame was rendered: a timeline. Seconds count from when the
/// coordinator took the frame up.
struct FrameTrace {
  enum class Kind : uint8_t {
    scene,   ///< fetched and built the scene
    tile,    ///< from the assignment of a tile to its completion
    wasted,  ///< the same of a tile that another completed first
    lost,    ///< of one that its worker took with it when it was lost
  };
  struct Span {
    uint64_t worker = 0;
    Kind kind = Kind::tile;
    uint32_t tile = 0;
    PixelRect rect;  ///< of the tile
    double begin = 0, end = 0;
  };
  std::map<uint64_t, std::string> workers;  ///< their names
  std::vector<Span> spans;                  ///< by their ends
  uint64_t left_out = 0;                    ///< spans beyond the most that are kept
};

}  // namespace tessera
