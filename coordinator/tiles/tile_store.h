#pragma once

#include <vector>

#include "base/digest.h"
#include "proto/tessera/v1/farm.pb.h"
#include "renderer/film/tile.h"

namespace tessera {

/// What a finished tile leaves: its rows as a worker would send them, checksums included, the last
/// band with the tile's counters.
struct FinishedTile {
  PixelRect rect;
  v1::KeptTile kept;
};

/// A tile that is kept: the key that it is kept under, and its place in the frame.
struct StoredTile {
  Digest key;
  PixelRect rect;
};

/// Keeps finished tiles beyond the life of this process, by the tile_key() of their frame: the
/// digest of all that its pixels depend on. Used by one thread.
class TileStore {
 public:
  virtual ~TileStore() = default;
  /// From when this returns, the tile outlives the process. Throws render_error where it cannot be
  /// kept: a full disk, say; it may be tried again.
  virtual void keep(const Digest& key, const FinishedTile& tile) = 0;
  /// Takes it back, if it is there.
  virtual void drop(const Digest& key, const PixelRect& tile) = 0;
  /// Takes all tiles of the frame back.
  virtual void drop_all(const Digest& key) = 0;
  /// What is kept of the frame. Unsafe bytes: whoever takes them up checks the bands. Throws
  /// temporary_error where they cannot be read now.
  virtual std::vector<FinishedTile> find(const Digest& key) = 0;
};

}  // namespace tessera
