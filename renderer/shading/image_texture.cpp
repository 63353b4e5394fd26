#include "renderer/shading/image_texture.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

/// IEC 61966-2-1.
double srgb_to_linear(double v) {
  return v <= 0.04045 ? v / 12.92 : portable::pow((v + 0.055) / 1.055, 2.4);
}

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

ImageTexture::ImageTexture(const ImageTextureSettings& settings,
                           std::shared_ptr<const std::vector<std::byte>> texels)
    : settings_(settings), texels_(std::move(texels)) {
  for (size_t i = 0; i < linear_.size(); ++i) {
    const double value = static_cast<double>(i) / 255;
    linear_[i] = settings.is_srgb ? srgb_to_linear(value) : value;
  }
}

Color ImageTexture::texel(int64_t x, int64_t y) const {
  x = wrapped(x, settings_.width, settings_.wrap_s);
  y = wrapped(y, settings_.height, settings_.wrap_t);
  if (x < 0 || y < 0) return kBlack;
  const size_t pixel = static_cast<size_t>(y) * settings_.width + static_cast<size_t>(x);
  const size_t first = pixel * settings_.channels;
  const auto channel = [&](size_t c) -> double {
    if (settings_.bits == 8) return linear_[static_cast<size_t>((*texels_)[first + c])];
    float value;
    std::memcpy(&value, texels_->data() + (first + c) * sizeof value, sizeof value);
    return value;
  };
  if (settings_.channels >= 3) return {channel(0), channel(1), channel(2)};
  return kWhite * channel(0);
}

Color ImageTexture::lookup(double s, double t) const {
  // Beyond this a double has no digits left for a place between texels.
  constexpr double kFar = 1e9;
  const double shift = settings_.texels_at_corners || settings_.is_nearest ? 0 : 0.5;
  const double x = std::clamp(s, -kFar, kFar) * settings_.width - shift;
  const double y = std::clamp(t, -kFar, kFar) * settings_.height - shift;
  const double left = std::floor(x), top = std::floor(y);
  const auto ix = static_cast<int64_t>(left), iy = static_cast<int64_t>(top);
  if (settings_.is_nearest) return texel(ix, iy);
  const double fx = x - left, fy = y - top;
  return (texel(ix, iy) * (1 - fx) + texel(ix + 1, iy) * fx) * (1 - fy) +
         (texel(ix, iy + 1) * (1 - fx) + texel(ix + 1, iy + 1) * fx) * fy;
}

}  // namespace tessera
