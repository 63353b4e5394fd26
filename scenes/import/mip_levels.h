#pragma once

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Appends to the picture's one level all smaller ones, each half the last rounded up, and returns
/// how many there are then. Means are taken of light: of sRGB-encoded 8-bit colours after decoding
/// them, and weighted by alpha where there is one that is not associated.
uint32_t add_mip_levels(DecodedTexture& texture, bool is_srgb);

}  // namespace tessera
