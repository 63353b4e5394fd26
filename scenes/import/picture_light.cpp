#include "scenes/import/picture_light.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "base/core_count.h"
#include "base/parallel.h"
#include "base/plural.h"
#include "renderer/math/encodings.h"

namespace tessera {
namespace {

constexpr float kLargestHalf = 65504;

float mended(float number) { return number > 0 ? kLargestHalf : 0; }

/// Calls `odd(i, value)` for each number that is not finite, which takes the place of the number.
template <typename Odd>
void for_odd_numbers(const DecodedTexture& picture, const Odd& odd) {
  const std::byte* const from = picture.texels->data();
  const size_t count = picture.texels->size() / (picture.bits / 8);
  if (picture.bits == 16) {
    for (size_t i = 0; i < count; ++i) {
      uint16_t half = 0;
      std::memcpy(&half, from + i * sizeof half, sizeof half);
      if (is_finite_half(half)) continue;
      odd(i, half_to_float(half));
    }
  } else if (picture.bits == 32) {
    for (size_t i = 0; i < count; ++i) {
      float number = 0;
      std::memcpy(&number, from + i * sizeof number, sizeof number);
      if (!std::isfinite(number)) odd(i, number);
    }
  }
}

}  // namespace

SampleEncoding sample_encoding(const v1::Texture::Image& image) {
  if (!image.has_encoding()) return SampleEncoding::automatic;
  return image.encoding() == v1::Texture::Image::ENCODING_SRGB ? SampleEncoding::srgb
                                                               : SampleEncoding::linear;
}

void set_integer_encoding(v1::Texture::Image::Encoding encoding, v1::Texture::Image& image) {
  if (encoding != v1::Texture::Image::ENCODING_SRGB) image.set_encoding(encoding);
}

void decode_picture(DecodedTexture& picture, SampleEncoding encoding) {
  SampleMeaning meaning = picture.meaning;
  meaning.from_integers |= picture.bits == 8;
  const bool stays = picture.bits == 8 ? !meaning.is_associated : !holds_codes(meaning, encoding);
  if (stays) return;
  std::vector<std::byte> bytes(picture.texels->size() / (picture.bits / 8) * sizeof(float));
  const std::span floats(reinterpret_cast<float*>(bytes.data()), bytes.size() / sizeof(float));
  samples_to_floats(*picture.texels, picture.bits, floats);
  constexpr size_t kPixelsAtOnce = size_t{1} << 16;
  const size_t channels = picture.channels;
  for_each_piece_parallel(
      floats.size() / channels, kPixelsAtOnce, core_count(), [&](size_t begin, size_t end) {
        decode_samples(floats.subspan(begin * channels, (end - begin) * channels), picture.channels,
                       meaning, encoding);
      });
  picture.texels = make_blob(std::move(bytes));
  picture.bits = 32;
  picture.meaning.from_integers = false;
}

std::string mend_numbers(DecodedTexture& picture) {
  std::vector<std::byte> bytes;
  size_t count = 0, first = 0;
  float first_value = 0;
  for_odd_numbers(picture, [&](size_t i, float value) {
    if (count++ == 0) {
      first = i;
      first_value = value;
      bytes.assign(picture.texels->begin(), picture.texels->end());
    }
    const float good = mended(value);
    if (picture.bits == 16) {
      const uint16_t half = float_to_half(good);
      std::memcpy(&bytes[i * sizeof half], &half, sizeof half);
    } else {
      std::memcpy(&bytes[i * sizeof good], &good, sizeof good);
    }
  });
  if (count == 0) return "";
  picture.texels = make_blob(std::move(bytes));
  const size_t pixel = first / picture.channels;
  return fmt::format("pixel {},{} has the number {} and is read as {}{}; expected finite numbers",
                     pixel % picture.width, pixel / picture.width, first_value, mended(first_value),
                     count == 1 ? "" : fmt::format(", like {}", counted(count - 1, "more number")));
}

std::vector<PictureNote> prepare_picture(DecodedTexture& picture, SampleEncoding encoding) {
  std::vector<PictureNote> notes;
  if (!picture.part_note.empty()) notes.push_back({picture.part_note});
  if (!picture.damage.empty())
    notes.push_back(
        {fmt::format("it is damaged, and read as far as it goes: {}", picture.damage), true});
  if (picture.gamma > 0 && encoding != SampleEncoding::linear)
    notes.push_back({fmt::format(
        "its codes have gamma {:.5g} (gAMA) by what the file says; they are read as those of sRGB",
        picture.gamma)});
  decode_picture(picture, encoding);
  // After, as the curve makes numbers of floats infinite that are large.
  if (std::string mended = mend_numbers(picture); !mended.empty())
    notes.push_back({std::move(mended), true});
  return notes;
}

}  // namespace tessera
