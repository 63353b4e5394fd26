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

/// Keeps finished tiles beyond the life of this process, by the job that they are of: the digest of
/// all that its pixels depend on. Used by one thread.
class TileStore {
 public:
  virtual ~TileStore() = default;
  /// From when this returns, the tile outlives the process. Throws render_error where it cannot be
  /// kept: a full disk, say; it may be tried again.
  virtual void keep(const Digest& job, const FinishedTile& tile) = 0;
  /// Takes it back, if it is there.
  virtual void drop(const Digest& job, const PixelRect& tile) = 0;
  /// Takes all tiles of the job back.
  virtual void drop_all(const Digest& job) = 0;
  /// What is kept of the job. Unsafe bytes: whoever takes them up checks the bands. Throws
  /// temporary_error where they cannot be read now.
  virtual std::vector<FinishedTile> find(const Digest& job) = 0;
};

}  // namespace tessera
