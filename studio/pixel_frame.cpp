#include "studio/pixel_frame.h"

#include <zlib.h>

#include <array>
#include <cstring>

#include "base/error.h"

namespace tessera {
namespace {

constexpr size_t kHeaderBytes = 32;

template <typename Number>
void put(std::string& bytes, size_t at, Number number) {
  for (size_t i = 0; i < sizeof(Number); ++i) {
    bytes[at + i] = static_cast<char>(number & 0xff);
    if constexpr (sizeof(Number) > 1) number = static_cast<Number>(number >> 8);
  }
}

/// Level 1: on two cores its time, not its size, decides.
void append_deflated(std::span<const uint8_t> pixels, std::string& bytes) {
  z_stream stream{};
  constexpr int kRawWindow = -15, kMemory = 8;
  if (deflateInit2(&stream, 1, Z_DEFLATED, kRawWindow, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  const size_t begin = bytes.size();
  bytes.resize(begin + deflateBound(&stream, pixels.size()));
  stream.next_in = const_cast<Bytef*>(pixels.data());
  stream.avail_in = static_cast<uInt>(pixels.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data() + begin);
  stream.avail_out = static_cast<uInt>(bytes.size() - begin);
  const int end = ::deflate(&stream, Z_FINISH);
  bytes.resize(begin + stream.total_out);
  deflateEnd(&stream);
  TESSERA_CHECK(end == Z_STREAM_END, std::to_string(end));
}

}  // namespace

std::string encode_pixel_frame(const PixelFrame& frame, std::span<const uint8_t> pixels,
                               bool deflate) {
  std::string bytes(kHeaderBytes, '\0');
  std::memcpy(bytes.data(), "TSPX", 4);
  put(bytes, 4, static_cast<uint8_t>(frame.kind));
  put(bytes, 5, static_cast<uint8_t>(deflate ? 1 : 0));
  put(bytes, 6, frame.pane);
  put(bytes, 7, frame.scale);
  put(bytes, 8, frame.serial);
  put(bytes, 12, static_cast<uint16_t>(frame.rect.x0));
  put(bytes, 14, static_cast<uint16_t>(frame.rect.y0));
  put(bytes, 16, static_cast<uint16_t>(frame.rect.width()));
  put(bytes, 18, static_cast<uint16_t>(frame.rect.height()));
  put(bytes, 20, frame.picture_width);
  put(bytes, 22, frame.picture_height);
  put(bytes, 24, frame.version);
  put(bytes, 28, frame.samples);
  put(bytes, 30, frame.flags);
  if (deflate) {
    append_deflated(pixels, bytes);
  } else {
    bytes.append(reinterpret_cast<const char*>(pixels.data()), pixels.size());
  }
  return bytes;
}

std::optional<FileChunk> decode_file_chunk(std::string_view frame) {
  const auto number_at = [&](size_t at, size_t count) {
    uint32_t value = 0;
    for (size_t i = count; i-- > 0;)
      value = (value << 8) | static_cast<unsigned char>(frame[at + i]);
    return value;
  };
  if (frame.size() < kHeaderBytes || !frame.starts_with("TSPX")) return std::nullopt;
  if (number_at(4, 1) != static_cast<uint32_t>(PixelFrame::Kind::chunk) || number_at(5, 1) != 0)
    return std::nullopt;
  return FileChunk{.number = number_at(8, 4),
                   .is_last = (number_at(30, 2) & PixelFrame::kLastPieceOfPass) != 0,
                   .bytes = frame.substr(kHeaderBytes)};
}

}  // namespace tessera
