#include "scenes/import/mip_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/parallel.h"
#include "base/process.h"
#include "renderer/math/encodings.h"

namespace tessera {
namespace {

/// A picture's numbers as linear light.
class Texels {
 public:
  Texels(const DecodedTexture& texture, bool is_srgb)
      : channels_(texture.channels),
        bits_(texture.bits),
        is_associated_(texture.meaning.is_associated),
        colors_(channels_ - (has_alpha() ? 1 : 0)),
        is_srgb_(is_srgb) {
    for (size_t i = 0; i < 256; ++i) {
      const double v = static_cast<double>(i) / 255;
      linear_[i] = static_cast<float>(srgb_to_linear(v));
      // The light from which on the code i, and none below it, is nearest.
      from_[i] =
          static_cast<float>(i == 0 ? 0 : srgb_to_linear((static_cast<double>(i) - 0.5) / 255));
    }
    size_t code = 0;
    for (size_t step = 0; step < kSteps; ++step) {
      code = code_from(code, static_cast<float>(step) / kSteps);
      code_at_[step] = static_cast<uint8_t>(code);
    }
  }

  /// Whether there is one that colours are not multiplied by, so that means have to be.
  bool has_alpha() const { return channels_ % 2 == 0 && !is_associated_; }
  uint32_t colors() const { return colors_; }

  float get(const std::byte* texel, uint32_t channel) const {
    if (bits_ == 8) {
      const auto code = static_cast<size_t>(texel[channel]);
      return is_srgb_ && channel < colors_ ? linear_[code] : static_cast<float>(code) / 255;
    }
    if (bits_ == 16) return half_to_float(at<uint16_t>(texel, channel));
    return at<float>(texel, channel);
  }

  void put(float value, std::byte* texel, uint32_t channel) const {
    if (bits_ == 8) {
      texel[channel] = static_cast<std::byte>(code_of(value, channel));
    } else if (bits_ == 16) {
      const uint16_t half = float_to_half(value);
      std::memcpy(texel + channel * sizeof half, &half, sizeof half);
    } else {
      std::memcpy(texel + channel * sizeof value, &value, sizeof value);
    }
  }

 private:
  template <typename Number>
  static Number at(const std::byte* texel, uint32_t channel) {
    Number number;
    std::memcpy(&number, texel + channel * sizeof number, sizeof number);
    return number;
  }

  int code_of(float value, uint32_t channel) const {
    if (!is_srgb_ || channel >= colors_) return static_cast<int>(std::lround(value * 255));
    const auto step = static_cast<size_t>(value * kSteps);
    return static_cast<int>(code_from(code_at_[std::min(step, kSteps - 1)], value));
  }
  /// The nearest code, which is not below `code`.
  size_t code_from(size_t code, float value) const {
    while (code < 255 && from_[code + 1] <= value) ++code;
    return code;
  }

  static constexpr size_t kSteps = 4096;  ///< each spans less than two codes

  uint32_t channels_, bits_;
  bool is_associated_;
  uint32_t colors_;
  bool is_srgb_;
  std::array<float, 256> linear_{}, from_{};
  std::array<uint8_t, kSteps> code_at_{};  ///< of the least light of each step
};

/// The mean of four texels.
void average(const Texels& texels, const std::array<const std::byte*, 4>& from, std::byte* to) {
  const uint32_t alpha_channel = texels.colors();
  std::array<float, 4> weight{0.25f, 0.25f, 0.25f, 0.25f};
  if (texels.has_alpha()) {
    float sum = 0;
    for (size_t i = 0; i < 4; ++i) sum += weight[i] = texels.get(from[i], alpha_channel);
    texels.put(sum / 4, to, alpha_channel);
    for (float& w : weight) w = sum > 0 ? w / sum : 0.25f;
  }
  for (uint32_t channel = 0; channel < texels.colors(); ++channel) {
    float mean = 0;
    for (size_t i = 0; i < 4; ++i) mean += weight[i] * texels.get(from[i], channel);
    texels.put(mean, to, channel);
  }
}

}  // namespace

uint32_t add_mip_levels(DecodedTexture& texture, bool is_srgb) {
  const Texels texels(texture, is_srgb);
  const size_t size = size_t{texture.channels} * (texture.bits / 8);
  size_t width = texture.width, height = texture.height, offset = 0;
  uint32_t levels = 1;
  std::vector<std::byte> bytes;
  bytes.reserve(texture.texels->size() / 2 * 3);
  bytes.assign(texture.texels->begin(), texture.texels->end());
  for (; width > 1 || height > 1; ++levels) {
    const size_t next_width = width - width / 2, next_height = height - height / 2;
    const size_t next = offset + width * height * size;
    bytes.resize(next + next_width * next_height * size);
    std::byte* const data = bytes.data();
    const auto average_row = [&](size_t y) {
      const size_t y0 = 2 * y, y1 = std::min(y0 + 1, height - 1);
      for (size_t x = 0; x < next_width; ++x) {
        const size_t x0 = 2 * x, x1 = std::min(x0 + 1, width - 1);
        const auto texel = [&](size_t column, size_t row) {
          return data + offset + (row * width + column) * size;
        };
        average(texels, {texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1)},
                data + next + (y * next_width + x) * size);
      }
    };
    constexpr size_t kRows = 16;
    for_each_piece_parallel(next_height, kRows, core_count(), [&](size_t from, size_t to) {
      for (size_t y = from; y < to; ++y) average_row(y);
    });
    offset = next, width = next_width, height = next_height;
  }
  texture.texels = make_blob(std::move(bytes));
  return levels;
}

}  // namespace tessera
