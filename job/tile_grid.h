#pragma once

#include <vector>

#include "renderer/film/tile.h"

namespace tessera {

/// More tiles than this are refused: each costs memory and messages.
inline constexpr int64_t kMaxTiles = int64_t{1} << 20;

/// A side that gives each of `workers` many tiles and each tile work worth sending.
int choose_tile_size(const PixelRect& crop, int workers);

/// Throws usage_error for a tile size below 1 or one that gives more than kMaxTiles.
void check_tile_size(const PixelRect& crop, int tile_size);

/// `crop` cut along the lines at multiples of `tile_size` of the whole frame, in Morton order so
/// that tiles traced at one time see the same part of the scene. Throws as
/// check_tile_size() does.
std::vector<PixelRect> cut_tiles(const PixelRect& crop, int tile_size);

}  // namespace tessera
