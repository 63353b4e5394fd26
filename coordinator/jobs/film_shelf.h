#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/digest.h"
#include "coordinator/tiles/tile_store.h"
#include "proto/wire/blob_store.h"
#include "renderer/film/film.h"

namespace tessera {

/// The films of frames that have ended, as blobs: those asked for last at hand, others put together
/// again from their tiles. Of the coordinator's thread.
class FilmShelf {
 public:
  /// Films at hand take so many bytes together, or one takes more.
  static constexpr uint64_t kAtHandBytes = uint64_t{1} << 30;
  explicit FilmShelf(std::shared_ptr<TileStore> store, uint64_t at_hand_bytes = kAtHandBytes)
      : store_(std::move(store)), most_bytes_(at_hand_bytes) {}

  /// How to make the film of that digest again.
  struct Recipe {
    Digest tile_key;
    PixelRect crop;
    int tile_size = 1;
    AovSet aovs{};
  };
  /// Names the film, and keeps it at hand for now.
  Digest put(Film film, const Recipe& recipe);
  void note(const Digest& film, const Recipe& recipe) { recipes_.emplace(film, recipe); }
  void forget(const Digest& film);
  /// What a film's tiles are found to be.
  enum class State {
    sound,       ///< or nothing is known against them: they cannot be read now, say
    incomplete,  ///< some are gone, or damaged and dropped
    changed,     ///< they are all there, and make another film
  };
  /// Null where there is no such film, no memory for it, or its tiles are no longer what they were,
  /// which `state`, where it is given, then tells.
  BlobData find(const Digest& film, State* state = nullptr);
  /// The film's values, which it gives away.
  static BlobData to_blob(Film film);
  /// What there is in the store of the film, and of how many tiles; nothing where there is no tile,
  /// or no memory for it.
  std::optional<std::pair<Film, uint64_t>> part(const Recipe& recipe) const;

 private:
  BlobData keep_at_hand(const Digest& digest, Film film);

  std::shared_ptr<TileStore> store_;
  std::unordered_map<Digest, Recipe> recipes_;
  uint64_t most_bytes_;
  std::deque<std::pair<Digest, BlobData>> at_hand_;  ///< the one asked for last first
};

}  // namespace tessera
