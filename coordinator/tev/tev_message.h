#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "renderer/film/tile.h"

namespace tessera {

// Messages to the image viewer tev (its Ipc.cpp, version 1.17 and later): a length that counts
// itself, the kind, then fields; all little-endian.

/// A new image of red, green and blue, black as yet.
std::vector<std::byte> tev_create_image(const std::string& name, int width, int height);
/// Pixels of a part of it: `rect` relative to the image, its values rows from the top.
std::vector<std::byte> tev_update_image(const std::string& name, const PixelRect& rect,
                                        std::span<const float> values);

}  // namespace tessera
