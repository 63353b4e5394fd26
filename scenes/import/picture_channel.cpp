#include "scenes/import/picture_channel.h"

#include <array>
#include <cmath>
#include <cstring>

#include "renderer/math/encodings.h"

namespace tessera {
namespace {

constexpr std::array<double, 3> kLuminance{.2126, .7152, .0722};

double number_at(const std::byte* texel, uint32_t channel, uint32_t bits) {
  if (bits == 8) return static_cast<double>(texel[channel]);
  if (bits == 16) {
    uint16_t half = 0;
    std::memcpy(&half, texel + channel * sizeof half, sizeof half);
    return half_to_float(half);
  }
  float number = 0;
  std::memcpy(&number, texel + channel * sizeof number, sizeof number);
  return number;
}

void put_number(double value, uint32_t bits, std::byte* to) {
  if (bits == 8) {
    *to = static_cast<std::byte>(std::lround(value));
  } else if (bits == 16) {
    const uint16_t half = float_to_half(static_cast<float>(value));
    std::memcpy(to, &half, sizeof half);
  } else {
    const auto number = static_cast<float>(value);
    std::memcpy(to, &number, sizeof number);
  }
}

}  // namespace

void keep_channel(DecodedTexture& texture, PictureChannel channel, bool is_srgb) {
  const uint32_t channels = texture.channels, bits = texture.bits;
  const bool has_alpha = channels % 2 == 0;
  const bool is_alpha = channel == PictureChannel::alpha_or_luminance && has_alpha;
  if (channels == 1) return;
  // A texture of one channel is decoded by its encoding if it has 8 bits: alpha, which never is,
  // and luminance, which is of light, leave as halves.
  const bool to_halves = is_srgb && bits == 8 && (is_alpha || channels > 2);
  const uint32_t to_bits = to_halves ? 16 : bits;
  const size_t from_size = size_t{channels} * (bits / 8), to_size = to_bits / 8;
  std::vector<std::byte> out(texture.texels->size() / from_size * to_size);
  const std::byte* from = texture.texels->data();
  for (size_t at = 0; at < out.size(); at += to_size, from += from_size) {
    double value = 0;
    if (is_alpha || channels == 2) {
      value = number_at(from, is_alpha ? channels - 1 : 0, bits) / (to_halves ? 255 : 1);
    } else {
      for (uint32_t c = 0; c < 3; ++c) {
        const double number = number_at(from, c, bits);
        value += kLuminance[c] * (to_halves ? srgb_to_linear(number / 255) : number);
      }
    }
    if (!is_alpha && has_alpha && texture.meaning.is_associated) {
      const double alpha = number_at(from, channels - 1, bits);
      if (alpha > 0) value /= alpha;
    }
    put_number(value, to_bits, &out[at]);
  }
  texture.channels = 1;
  texture.meaning.is_associated = false;
  texture.bits = to_bits;
  texture.texels = make_blob(std::move(out));
}

}  // namespace tessera
