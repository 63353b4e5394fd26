#include "coordinator/jobs/film_shelf.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>
#include <span>
#include <utility>

#include "base/error.h"
#include "coordinator/tiles/assembler.h"
#include "job/tile_grid.h"

namespace tessera {

BlobData FilmShelf::to_blob(Film film) {
  const auto owner = std::make_shared<const Film>(std::move(film));
  return Blob::share(owner, std::as_bytes(owner->values()));
}

BlobData FilmShelf::keep_at_hand(const Digest& digest, Film film) {
  at_hand_.emplace_front(digest, to_blob(std::move(film)));
  uint64_t bytes = 0;
  for (const auto& [film_digest, data] : at_hand_) bytes += data->size();
  for (; at_hand_.size() > 1 && bytes > most_bytes_; at_hand_.pop_back()) {
    bytes -= at_hand_.back().second->size();
  }
  return at_hand_.front().second;
}

Digest FilmShelf::put(Film film, const Recipe& recipe) {
  const Digest digest = Digest::of(std::as_bytes(film.values()));
  note(digest, recipe);
  keep_at_hand(digest, std::move(film));
  return digest;
}

void FilmShelf::forget(const Digest& film) {
  recipes_.erase(film);
  std::erase_if(at_hand_, [&](const auto& entry) { return entry.first == film; });
}

BlobData FilmShelf::find(const Digest& digest, State* state) {
  const auto there = std::find_if(at_hand_.begin(), at_hand_.end(),
                                  [&](const auto& entry) { return entry.first == digest; });
  if (there != at_hand_.end()) {
    std::rotate(at_hand_.begin(), there, there + 1);
    return at_hand_.front().second;
  }
  const auto recipe = recipes_.find(digest);
  if (recipe == recipes_.end()) return nullptr;
  const auto& [key, crop, tile_size, aovs] = recipe->second;
  try {
    Assembler assembler(crop, cut_tiles(crop, tile_size), aovs);
    assembler.restore(store_->find(key));
    const bool is_whole = assembler.holes().empty();
    assembler.mark_holes();
    if (Digest::of(std::as_bytes(assembler.film().values())) != digest) {
      if (state) *state = is_whole ? State::changed : State::incomplete;
      return nullptr;
    }
    return keep_at_hand(digest, std::move(assembler.film()));
  } catch (const Error& error) {
    spdlog::warn("{}; a picture cannot be shown now", error.what());
  } catch (const std::bad_alloc&) {
    spdlog::warn("there is no memory for a picture of {}x{} pixels; it cannot be shown now",
                 crop.width(), crop.height());
  }
  return nullptr;
}

std::optional<std::pair<Film, uint64_t>> FilmShelf::part(const Recipe& recipe) const {
  try {
    Assembler assembler(recipe.crop, cut_tiles(recipe.crop, recipe.tile_size), recipe.aovs);
    assembler.restore(store_->find(recipe.tile_key));
    if (assembler.tiles_done() == 0) return std::nullopt;
    return std::pair(std::move(assembler.film()), assembler.tiles_done());
  } catch (const Error&) {
    return std::nullopt;
  } catch (const std::bad_alloc&) {
    return std::nullopt;
  }
}

}  // namespace tessera
