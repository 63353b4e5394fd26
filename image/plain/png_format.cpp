#include "image/plain/png_format.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "image/plain/for_all.h"
#include "image/plain/icc_profile.h"
#include "image/plain/plain_formats.h"

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
  std::span<const char> file;
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

using Octets = std::vector<unsigned char>;

/// What of a byte is left by those to its left, above, and left above (PNG 9.4).
unsigned char paeth(int a, int b, int c) {
  const int to_a = std::abs(b - c), to_b = std::abs(a - c), to_c = std::abs(a + b - 2 * c);
  return static_cast<unsigned char>(to_a <= to_b && to_a <= to_c ? a : to_b <= to_c ? b : c);
}

/// Rows of pixels of so many bytes from `begin` on, each after the number of its filter.
template <size_t kPixel>
Octets filtered(std::span<const char> pixels, size_t row_bytes, size_t begin, size_t end) {
  const Octets black(row_bytes);
  Octets out((end - begin) * (row_bytes + 1));
  unsigned char* to = out.data();
  for (size_t y = begin; y < end; ++y, to += row_bytes) {
    const auto* row = reinterpret_cast<const unsigned char*>(pixels.data()) + y * row_bytes;
    const unsigned char* above = y > 0 ? row - row_bytes : black.data();
    *to++ = PNG_FILTER_VALUE_PAETH;
    for (size_t i = 0; i < kPixel; ++i)
      to[i] = static_cast<unsigned char>(row[i] - paeth(0, above[i], 0));
    for (size_t i = kPixel; i < row_bytes; ++i)
      to[i] =
          static_cast<unsigned char>(row[i] - paeth(row[i - kPixel], above[i], above[i - kPixel]));
  }
  return out;
}

/// As a stream of its own that another may follow, or that ends there.
Octets deflated_alone(const Octets& bytes, bool is_last) {
  z_stream stream{};
  constexpr int kRaw = -15, kMemory = 8;
  // Runs in what the filter leaves are most of what a search for repeats would find in rendered
  // pictures, and take a fifth of its time (docs/notes/crt_measured.md).
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kRaw, kMemory, Z_RLE) != Z_OK)
    throw std::bad_alloc();
  const std::unique_ptr<z_stream, decltype(&deflateEnd)> ending(&stream, deflateEnd);
  constexpr size_t kEmptyBlock = 16;
  Octets out(deflateBound(&stream, static_cast<uLong>(bytes.size())) + kEmptyBlock);
  stream.next_in = const_cast<unsigned char*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  const int status = deflate(&stream, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  const bool is_all = is_last ? status == Z_STREAM_END
                              : status == Z_OK && stream.avail_in == 0 && stream.avail_out > 0;
  if (!is_all) throw std::runtime_error("zlib cannot compress it");
  out.resize(stream.total_out);
  return out;
}

/// Of pixels that the layout is of.
auto filter_of(const PixelLayout& layout) {
  const bool is_wide = layout.bits == 16;
  if (layout.channels == 4) return is_wide ? filtered<8> : filtered<4>;
  return is_wide ? filtered<6> : filtered<3>;
}

/// The data of an image (RFC 1950) in parts, which several threads make.
std::vector<Octets> deflated(std::span<const char> pixels, const PixelLayout& layout) {
  constexpr size_t kPartBytes = size_t{64} << 10;
  const auto height = static_cast<size_t>(layout.height);
  const size_t row_bytes = pixels.size() / height;
  const size_t rows = std::max<size_t>(1, kPartBytes / row_bytes);
  const size_t count = (height + rows - 1) / rows;
  std::vector<Octets> parts(count);
  std::vector<uLong> sums(count), sizes(count);
  for_all(count, [&](size_t i) {
    const Octets bytes =
        filter_of(layout)(pixels, row_bytes, i * rows, std::min(height, (i + 1) * rows));
    sizes[i] = static_cast<uLong>(bytes.size());
    sums[i] = adler32(1, bytes.data(), static_cast<uInt>(bytes.size()));
    parts[i] = deflated_alone(bytes, i + 1 == count);
    return true;
  });
  constexpr std::array<unsigned char, 2> kHeader{0x78, 0x9c};
  parts.front().insert(parts.front().begin(), kHeader.begin(), kHeader.end());
  uLong sum = sums[0];
  for (size_t i = 1; i < count; ++i)
    sum = adler32_combine(sum, sums[i], static_cast<z_off_t>(sizes[i]));
  for (const int shift : {24, 16, 8, 0})
    parts.back().push_back(static_cast<unsigned char>(sum >> shift));
  return parts;
}

/// Integers of 16 bits as PNG has them, the high byte first.
std::vector<char> high_bytes_first(std::span<const char> integers) {
  std::vector<char> swapped(integers.size());
  for (size_t i = 0; i < integers.size(); ++i) swapped[i] = integers[i ^ 1];
  return swapped;
}

std::optional<ImageAnswer> decode(const Png& png, std::span<const char> file, bool to_srgb) {
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
  answer.meaning.from_integers = true;
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

std::optional<ImageAnswer> decode_png(std::span<const char> file, bool to_srgb) {
  try {
    const Png png(true);
    return decode(png, file, to_srgb);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

float png_gamma(std::span<const char> file) {
  constexpr size_t kSignature = 8, kAround = 12;  // length, type and checksum of a chunk
  constexpr double kUnit = 1e-5, kOfSrgb = 1 / 2.2, kAlike = .05;
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(file[at + i]);
    return value;
  };
  double gamma = 0;
  for (size_t at = kSignature; at + kAround <= file.size();) {
    const size_t size = number(at);
    if (size > file.size() - at - kAround) break;
    const std::string_view type(&file[at + 4], 4);
    if (type == "IDAT" || type == "PLTE") break;
    if (type == "sRGB" || type == "iCCP") return 0;
    if (type == "gAMA" && size == 4) gamma = number(at + 8) * kUnit;
    at += kAround + size;
  }
  return std::abs(gamma - kOfSrgb) <= kAlike * kOfSrgb ? 0 : static_cast<float>(gamma);
}

std::optional<ImageAnswer> encode_png(const ImageRequest& request, std::span<const char> pixels) {
  const PixelLayout& layout = request.layout;
  const bool fits = std::string_view(request.format) == "png" && layout.is_legal() &&
                    (layout.channels == 3 || layout.channels == 4) && layout.bits <= 16 &&
                    layout.bytes() == pixels.size();
  if (!fits) return std::nullopt;
  const Png png(false);
  ImageAnswer answer;
  png_set_write_fn(png.get(), &answer.payload, write_bytes, flush);
  png_set_IHDR(png.get(), png.info(), static_cast<png_uint_32>(layout.width),
               static_cast<png_uint_32>(layout.height), layout.bits,
               layout.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB_gAMA_and_cHRM(png.get(), png.info(), PNG_sRGB_INTENT_ABSOLUTE);
  if (request.window.x != 0 || request.window.y != 0) {
    png_set_oFFs(png.get(), png.info(), request.window.x, request.window.y, PNG_OFFSET_PIXEL);
  }
  set_texts(png, request.attributes);
  png_write_info(png.get(), png.info());
  // Not by png_write_row(), which has one thread for all of it, nor then by png_write_end().
  std::vector<char> swapped;
  if (layout.bits == 16) pixels = swapped = high_bytes_first(pixels);
  for (const auto& part : deflated(pixels, layout))
    png_write_chunk(png.get(), reinterpret_cast<png_const_bytep>("IDAT"), part.data(), part.size());
  png_write_chunk(png.get(), reinterpret_cast<png_const_bytep>("IEND"), nullptr, 0);
  return answer;
}

}  // namespace tessera
