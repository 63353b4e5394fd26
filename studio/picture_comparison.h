#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "renderer/film/film.h"
#include "studio/picture_stream.h"
#include "studio/studio_orders.h"

namespace tessera {

/// Tells the page what is pinned from now on: null where there is none of what it ordered.
SendText pinned_answer(const PinPicture& order, const Film* film);

/// How the light of one picture differs from that of another, with the other as the truth: the
/// numbers of `tessera compare --metrics` for their EXR files, by its names in lower case. Both
/// have one size; where they have not, "why" says so. Takes seconds for large pictures.
nlohmann::json comparison_json(const Film& picture, const Film& reference);

/// Opaque pixels, four bytes each: by how much the channel that differs most does, on the scale of
/// channel_pixels() from nothing to the greatest difference. Pixels that are equal are black.
std::vector<uint8_t> difference_pixels(const Film& picture, const Film& reference);

/// Tells pages how what they see differs from what is pinned there. Used by one thread.
class PictureComparer {
 public:
  /// `send` is called with what pages are told.
  PictureComparer(PictureStream::Sinks sink_of, std::function<void(SendText)> send)
      : sink_of_(std::move(sink_of)), send_(std::move(send)) {}

  /// Takes seconds for large pictures. Nothing: one of the two is not there. Returns what
  /// catch_up() does.
  bool compare(const ComparePictures& order, const std::optional<PictureStream::Pair>& pair);
  /// Sends what pages had no room for. Returns whether any still waits.
  bool catch_up() { return tessera::catch_up(waiting_, sink_of_); }

 private:
  PictureStream::Sinks sink_of_;
  std::function<void(SendText)> send_;
  uint32_t number_ = 0;  ///< of the last picture of a difference
  WaitingBands waiting_;
};

}  // namespace tessera
