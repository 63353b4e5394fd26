#pragma once

#include <algorithm>
#include <cstdint>

#include "renderer/film/block.h"
#include "renderer/film/tile.h"

namespace tessera {

using WorkerId = uint64_t;
using LeaseId = uint64_t;

/// What one lease is for: a tile of the grid, or one of the equal strips of whole rows that it was
/// split into. Its packed form is the low half of a lease.
struct TilePiece {
  static constexpr uint32_t kMaxParts = 64;

  uint32_t tile = 0;
  uint32_t part = 0, parts = 1;  ///< part < parts <= kMaxParts

  bool whole() const { return parts == 1; }
  uint32_t packed() const { return tile | part << kTileBits | (parts - 1) << (kTileBits + kBits); }
  static TilePiece unpack(uint32_t packed) {
    return {packed & ((1u << kTileBits) - 1), packed >> kTileBits & (kMaxParts - 1),
            (packed >> (kTileBits + kBits)) + 1};
  }
  static TilePiece of(LeaseId lease) { return unpack(static_cast<uint32_t>(lease)); }

  /// Its rows of that rectangle of the tile; empty where it has fewer rows than parts, or this is
  /// no part. Strips high enough end where a block of adaptive sampling does, which would otherwise
  /// be traced for both.
  PixelRect rect(const PixelRect& tile_rect) const {
    const int64_t height = tile_rect.height();
    if (part >= parts || height < parts) return {};
    PixelRect strip = tile_rect;
    const auto line = [&](uint32_t i) {
      const int y = tile_rect.y0 + static_cast<int>(height * i / parts);
      const bool outer = i == 0 || i == parts;
      return outer || height < int64_t{kBlockSide} * parts ? y : y / kBlockSide * kBlockSide;
    };
    strip.y0 = line(part);
    strip.y1 = line(part + 1);
    return strip;
  }
  friend bool operator==(const TilePiece&, const TilePiece&) = default;

 private:
  static constexpr int kTileBits = 20, kBits = 6;  // 2^20 is kMaxTiles of job/tile_grid.h
};

}  // namespace tessera
