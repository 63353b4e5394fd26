#include "image/animation_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/error.h"
#include "base/lower_case.h"

namespace tessera {
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
constexpr size_t kPngChunkFrame = 12;  ///< length, kind, check sum
constexpr int kMostOfTwoBytes = 65535;

/// Takes what the bytes begin with off them. They are what our own encoders made: bytes that are
/// missing are our own fault.
std::string_view take(std::string_view& bytes, size_t count) {
  if (bytes.size() < count) throw render_error("the encoder wrote a file that ends too soon");
  const std::string_view taken = bytes.substr(0, count);
  bytes.remove_prefix(count);
  return taken;
}

uint32_t big_endian(std::string_view four) {
  uint32_t value = 0;
  for (const char byte : four) value = value << 8 | static_cast<uint8_t>(byte);
  return value;
}

std::string big_endian(uint32_t value, int bytes = 4) {
  std::string text;
  while (bytes-- > 0) text += static_cast<char>(value >> (8 * bytes) & 0xff);
  return text;
}

std::string little_endian(int value) {
  return {static_cast<char>(value & 0xff), static_cast<char>(value >> 8 & 0xff)};
}

/// A chunk of PNG with its length and check sum.
std::string chunk(std::string_view kind, std::string_view data) {
  const std::string summed = std::string(kind).append(data);
  const uLong sum =
      crc32(0, reinterpret_cast<const Bytef*>(summed.data()), static_cast<uInt>(summed.size()));
  return big_endian(static_cast<uint32_t>(data.size())) + summed +
         big_endian(static_cast<uint32_t>(sum));
}

/// The seconds of a frame as a fraction of two numbers of two bytes each.
struct Delay {
  int numerator = 1, denominator = 1;
};

/// Exact for whole rates and those of films, such as 24000/1001.
Delay delay_of(double frames_per_second) {
  constexpr double kNear = 1e-9;
  for (int numerator = 1; numerator <= 1001; ++numerator) {
    const double denominator = numerator * frames_per_second;
    const double whole = std::round(denominator);
    if (whole >= 1 && whole <= kMostOfTwoBytes && std::abs(denominator - whole) < kNear * whole)
      return {numerator, static_cast<int>(whole)};
  }
  constexpr int kThousand = 1000;
  const double thousandths = std::round(kThousand / frames_per_second);
  return {static_cast<int>(std::clamp(thousandths, 1.0, double{kMostOfTwoBytes})), kThousand};
}

/// When a frame of GIF begins, in hundredths of a second.
double gif_time(size_t frame, double frames_per_second) {
  return std::round(100 * static_cast<double>(frame) / frames_per_second);
}

/// Sub-blocks of GIF up to the empty one that ends them.
std::string_view take_sub_blocks(std::string_view& bytes) {
  std::string_view rest = bytes;
  while (const auto length = static_cast<uint8_t>(take(rest, 1)[0])) take(rest, length);
  return take(bytes, bytes.size() - rest.size());
}

/// The size of the colour table that a packed field of GIF tells of.
size_t gif_table_bytes(char packed) {
  const auto field = static_cast<uint8_t>(packed);
  return (field & 0x80) == 0 ? 0 : size_t{3} << ((field & 7) + 1);
}

}  // namespace

bool holds_frames(const std::filesystem::path& path) {
  const std::string ending = lower_case(path.extension().string());
  return ending == ".gif" || ending == ".apng";
}

AnimationFile::AnimationFile(const std::filesystem::path& path)
    : path_(path), is_gif_(lower_case(path.extension().string()) == ".gif") {}

void AnimationFile::add(std::string_view picture) {
  if (is_gif_) return add_gif(picture);
  add_png(picture);
}

std::string AnimationFile::bytes(double frames_per_second) const {
  const double rate = nearest_rate(frames_per_second);
  return is_gif_ ? gif_bytes(rate) : png_bytes(rate);
}

double AnimationFile::nearest_rate(double frames_per_second) const {
  return std::clamp(frames_per_second, kLeastRate, is_gif_ ? kMostRateOfGif : kMostRate);
}

void AnimationFile::check_size(std::string_view size) {
  if (images_.empty()) size_ = size;
  if (size == size_) return;
  throw render_error(
      fmt::format("'{}' cannot be written: frame {} of it has another size than the first one; "
                  "expected one size",
                  path_.string(), images_.size() + 1));
}

void AnimationFile::add_png(std::string_view picture) {
  take(picture, kPngSignature.size());
  std::string image;
  while (!picture.empty()) {
    const uint32_t length = big_endian(picture.substr(0, 4));
    const std::string_view whole = take(picture, length + kPngChunkFrame);
    const std::string_view kind = whole.substr(4, 4), data = whole.substr(8, length);
    if (kind == "IHDR") check_size(data);
    if (kind == "IDAT") {
      image.append(data);
    } else if (images_.empty() && kind != "IHDR") {
      (image.empty() ? head_ : tail_).append(whole);
    }
  }
  images_.push_back(std::move(image));
}

std::string AnimationFile::png_bytes(double frames_per_second) const {
  const std::string area = size_.substr(0, 8) + std::string(8, '\0');  // the offsets are 0
  const auto [numerator, denominator] = delay_of(frames_per_second);
  const std::string delay = big_endian(static_cast<uint32_t>(numerator), 2) +
                            big_endian(static_cast<uint32_t>(denominator), 2);
  const std::string replaces(2, '\0');  // nothing is kept of the frame before, nor blended with it
  std::string file(kPngSignature);
  file += chunk("IHDR", size_);
  file += chunk("acTL", big_endian(static_cast<uint32_t>(images_.size())) + big_endian(0));
  file += head_;
  uint32_t number = 0;  // of the chunk among those of the animation
  for (const std::string& image : images_) {
    const bool is_first = number == 0;
    file += chunk("fcTL", big_endian(number++) + area + delay + replaces);
    file += is_first ? chunk("IDAT", image) : chunk("fdAT", big_endian(number++) + image);
  }
  return file + tail_;
}

void AnimationFile::add_gif(std::string_view picture) {
  constexpr size_t kSignature = 6, kDescriptor = 9;
  take(picture, kSignature);
  const std::string_view screen = take(picture, 7);
  check_size(screen.substr(0, 4));
  const std::string_view shared_table = take(picture, gif_table_bytes(screen[4]));
  while (true) {
    const char kind = take(picture, 1)[0];
    if (kind == '!') {
      take(picture, 1);
      take_sub_blocks(picture);
      continue;
    }
    if (kind != ',') throw render_error("the encoder wrote a GIF without a picture");
    std::string descriptor(take(picture, kDescriptor));
    std::string_view table = take(picture, gif_table_bytes(descriptor.back()));
    if (table.empty()) {
      table = shared_table;
      descriptor.back() = static_cast<char>(descriptor.back() | (screen[4] & 0x87));
    }
    std::string image = "," + descriptor;
    image.append(table).append(take(picture, 1)).append(take_sub_blocks(picture));
    images_.push_back(std::move(image));
    return;
  }
}

std::string AnimationFile::gif_bytes(double frames_per_second) const {
  constexpr int kLeastDelay = 2;  // what is shown for less, programs show for ten
  std::string file = "GIF89a" + size_;
  file += std::string("\x70\0\0", 3);                             // no colours for all frames
  file += std::string("!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0", 19);  // for ever
  for (size_t frame = 0; frame < images_.size(); ++frame) {
    const double delay =
        gif_time(frame + 1, frames_per_second) - gif_time(frame, frames_per_second);
    const auto hundredths =
        static_cast<int>(std::clamp(delay, double{kLeastDelay}, double{kMostOfTwoBytes}));
    // The frame stays until the next one covers it.
    file += std::string("!\xf9\x04\x04", 4) + little_endian(hundredths) + std::string(2, '\0');
    file += images_[frame];
  }
  return file + ";";
}

}  // namespace tessera
