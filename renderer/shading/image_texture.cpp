#include "renderer/shading/image_texture.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "renderer/math/elementary.h"
#include "renderer/math/encodings.h"

namespace tessera {

namespace {

/// The texel that stands at `i`; below 0 where there is none.
int64_t wrapped(int64_t i, int64_t size, ImageTextureSettings::Wrap wrap) {
  using Wrap = ImageTextureSettings::Wrap;
  if (i >= 0 && i < size) return i;
  switch (wrap) {
    case Wrap::repeat:
      return (i % size + size) % size;
    case Wrap::clamp:
      return std::clamp<int64_t>(i, 0, size - 1);
    case Wrap::mirror: {
      const int64_t in_pair = (i % (2 * size) + 2 * size) % (2 * size);
      return in_pair < size ? in_pair : 2 * size - 1 - in_pair;
    }
    case Wrap::black:
      break;
  }
  return -1;
}

}  // namespace

Texel ImageTexture::mix(const Texel& a, const Texel& b, double weight_of_b) const {
  const double alpha = a.alpha * (1 - weight_of_b) + b.alpha * weight_of_b;
  // What is clear lends no colour to what is not.
  const bool by_alpha = !settings_.is_associated && a.alpha != b.alpha && alpha > 0;
  const double of_color = by_alpha ? b.alpha * weight_of_b / alpha : weight_of_b;
  return {tessera::mix(a.color, b.color, of_color), alpha};
}

uint64_t ImageTextureSettings::bytes() const {
  uint64_t texels = 0;
  uint32_t w = width, h = height;
  for (uint32_t level = 0; level < levels; ++level, w = halved(w), h = halved(h)) {
    texels += uint64_t{w} * h;
  }
  return texels * channels * (bits / 8);
}

ImageTexture::ImageTexture(const ImageTextureSettings& settings,
                           std::shared_ptr<const std::byte> texels)
    : settings_(settings), texels_(std::move(texels)) {
  for (size_t i = 0; i < linear_.size(); ++i) {
    const double value = static_cast<double>(i) / 255;
    linear_[i] = settings.is_srgb ? srgb_to_linear(value) : value;
  }
  const size_t texel_size = size_t{settings.channels} * (settings.bits / 8);
  Level level{settings.width, settings.height, 0};
  for (uint32_t i = 0; i < std::max(settings.levels, 1u); ++i) {
    levels_.push_back(level);
    level.offset += size_t{level.width} * level.height * texel_size;
    level.width = ImageTextureSettings::halved(level.width);
    level.height = ImageTextureSettings::halved(level.height);
  }
}

double ImageTexture::channel(size_t offset) const {
  const std::byte* const at = texels_.get() + offset;
  if (settings_.bits == 16) {
    uint16_t value;
    std::memcpy(&value, at, sizeof value);
    return half_to_float(value);
  }
  float value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

Texel ImageTexture::texel(const Level& level, int64_t x, int64_t y) const {
  x = wrapped(x, level.width, settings_.wrap_s);
  y = wrapped(y, level.height, settings_.wrap_t);
  return texel_at(level, x, y);
}

Texel ImageTexture::texel_at(const Level& level, int64_t x, int64_t y) const {
  if (x < 0 || y < 0) return {kBlack, settings_.has_alpha() ? 0.0 : 1.0};
  const size_t pixel = static_cast<size_t>(y) * level.width + static_cast<size_t>(x);
  const size_t channels = settings_.channels;
  Texel out;
  if (settings_.bits == 8) {
    const std::byte* const at = texels_.get() + level.offset + pixel * channels;
    const auto color = [&](size_t c) { return linear_[static_cast<size_t>(at[c])]; };
    out.color = settings_.has_color() ? Color{color(0), color(1), color(2)} : kWhite * color(0);
    if (settings_.has_alpha()) out.alpha = static_cast<double>(at[channels - 1]) / 255;
    return out;
  }
  const size_t size = settings_.bits / 8;
  const size_t first = level.offset + pixel * channels * size;
  const auto color = [&](size_t c) { return channel(first + c * size); };
  out.color = settings_.has_color() ? Color{color(0), color(1), color(2)} : kWhite * color(0);
  if (settings_.has_alpha()) out.alpha = std::clamp(color(channels - 1), 0.0, 1.0);
  return out;
}

Texel ImageTexture::bilinear(const Level& level, double s, double t) const {
  const bool nearest = settings_.filter == ImageTextureSettings::Filter::nearest;
  const double shift = settings_.texels_at_corners || nearest ? 0 : 0.5;
  const double x = s * level.width - shift;
  const double y = t * level.height - shift;
  const double left = std::floor(x), top = std::floor(y);
  const auto ix = static_cast<int64_t>(left), iy = static_cast<int64_t>(top);
  if (nearest) return texel(level, ix, iy);
  int64_t x0 = ix, x1 = ix + 1, y0 = iy, y1 = iy + 1;
  if (x0 < 0 || x1 >= level.width || y0 < 0 || y1 >= level.height) [[unlikely]] {
    x0 = wrapped(x0, level.width, settings_.wrap_s),
    x1 = wrapped(x1, level.width, settings_.wrap_s);
    y0 = wrapped(y0, level.height, settings_.wrap_t);
    y1 = wrapped(y1, level.height, settings_.wrap_t);
  }
  if (settings_.channels == 3 && settings_.bits == 8 && (x0 | x1 | y0 | y1) >= 0) [[likely]] {
    const std::byte* const texels = texels_.get() + level.offset;
    const auto color = [&](int64_t column, int64_t row) {
      const std::byte* const at = texels + 3 * (row * int64_t{level.width} + column);
      const auto channel_at = [&](int c) { return linear_[static_cast<size_t>(at[c])]; };
      return Color{channel_at(0), channel_at(1), channel_at(2)};
    };
    return {tessera::mix(tessera::mix(color(x0, y0), color(x1, y0), x - left),
                         tessera::mix(color(x0, y1), color(x1, y1), x - left), y - top),
            1};
  }
  return mix(mix(texel_at(level, x0, y0), texel_at(level, x1, y0), x - left),
             mix(texel_at(level, x0, y1), texel_at(level, x1, y1), x - left), y - top);
}

Texel ImageTexture::trilinear(double s, double t, double level) const {
  const double last = static_cast<double>(levels_.size() - 1);
  if (!(level > 0)) return bilinear(levels_.front(), s, t);
  if (level >= last) return bilinear(levels_.back(), s, t);
  const double below = std::floor(level);
  const auto i = static_cast<size_t>(below);
  return mix(bilinear(levels_[i], s, t), bilinear(levels_[i + 1], s, t), level - below);
}

namespace {

/// Beyond this a double has no digits left for a place between texels. Takes in what is no number.
double within_reach(double v) {
  constexpr double kFar = 1e9;
  return v > -kFar ? std::min(v, kFar) : -kFar;
}

double log2_of(double v) {
  constexpr double kLn2 = 0.69314718055994530942;
  return portable::log(v) / kLn2;
}

}  // namespace

Texel ImageTexture::straight(const Texel& mean) const {
  const bool divides = settings_.is_associated && settings_.has_alpha() && mean.alpha > 0;
  return divides ? Texel{mean.color * (1 / mean.alpha), mean.alpha} : mean;
}

Texel ImageTexture::lookup(double s, double t) const {
  return straight(bilinear(levels_.front(), within_reach(s), within_reach(t)));
}

Color ImageTexture::light(double s, double t) const {
  return bilinear(levels_.front(), within_reach(s), within_reach(t)).color;
}

Texel ImageTexture::lookup(double s, double t, const Vec2& a, const Vec2& b) const {
  s = within_reach(s), t = within_reach(t);
  const auto texels_across = [&](const Vec2& v) {
    const double x = v.x * settings_.width, y = v.y * settings_.height;
    return std::sqrt(x * x + y * y);
  };
  const double length_a = texels_across(a), length_b = texels_across(b);
  const double longer = std::max(length_a, length_b);
  const bool filters = settings_.filter == ImageTextureSettings::Filter::trilinear;
  // The comparison fails for a patch that is not finite, too.
  if (!filters || levels_.size() == 1 || !(longer > 1) || !(longer < 1e9)) {
    if (filters && longer >= 1e9) return straight(bilinear(levels_.back(), s, t));
    return straight(bilinear(levels_.front(), s, t));
  }
  constexpr double kMostProbes = 16;
  const double shorter = std::max(std::min(length_a, length_b), longer / kMostProbes);
  const int probes = static_cast<int>(std::ceil(std::min(longer / std::max(shorter, 1.0), 16.0)));
  const double level = log2_of(std::max(longer / probes, 1.0));
  const Vec2& along = length_a >= length_b ? a : b;
  Texel sum{kBlack, 0};
  for (int i = 0; i < probes; ++i) {
    const double at = (i + 0.5) / probes - 0.5;
    const Texel probe =
        trilinear(within_reach(s + along.x * at), within_reach(t + along.y * at), level);
    sum = mix(sum, probe, 1.0 / (i + 1));
  }
  return straight(sum);
}

}  // namespace tessera
