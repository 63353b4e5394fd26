#include "renderer/image/plain/jpeg_format.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
// After <cstdio>, whose FILE it names.
#include <jpeglib.h>

#include "renderer/image/plain/icc_profile.h"

namespace tessera {
namespace {

/// libjpeg's errors leave by longjmp(), so no frame between may own anything.
struct ErrorManager {
  jpeg_error_mgr base;
  std::jmp_buf place;
};

void leave(j_common_ptr info) {
  std::longjmp(reinterpret_cast<ErrorManager*>(info->err)->place, 1);
}
void count_message(j_common_ptr info, int level) {
  if (level < 0) ++info->err->num_warnings;
}

/// False after an error; the frame owns nothing.
bool read_header(jpeg_decompress_struct& info, ErrorManager& errors,
                 const std::vector<char>& file) {
  if (setjmp(errors.place)) return false;
  jpeg_save_markers(&info, JPEG_APP0 + 2, 0xFFFF);  // where colour profiles are
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  return jpeg_read_header(&info, TRUE) == JPEG_HEADER_OK;
}

bool read_rows(jpeg_decompress_struct& info, ErrorManager& errors, char* rows, size_t row_bytes) {
  if (setjmp(errors.place)) return false;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    auto* row = reinterpret_cast<JSAMPROW>(rows + info.output_scanline * row_bytes);
    jpeg_read_scanlines(&info, &row, 1);
  }
  return info.err->num_warnings == 0;
}

void heed_profile(jpeg_decompress_struct& info, ErrorManager& errors, ImageAnswer& answer) {
  if (setjmp(errors.place)) return;
  JOCTET* profile = nullptr;
  unsigned size = 0;
  if (!jpeg_read_icc_profile(&info, &profile, &size)) return;
  convert_to_srgb({profile, size}, answer);
  std::free(profile);
}

std::optional<ImageAnswer> decode(jpeg_decompress_struct& info, ErrorManager& errors,
                                  const std::vector<char>& file, bool to_srgb) {
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
  answer.payload.resize(answer.layout.bytes());
  const size_t row_bytes = answer.payload.size() / info.image_height;
  if (!read_rows(info, errors, answer.payload.data(), row_bytes)) return std::nullopt;
  if (to_srgb) heed_profile(info, errors, answer);
  return answer;
}

}  // namespace

bool is_jpeg(const std::vector<char>& file) {
  return file.size() > 3 && file[0] == '\xff' && file[1] == '\xd8' && file[2] == '\xff';
}

std::optional<ImageAnswer> decode_jpeg(const std::vector<char>& file, bool to_srgb) {
  jpeg_decompress_struct info{};
  ErrorManager errors{};
  info.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = leave;
  errors.base.emit_message = count_message;
  if (setjmp(errors.place)) return std::nullopt;
  jpeg_create_decompress(&info);
  auto answer = decode(info, errors, file, to_srgb);
  jpeg_destroy_decompress(&info);
  return answer;
}

}  // namespace tessera
