#include "coordinator/done_tiles.h"

#include <algorithm>
#include <span>

#include "job/job_messages.h"

namespace tessera {
namespace {

constexpr size_t kMostBytes = size_t{1} << 20;  ///< unless a single row is longer
constexpr int kMostPieces = 4096;

/// Appends the light of rows [first, last) of the tile.
void append_light(const Assembler& assembler, uint32_t tile, int first, int last,
                  std::string& light) {
  const auto channels = static_cast<size_t>(assembler.film().channels());
  for (int row = first; row < last; ++row) {
    const std::span<const float> values = assembler.row(tile, row);
    for (size_t pixel = 0; pixel < values.size(); pixel += channels) {
      light.append(reinterpret_cast<const char*>(values.data() + pixel),
                   kFilmChannels * sizeof(float));
    }
  }
}

}  // namespace

void add_done_tiles(const ActiveFrame& frame, const std::string& opening,
                    const v1::DoneTilesQuery& query, v1::DoneTiles& answer) {
  const Assembler& assembler = frame.assembler();
  const std::vector<uint32_t>& order = assembler.done_order();
  answer.set_run(opening + std::to_string(frame.begun().count()));
  const bool goes_on = query.run() == answer.run() && query.revision() <= order.size();
  auto at = static_cast<size_t>(goes_on ? query.revision() : 0);
  uint32_t rows = goes_on ? query.rows() : 0;
  size_t bytes = 0;
  while (at < order.size() && bytes < kMostBytes && answer.pieces_size() < kMostPieces) {
    const PixelRect& tile = assembler.tiles()[order[at]];
    const int first = tile.y0 + static_cast<int>(std::min<uint32_t>(rows, tile.height()));
    // One that is being traced again will be done anew.
    int last = tile.y1;
    if (first < tile.y1 && assembler.complete(order[at])) {
      const size_t row_bytes = static_cast<size_t>(tile.width()) * kFilmChannels * sizeof(float);
      const size_t fitting = std::max<size_t>((kMostBytes - bytes) / row_bytes, bytes == 0 ? 1 : 0);
      if (fitting == 0) break;
      last = first + static_cast<int>(std::min<size_t>(fitting, tile.y1 - first));
      v1::DoneTiles::Piece& piece = *answer.add_pieces();
      *piece.mutable_rect() = to_message(PixelRect{tile.x0, first, tile.x1, last});
      append_light(assembler, order[at], first, last, *piece.mutable_light());
      bytes += piece.light().size();
    }
    rows = last < tile.y1 ? static_cast<uint32_t>(last - tile.y0) : 0;
    if (rows == 0) ++at;
  }
  answer.set_revision(at);
  answer.set_rows(rows);
  answer.set_more(at < order.size());
}

}  // namespace tessera
