#include "image/plain/jpeg_slices.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "image/plain/jpeg_decompressor.h"

namespace tessera {
namespace {

constexpr unsigned kWidth = 203;

struct Form {
  unsigned height = 300;
  int across = 1, down = 1;     ///< pixels of brightness to one of colour
  unsigned rows_of_blocks = 1;  ///< between restart markers; 0: none
  bool progressive = false;
};

std::vector<unsigned char> some_pixels(unsigned height) {
  std::vector<unsigned char> pixels(size_t{kWidth} * height * 3);
  uint32_t noise = 7;
  for (size_t i = 0; i < pixels.size(); ++i) {
    noise = noise * 1664525u + 1013904223u;
    pixels[i] = static_cast<unsigned char>(i / 700 + (noise >> 27));
  }
  return pixels;
}

std::vector<char> encoded(const Form& form) {
  const std::vector<unsigned char> pixels = some_pixels(form.height);
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = kWidth;
  info.image_height = form.height;
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  info.comp_info[0].h_samp_factor = form.across;
  info.comp_info[0].v_samp_factor = form.down;
  info.restart_in_rows = static_cast<int>(form.rows_of_blocks);
  if (form.progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < form.height) {
    auto* row = const_cast<JSAMPROW>(&pixels[size_t{info.next_scanline} * kWidth * 3]);
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::vector<char> file(bytes, bytes + size);
  std::free(bytes);
  return file;
}

struct Decoded {
  size_t slices = 0;  ///< 0: not cut
  bool is_whole = false;
  size_t finished = 0;  ///< bytes
  std::vector<char> by_slices, at_once;
};

Decoded decode(const std::vector<char>& file) {
  Decoded out;
  JpegDecompressor jpeg;
  jpeg_decompress_struct& info = jpeg.info;
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  jpeg_read_header(&info, TRUE);
  if (const auto slices = JpegSlices::cut(info, file)) {
    out.slices = slices->count();
    out.by_slices.resize(size_t{kWidth} * 3 * info.image_height);
    std::atomic<size_t> finished = 0;
    out.is_whole = decode_slices(*slices, 3, out.by_slices,
                                 [&](std::span<char> pixels) { finished += pixels.size(); });
    out.finished = finished;
  }
  jpeg_start_decompress(&info);
  out.at_once.resize(size_t{kWidth} * 3 * info.output_height);
  while (info.output_scanline < info.output_height) {
    auto* row = reinterpret_cast<JSAMPROW>(&out.at_once[size_t{info.output_scanline} * kWidth * 3]);
    jpeg_read_scanlines(&info, &row, 1);
  }
  return out;
}

TEST(JpegSlices, HaveThePixelsOfTheWhole) {
  const struct {
    Form form;
    size_t slices;
  } cases[] = {{{}, 5},
               {{.height = 320}, 5},
               {{.height = 321}, 6},
               {{.height = 65}, 2},
               {{.across = 2}, 5},
               {{.rows_of_blocks = 2}, 3}};
  for (const auto& [form, slices] : cases) {
    const Decoded decoded = decode(encoded(form));
    EXPECT_EQ(decoded.slices, slices) << form.height;
    EXPECT_TRUE(decoded.is_whole);
    EXPECT_EQ(decoded.finished, decoded.at_once.size());
    EXPECT_EQ(decoded.by_slices, decoded.at_once) << form.height << " " << form.across;
  }
}

TEST(JpegSlices, AreNotCutWhereRowsDependOnOthers) {
  for (const Form& form : {Form{.down = 2}, Form{.across = 2, .down = 2}, Form{.progressive = true},
                           Form{.rows_of_blocks = 0}, Form{.height = 64}})
    EXPECT_EQ(decode(encoded(form)).slices, 0u) << form.across << form.down;
}

TEST(JpegSlices, AreNotCutWhereAMarkerOrTheEndIsMissing) {
  const std::vector<char> file = encoded({});
  std::vector<char> short_of_end(file.begin(), file.end() - 2);
  EXPECT_EQ(decode(short_of_end).slices, 0u);
  std::vector<char> without = file;
  for (size_t i = without.size() / 2;; ++i) {
    if (without[i] != '\xff' || without[i + 1] == 0) continue;
    without[i + 1] = 0;
    break;
  }
  EXPECT_EQ(decode(without).slices, 0u);
}

TEST(JpegSlices, ThatAreDamagedAreTold) {
  std::vector<char> file = encoded({});
  // The data of a run is cut short, and its marker stays.
  size_t at = file.size() / 2;
  while (file[at] != '\xff' || file[at + 1] == 0) ++at;
  file.erase(file.begin() + static_cast<std::ptrdiff_t>(at) - 40,
             file.begin() + static_cast<std::ptrdiff_t>(at));
  const Decoded decoded = decode(file);
  EXPECT_EQ(decoded.slices, 5u);
  EXPECT_FALSE(decoded.is_whole);
  EXPECT_LT(decoded.finished, decoded.at_once.size());
}

}  // namespace
}  // namespace tessera
