#include "renderer/image/plain/png_format.h"

#include <png.h>
#include <zlib.h>

#include <cstring>
#include <stdexcept>

#include "renderer/image/plain/icc_profile.h"
#include "renderer/image/plain/plain_formats.h"

namespace tessera {
namespace {

// libpng is C, but of frames that a C++ exception may pass: it is built with unwind tables, and its
// manual allows leaving by other ways than longjmp().
[[noreturn]] void fail(png_structp, png_const_charp cause) { throw std::runtime_error(cause); }

/// A structure for reading or writing that ends with its scope.
class Png {
 public:
  explicit Png(bool reads) : reads_(reads) {
    png_ = reads ? png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, fail)
                 : png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, fail);
    info_ = png_ ? png_create_info_struct(png_) : nullptr;
    if (!info_) throw std::bad_alloc();
  }
  Png(const Png&) = delete;
  Png& operator=(const Png&) = delete;
  ~Png() {
    if (reads_)
      png_destroy_read_struct(&png_, &info_, nullptr);
    else
      png_destroy_write_struct(&png_, &info_);
  }
  png_structp get() const { return png_; }
  png_infop info() const { return info_; }

 private:
  bool reads_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

struct Source {
  const std::vector<char>& file;
  size_t at = 0;
};

void read_bytes(png_structp png, png_bytep out, size_t size) {
  auto& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (size > source.file.size() - source.at) png_error(png, "the file ends too early");
  std::memcpy(out, source.file.data() + source.at, size);
  source.at += size;
}

void write_bytes(png_structp png, png_bytep bytes, size_t size) {
  auto& file = *static_cast<std::vector<char>*>(png_get_io_ptr(png));
  file.insert(file.end(), bytes, bytes + size);
}

void flush(png_structp) {}

void set_texts(const Png& png, const ImageAttributes& attributes) {
  for (const auto& [name, text] : image_texts(attributes)) {
    png_text entry{};
    entry.compression = PNG_TEXT_COMPRESSION_NONE;
    std::string key = name, value = text;
    entry.key = key.data();
    entry.text = value.data();
    entry.text_length = value.size();
    png_set_text(png.get(), png.info(), &entry, 1);
  }
}

std::optional<ImageAnswer> decode(const Png& png, const std::vector<char>& file, bool to_srgb) {
  Source source{file};
  png_set_read_fn(png.get(), &source, read_bytes);
  png_set_user_limits(png.get(), PixelLayout::kMostSide, PixelLayout::kMostSide);
  png_read_info(png.get(), png.info());
  const int kind = png_get_color_type(png.get(), png.info());
  const bool is_plain = kind != PNG_COLOR_TYPE_PALETTE &&
                        png_get_bit_depth(png.get(), png.info()) == 8 &&
                        !png_get_valid(png.get(), png.info(), PNG_INFO_tRNS);
  if (!is_plain) return std::nullopt;
  ImageAnswer answer;
  answer.layout = {static_cast<int32_t>(png_get_image_width(png.get(), png.info())),
                   static_cast<int32_t>(png_get_image_height(png.get(), png.info())),
                   png_get_channels(png.get(), png.info()), 8};
  if (!answer.layout.is_legal()) return std::nullopt;
  png_set_interlace_handling(png.get());
  png_read_update_info(png.get(), png.info());
  const std::span<char> pixels = answer.make_room();
  const auto height = static_cast<size_t>(answer.layout.height);
  const size_t row_bytes = pixels.size() / height;
  if (png_get_rowbytes(png.get(), png.info()) != row_bytes) return std::nullopt;
  std::vector<png_bytep> rows;
  for (size_t y = 0; y < height; ++y) {
    rows.push_back(reinterpret_cast<png_bytep>(pixels.data() + y * row_bytes));
  }
  png_read_image(png.get(), rows.data());
  png_read_end(png.get(), nullptr);
  png_charp name = nullptr;
  png_bytep profile = nullptr;
  png_uint_32 size = 0;
  int method = 0;
  const auto channels = static_cast<size_t>(answer.layout.channels);
  if (to_srgb && channels >= 3 &&
      png_get_iCCP(png.get(), png.info(), &name, &method, &profile, &size) != 0) {
    const auto conversion = SrgbConversion::from({profile, size});
    if (conversion) conversion->convert(pixels, channels);
  }
  return answer;
}

}  // namespace

bool is_png(const std::vector<char>& file) {
  constexpr size_t kSignature = 8;
  return file.size() > kSignature &&
         png_sig_cmp(reinterpret_cast<png_const_bytep>(file.data()), 0, kSignature) == 0;
}

std::optional<ImageAnswer> decode_png(const std::vector<char>& file, bool to_srgb) {
  try {
    const Png png(true);
    return decode(png, file, to_srgb);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

std::optional<ImageAnswer> encode_png(const ImageRequest& request,
                                      const std::vector<char>& pixels) {
  const PixelLayout& layout = request.layout;
  const bool fits = std::string_view(request.format) == "png" && layout.is_legal() &&
                    layout.channels == 3 && layout.bits == 8 && layout.bytes() == pixels.size();
  if (!fits) return std::nullopt;
  const Png png(false);
  ImageAnswer answer;
  png_set_write_fn(png.get(), &answer.payload, write_bytes, flush);
  png_set_IHDR(png.get(), png.info(), static_cast<png_uint_32>(layout.width),
               static_cast<png_uint_32>(layout.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  // Runs in what this filter leaves are most of what a search for repeats would find in rendered
  // pictures, and take a fifth of its time (docs/crt.md).
  png_set_filter(png.get(), PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
  png_set_compression_strategy(png.get(), Z_RLE);
  png_set_sRGB_gAMA_and_cHRM(png.get(), png.info(), PNG_sRGB_INTENT_ABSOLUTE);
  if (request.window.x != 0 || request.window.y != 0) {
    png_set_oFFs(png.get(), png.info(), request.window.x, request.window.y, PNG_OFFSET_PIXEL);
  }
  set_texts(png, request.attributes);
  png_write_info(png.get(), png.info());
  const size_t row_bytes = pixels.size() / static_cast<size_t>(layout.height);
  for (size_t at = 0; at < pixels.size(); at += row_bytes) {
    png_write_row(png.get(), reinterpret_cast<png_const_bytep>(pixels.data() + at));
  }
  png_write_end(png.get(), png.info());
  return answer;
}

}  // namespace tessera
