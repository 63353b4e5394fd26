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

  /// Whether there is alpha that is not in the colours, whose means it has to weight.
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

/// The texels of a row or column that one of the next level is the mean of, each by its share: up
/// to three where their number is odd, so that all count alike (Guthe and Heckbert 2005,
/// "Non-power-of-two mipmap creation").
struct Taps {
  size_t first = 0, count = 0;
  std::array<float, 3> share{};
};

Taps taps_of(size_t texel, size_t texels, size_t of_next) {
  Taps taps{.first = texel * texels / of_next};
  const size_t end = (texel + 1) * texels;  // in parts of a texel, as many as the next level has
  for (size_t at = texel * texels; at < end; ++taps.count) {
    const size_t next = std::min((taps.first + taps.count + 1) * of_next, end);
    taps.share[taps.count] = static_cast<float>(next - at) / static_cast<float>(texels);
    at = next;
  }
  return taps;
}

/// The mean of texels that are `columns` of `rows` whose first one begins at `from`.
void average(const Texels& texels, const std::byte* from, size_t row_bytes, size_t texel_bytes,
             const Taps& columns, const Taps& rows, std::byte* to) {
  const size_t count = columns.count * rows.count;
  std::array<const std::byte*, 9> at;
  std::array<float, 9> weight;
  for (size_t i = 0; i < count; ++i) {
    const size_t x = i % columns.count, y = i / columns.count;
    at[i] = from + (rows.first + y) * row_bytes + (columns.first + x) * texel_bytes;
    weight[i] = columns.share[x] * rows.share[y];
  }
  const uint32_t alpha_channel = texels.colors();
  if (texels.has_alpha()) {
    float sum = 0;
    std::array<float, 9> seen;
    for (size_t i = 0; i < count; ++i)
      sum += seen[i] = weight[i] * texels.get(at[i], alpha_channel);
    texels.put(sum, to, alpha_channel);
    for (size_t i = 0; i < count && sum > 0; ++i) weight[i] = seen[i] / sum;
  }
  for (uint32_t channel = 0; channel < texels.colors(); ++channel) {
    float mean = 0;
    for (size_t i = 0; i < count; ++i) mean += weight[i] * texels.get(at[i], channel);
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
      const Taps rows = taps_of(y, height, next_height);
      for (size_t x = 0; x < next_width; ++x) {
        average(texels, data + offset, width * size, size, taps_of(x, width, next_width), rows,
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
