#pragma once

#include "renderer/film/tile.h"

namespace tessera {

struct Scene;

/// The pixels of the frame that may see some surface; of no other can any sample hit. The scene's
/// settings, camera and surfaces must be there.
PixelRect seen_rect(const Scene& scene);

}  // namespace tessera
