#include "image/plain/jpeg_format.h"

#include <cstdlib>
#include <memory>
#include <span>

#include "image/plain/icc_profile.h"
#include "image/plain/jpeg_decompressor.h"
#include "image/plain/jpeg_slices.h"

namespace tessera {
namespace {

/// False after an error; the frame owns nothing.
bool read_header(JpegDecompressor& jpeg, std::span<const char> file) {
  if (setjmp(jpeg.place)) return false;
  jpeg_decompress_struct& info = jpeg.info;
  jpeg_create_decompress(&info);
  jpeg_save_markers(&info, JPEG_APP0 + 2, 0xFFFF);  // where colour profiles are
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  return jpeg_read_header(&info, TRUE) == JPEG_HEADER_OK;
}

/// False after an error; the frame owns nothing. After a warning libjpeg goes on with what it can
/// make out, and grey for the rest.
bool read_rows(JpegDecompressor& jpeg, size_t row_bytes, std::span<char> pixels) {
  if (setjmp(jpeg.place)) return false;
  jpeg_decompress_struct& info = jpeg.info;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    auto* row = reinterpret_cast<JSAMPROW>(pixels.data() + info.output_scanline * row_bytes);
    jpeg_read_scanlines(&info, &row, 1);
  }
  return true;
}

bool read_profile(JpegDecompressor& jpeg, JOCTET*& profile, unsigned& size) {
  if (setjmp(jpeg.place)) return false;
  return jpeg_read_icc_profile(&jpeg.info, &profile, &size) != 0;
}

/// By the embedded colour profile; nothing where there is none, or it changes nothing or is
/// damaged.
std::optional<SrgbConversion> read_conversion(JpegDecompressor& jpeg) {
  JOCTET* profile = nullptr;
  unsigned size = 0;
  const bool was_whole = jpeg.damage[0] == 0;
  const bool is_there = read_profile(jpeg, profile, size);
  if (was_whole) jpeg.damage[0] = 0;  // of the profile: the picture may be good without
  if (!is_there) return std::nullopt;
  const std::unique_ptr<JOCTET, void (*)(void*)> ours(profile, std::free);
  return SrgbConversion::from({profile, size});
}

}  // namespace

std::optional<ImageAnswer> decode_jpeg(std::span<const char> file, bool to_srgb) {
  JpegDecompressor jpeg;
  const jpeg_decompress_struct& info = jpeg.info;
  if (!read_header(jpeg, file)) return std::nullopt;
  const bool is_grey = info.jpeg_color_space == JCS_GRAYSCALE;
  if (!is_grey && info.jpeg_color_space != JCS_YCbCr && info.jpeg_color_space != JCS_RGB) {
    return std::nullopt;
  }
  ImageAnswer answer;
  answer.meaning.from_integers = true;
  if (info.image_width > PixelLayout::kMostSide || info.image_height > PixelLayout::kMostSide) {
    return std::nullopt;
  }
  answer.layout = {static_cast<int32_t>(info.image_width), static_cast<int32_t>(info.image_height),
                   is_grey ? 1 : 3, 8};
  if (!answer.layout.is_legal()) return std::nullopt;
  const size_t row_bytes = answer.layout.bytes() / info.image_height;
  const auto channels = static_cast<size_t>(answer.layout.channels);
  const auto conversion = to_srgb && channels == 3 ? read_conversion(jpeg) : std::nullopt;
  const auto finish = [&](std::span<char> pixels) {
    if (conversion) conversion->convert(pixels, channels);
    if (answer.shared) SealedMemory::finish(pixels);
  };
  const std::span<char> pixels = answer.make_room();
  const auto slices = JpegSlices::cut(info, file);
  // What is damaged in one slice shows in its place alone when the rows are read in their order.
  if (!slices || !decode_slices(*slices, channels, pixels, finish)) {
    if (!read_rows(jpeg, row_bytes, pixels)) return std::nullopt;
    finish(pixels);
  }
  answer.damage = jpeg.damage;
  return answer;
}

}  // namespace tessera
