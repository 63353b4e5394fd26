#include "image/plain/jpeg_slices.h"

#include <algorithm>
#include <cstring>

#include "image/plain/for_all.h"
#include "image/plain/jpeg_decompressor.h"

namespace tessera {
namespace {

unsigned char byte_at(std::span<const char> file, size_t at) {
  return static_cast<unsigned char>(file[at]);
}

/// Where the frame header of a header without surprises has the height; 0: nowhere.
size_t find_height(std::span<const char> header) {
  constexpr unsigned char kBaseline = 0xc0, kExtended = 0xc1, kScan = 0xda;
  for (size_t at = 2; at + 9 < header.size();) {
    const unsigned char marker = byte_at(header, at + 1);
    if (byte_at(header, at) != 0xff || marker == kScan) return 0;
    if (marker == kBaseline || marker == kExtended) return at + 5;
    at += 2 + (size_t{byte_at(header, at + 2)} << 8 | byte_at(header, at + 3));
  }
  return 0;
}

/// Where each run of data between restart markers begins, and the end of the image; else nothing.
std::vector<size_t> find_runs(std::span<const char> file, size_t at) {
  std::vector<size_t> begins{at};
  while (at + 1 < file.size()) {
    const void* const found = std::memchr(file.data() + at, 0xff, file.size() - 1 - at);
    if (!found) break;
    at = static_cast<size_t>(static_cast<const char*>(found) - file.data());
    const unsigned char marker = byte_at(file, at + 1);
    if (marker == 0) {
      at += 2;
    } else if (marker == 0xd0 + (begins.size() - 1) % 8) {
      begins.push_back(at += 2);
    } else {
      begins.push_back(at);
      return marker == 0xd9 ? begins : std::vector<size_t>{};
    }
  }
  return {};
}

/// False after an error or warning; the frame owns nothing.
bool read_slice(JpegDecompressor& jpeg, std::span<const char> file, size_t channels,
                std::span<char> pixels) {
  if (setjmp(jpeg.place)) return false;
  jpeg_decompress_struct& info = jpeg.info;
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  jpeg_read_header(&info, TRUE);
  jpeg_start_decompress(&info);
  const size_t row_bytes = size_t{info.output_width} * channels;
  if (static_cast<size_t>(info.output_components) != channels ||
      row_bytes * info.output_height != pixels.size())
    return false;
  while (info.output_scanline < info.output_height) {
    auto* row = reinterpret_cast<JSAMPROW>(pixels.data() + info.output_scanline * row_bytes);
    jpeg_read_scanlines(&info, &row, 1);
  }
  return info.err->num_warnings == 0;
}

}  // namespace

std::optional<JpegSlices> JpegSlices::cut(const jpeg_decompress_struct& info,
                                          std::span<const char> file) {
  if (info.progressive_mode || info.arith_code || info.restart_interval == 0 ||
      info.comps_in_scan != info.num_components)
    return std::nullopt;
  int across = 1, down = 1, least_down = MAX_SAMP_FACTOR;
  for (int i = 0; i < info.num_components; ++i) {
    across = std::max(across, info.comp_info[i].h_samp_factor);
    down = std::max(down, info.comp_info[i].v_samp_factor);
    least_down = std::min(least_down, info.comp_info[i].v_samp_factor);
  }
  // Colours of half the height are spread from the rows above and below; a single component has
  // blocks of its own order.
  if (down != 1 || least_down != 1 || (info.num_components == 1 && across != 1))
    return std::nullopt;
  const size_t block_width = size_t{DCTSIZE} * static_cast<size_t>(across);
  const size_t blocks = (info.image_width + block_width - 1) / block_width;
  if (info.restart_interval % blocks != 0) return std::nullopt;
  JpegSlices slices;
  slices.file_ = file;
  slices.width_ = info.image_width;
  slices.height_ = info.image_height;
  const size_t scan = file.size() - info.src->bytes_in_buffer;
  slices.height_at_ = find_height(slices.file_.first(scan));
  const size_t run_rows = info.restart_interval / blocks * DCTSIZE;
  const std::vector<size_t> runs = find_runs(slices.file_, scan);
  if (slices.height_at_ == 0 || runs.size() != (slices.height_ + run_rows - 1) / run_rows + 1)
    return std::nullopt;
  // Markers are numbered from 0 to 7, and every slice's from 0.
  constexpr size_t kRuns = 8, kMostPixels = size_t{1} << 22;
  slices.rows_ = kRuns * run_rows;
  if (slices.rows_ >= slices.height_ || slices.rows_ * slices.width_ > kMostPixels)
    return std::nullopt;
  for (size_t run = 0; run + 1 < runs.size(); run += kRuns) slices.begins_.push_back(runs[run]);
  slices.begins_.push_back(runs.back() + 2);
  return slices;
}

std::span<char> JpegSlices::decode(size_t number, size_t channels, std::span<char> pixels) const {
  const size_t rows = std::min(rows_, height_ - number * rows_);
  // The header with another height, the data, and an end in place of the marker that follows.
  const std::span<const char> header = file_.first(begins_[0]);
  const std::span<const char> data =
      file_.subspan(begins_[number], begins_[number + 1] - 2 - begins_[number]);
  std::vector<char> slice(header.begin(), header.end());
  slice[height_at_] = static_cast<char>(rows >> 8);
  slice[height_at_ + 1] = static_cast<char>(rows & 0xff);
  slice.insert(slice.end(), data.begin(), data.end());
  slice.insert(slice.end(), {'\xff', '\xd9'});
  const size_t row_bytes = width_ * channels;
  const std::span<char> place = pixels.subspan(number * rows_ * row_bytes, rows * row_bytes);
  JpegDecompressor jpeg;
  return read_slice(jpeg, slice, channels, place) ? place : std::span<char>();
}

bool decode_slices(const JpegSlices& slices, size_t channels, std::span<char> pixels,
                   const std::function<void(std::span<char>)>& finish) {
  return for_all(slices.count(), [&](size_t number) {
    const std::span<char> decoded = slices.decode(number, channels, pixels);
    if (!decoded.empty()) finish(decoded);
    return !decoded.empty();
  });
}

}  // namespace tessera
