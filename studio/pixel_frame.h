#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "renderer/film/tile.h"

namespace tessera {

/// A piece of a view's picture on its way to the page, as a binary frame has it.
struct PixelFrame {
  enum class Kind : uint8_t {
    tile = 0,
    whole = 1,
    parts = 2,
    chunk = 3,
    pinned = 4,
    difference = 5
  };
  static constexpr uint16_t kLastPieceOfPass = 1, kLastPass = 2;

  Kind kind = Kind::tile;
  uint8_t pane = 0;
  uint8_t scale = 1;
  uint32_t serial = 0;  ///< of the pass
  PixelRect rect;       ///< in pixels of the picture at that scale
  uint16_t picture_width = 0, picture_height = 0;
  uint32_t version = 0;  ///< of the text that it shows
  uint16_t samples = 0;  ///< a pixel, UINT16_MAX for more
  uint16_t flags = 0;
};

/// The bytes of the frame: a header of 32 bytes, little-endian, then `pixels`, rows from the top,
/// four bytes a pixel, deflated (RFC 1951) where `deflate`.
std::string encode_pixel_frame(const PixelFrame& frame, std::span<const uint8_t> pixels,
                               bool deflate);

/// A piece of a file that a page sends, as a binary frame has it.
struct FileChunk {
  uint32_t number = 0;
  bool is_last = false;
  std::string_view bytes;  ///< within the frame
};
/// Nothing where the frame is none of a chunk.
std::optional<FileChunk> decode_file_chunk(std::string_view frame);

}  // namespace tessera
