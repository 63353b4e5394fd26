#include "renderer/image/plain/jpeg_format.h"

#include <algorithm>
#include <cstdlib>
#include <span>

#include "renderer/image/plain/icc_profile.h"
#include "renderer/image/plain/jpeg_errors.h"
#include "renderer/image/plain/jpeg_slices.h"

namespace tessera {
namespace {

/// False after an error; the frame owns nothing.
bool read_header(jpeg_decompress_struct& info, JpegErrors& errors, const std::vector<char>& file) {
  if (setjmp(errors.place)) return false;
  jpeg_save_markers(&info, JPEG_APP0 + 2, 0xFFFF);  // where colour profiles are
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  return jpeg_read_header(&info, TRUE) == JPEG_HEADER_OK;
}

/// Fills the buffer again and again, and calls `full` with the bytes in it, until all rows are
/// read.
template <typename Full>
bool read_rows(jpeg_decompress_struct& info, JpegErrors& errors, std::vector<char>& buffer,
               size_t row_bytes, const Full& full) {
  if (setjmp(errors.place)) return false;
  jpeg_start_decompress(&info);
  const size_t rows = buffer.size() / row_bytes;
  while (info.output_scanline < info.output_height) {
    const size_t in_buffer = info.output_scanline % rows;
    auto* row = reinterpret_cast<JSAMPROW>(buffer.data() + in_buffer * row_bytes);
    jpeg_read_scanlines(&info, &row, 1);
    if (in_buffer + 1 == rows || info.output_scanline == info.output_height)
      full(std::span(buffer).first((in_buffer + 1) * row_bytes));
  }
  return info.err->num_warnings == 0;
}

bool read_profile(jpeg_decompress_struct& info, JpegErrors& errors, JOCTET*& profile,
                  unsigned& size) {
  if (setjmp(errors.place)) return false;
  return jpeg_read_icc_profile(&info, &profile, &size) != 0;
}

/// By the embedded colour profile; nothing where there is none, or it changes nothing or is
/// damaged.
std::optional<SrgbConversion> read_conversion(jpeg_decompress_struct& info, JpegErrors& errors) {
  JOCTET* profile = nullptr;
  unsigned size = 0;
  const bool is_there = read_profile(info, errors, profile, size);
  info.err->num_warnings = 0;  // of the profile: the picture may be good without
  if (!is_there) return std::nullopt;
  const auto conversion = SrgbConversion::from({profile, size});
  std::free(profile);
  return conversion;
}

std::optional<ImageAnswer> decode(jpeg_decompress_struct& info, JpegErrors& errors,
                                  const std::vector<char>& file, bool to_srgb,
                                  ImageStream& stream) {
  if (!read_header(info, errors, file) || info.err->num_warnings != 0) return std::nullopt;
  const bool is_grey = info.jpeg_color_space == JCS_GRAYSCALE;
  if (!is_grey && info.jpeg_color_space != JCS_YCbCr && info.jpeg_color_space != JCS_RGB) {
    return std::nullopt;
  }
  ImageAnswer answer;
  if (info.image_width > PixelLayout::kMostSide || info.image_height > PixelLayout::kMostSide) {
    return std::nullopt;
  }
  answer.layout = {static_cast<int32_t>(info.image_width), static_cast<int32_t>(info.image_height),
                   is_grey ? 1 : 3, 8};
  if (!answer.layout.is_legal()) return std::nullopt;
  const size_t row_bytes = answer.layout.bytes() / info.image_height;
  const auto channels = static_cast<size_t>(answer.layout.channels);
  const auto conversion = to_srgb && channels == 3 ? read_conversion(info, errors) : std::nullopt;
  const auto convert = [&](std::span<char> pixels) {
    if (conversion) conversion->convert(pixels, channels);
  };
  const auto send = [&](std::span<char> pixels) { stream.add({pixels.data(), pixels.size()}); };
  stream.begin(answer.layout);
  if (const auto slices = JpegSlices::cut(info, file)) {
    answer.is_sent = decode_slices(*slices, channels, convert, send);
  } else {
    constexpr size_t kPiece = size_t{256} << 10;
    std::vector<char> piece(std::max<size_t>(kPiece / row_bytes, 1) * row_bytes);
    answer.is_sent = read_rows(info, errors, piece, row_bytes, [&](std::span<char> pixels) {
      convert(pixels);
      send(pixels);
    });
  }
  stream.end(answer.is_sent);
  if (!answer.is_sent) return std::nullopt;
  return answer;
}

}  // namespace

bool is_jpeg(const std::vector<char>& file) {
  return file.size() > 3 && file[0] == '\xff' && file[1] == '\xd8' && file[2] == '\xff';
}

std::optional<ImageAnswer> decode_jpeg(const std::vector<char>& file, bool to_srgb,
                                       ImageStream& stream) {
  jpeg_decompress_struct info{};
  JpegErrors errors{};
  errors.attach(info);
  if (setjmp(errors.place)) return std::nullopt;
  jpeg_create_decompress(&info);
  auto answer = decode(info, errors, file, to_srgb, stream);
  jpeg_destroy_decompress(&info);
  return answer;
}

}  // namespace tessera
