#include "scenes/formats/x3d/document/gunzip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <memory>

#include "base/error.h"

namespace tessera {
namespace {

constexpr int kGzipWindow = 15 + 16;  // the largest window, and gzip's framing

}  // namespace

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string gunzip(std::string_view bytes, size_t most, const std::string& file) {
  z_stream stream{};
  if (inflateInit2(&stream, kGzipWindow) != Z_OK)
    throw scene_error({file}, "no memory to unpack it", "more");
  const std::unique_ptr<z_stream, int (*)(z_stream*)> closer(&stream, &inflateEnd);
  // zlib's interface is not const, but reads only.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  std::string out;
  std::array<char, 65536> part;
  size_t left = bytes.size();
  for (int state = Z_OK; state != Z_STREAM_END;) {
    if (stream.avail_in == 0) {
      stream.avail_in = static_cast<uInt>(std::min<size_t>(left, 1u << 30));
      left -= stream.avail_in;
    }
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = part.size();
    state = inflate(&stream, Z_NO_FLUSH);
    const size_t got = part.size() - stream.avail_out;
    if ((state != Z_OK && state != Z_STREAM_END) || (got == 0 && state == Z_OK))
      throw scene_error({file}, "broken gzip data", "a whole gzipped file");
    if (got > most - out.size())
      throw scene_error({file}, "a gzipped file that is too large",
                        fmt::format("at most {} MiB unpacked", most >> 20));
    out.append(part.data(), got);
  }
  return out;
}

}  // namespace tessera
