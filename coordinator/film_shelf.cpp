#include "coordinator/film_shelf.h"

#include <algorithm>
#include <span>

#include "coordinator/assembler.h"
#include "job/tile_grid.h"

namespace tessera {
namespace {

constexpr size_t kAtHand = 4;

}  // namespace

BlobData FilmShelf::keep_at_hand(const Digest& digest, const Film& film) {
  const auto pixels = std::as_bytes(film.values());
  at_hand_.emplace_front(
      digest, std::make_shared<const Blob>(std::vector<std::byte>(pixels.begin(), pixels.end())));
  if (at_hand_.size() > kAtHand) at_hand_.pop_back();
  return at_hand_.front().second;
}

Digest FilmShelf::put(const Film& film, const Recipe& recipe) {
  const Digest digest = Digest::of(std::as_bytes(film.values()));
  note(digest, recipe);
  keep_at_hand(digest, film);
  return digest;
}

void FilmShelf::forget(const Digest& film) {
  recipes_.erase(film);
  std::erase_if(at_hand_, [&](const auto& entry) { return entry.first == film; });
}

BlobData FilmShelf::find(const Digest& digest) {
  const auto there = std::find_if(at_hand_.begin(), at_hand_.end(),
                                  [&](const auto& entry) { return entry.first == digest; });
  if (there != at_hand_.end()) return there->second;
  const auto recipe = recipes_.find(digest);
  if (recipe == recipes_.end()) return nullptr;
  const auto& [key, crop, tile_size] = recipe->second;
  Assembler assembler(crop, cut_tiles(crop, tile_size));
  assembler.restore(store_->find(key));
  assembler.mark_holes();
  if (Digest::of(std::as_bytes(assembler.film().values())) != digest) return nullptr;
  return keep_at_hand(digest, assembler.film());
}

}  // namespace tessera
