#include "renderer/scene/read_texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "base/digest.h"
#include "base/error.h"
#include "renderer/math/encodings.h"
#include "renderer/scene/read_transform.h"

namespace tessera {

namespace {

constexpr uint32_t kMaxSide = 65536;

uint32_t whole(const Where& where, std::string_view field, uint32_t value, uint32_t min,
               uint32_t max) {
  if (value < min || value > max) {
    fail_value(where, field, std::to_string(value), fmt::format("{} to {}", min, max));
  }
  return value;
}

ImageTextureSettings::Wrap read_wrap(v1::Texture::Image::Wrap wrap) {
  switch (wrap) {
    case v1::Texture::Image::CLAMP:
      return ImageTextureSettings::Wrap::clamp;
    case v1::Texture::Image::MIRROR:
      return ImageTextureSettings::Wrap::mirror;
    case v1::Texture::Image::BLACK:
      return ImageTextureSettings::Wrap::black;
    default:
      return ImageTextureSettings::Wrap::repeat;
  }
}

ImageTextureSettings::Filter read_filter(v1::Texture::Image::Filter filter) {
  switch (filter) {
    case v1::Texture::Image::NEAREST:
      return ImageTextureSettings::Filter::nearest;
    case v1::Texture::Image::BILINEAR:
      return ImageTextureSettings::Filter::bilinear;
    default:
      return ImageTextureSettings::Filter::trilinear;
  }
}

ImageTextureSettings read_layout(const Where& where, const v1::Texture::Image& in) {
  ImageTextureSettings out;
  out.width = whole(where, "image.width", in.width(), 1, kMaxSide);
  out.height = whole(where, "image.height", in.height(), 1, kMaxSide);
  out.channels = whole(where, "image.channels", in.channels(), 1, 4);
  out.bits = in.bits();
  if (out.bits != 8 && out.bits != 16 && out.bits != 32) {
    fail_value(where, "image.bits", std::to_string(in.bits()), "8, 16 or 32");
  }
  uint32_t most = 1;
  for (uint32_t side = std::max(out.width, out.height); side > 1; ++most) {
    side = ImageTextureSettings::halved(side);
  }
  out.levels = whole(where, "image.levels", std::max(in.levels(), 1u), 1, most);
  return out;
}

/// The index of the first number of `bits` bits that is not finite.
std::optional<size_t> first_not_finite(std::span<const std::byte> texels, uint32_t bits) {
  for (size_t i = 0; bits == 16 && i < texels.size() / 2; ++i) {
    uint16_t half;
    std::memcpy(&half, &texels[2 * i], sizeof half);
    if (!is_finite_half(half)) return i;
  }
  for (size_t i = 0; bits == 32 && i < texels.size() / 4; ++i) {
    float value;
    std::memcpy(&value, &texels[4 * i], sizeof value);
    if (!std::isfinite(value)) return i;
  }
  return std::nullopt;
}

/// The pixel of the number with that index, the level that it is in, and the file if one is known.
std::string texel_place(const v1::Texture::Image& in, const ImageTextureSettings& layout,
                        size_t number) {
  uint64_t pixel = number / layout.channels, level = 0;
  uint32_t width = layout.width, height = layout.height;
  for (; pixel >= uint64_t{width} * height; ++level) {
    pixel -= uint64_t{width} * height;
    width = ImageTextureSettings::halved(width);
    height = ImageTextureSettings::halved(height);
  }
  return fmt::format("pixel {},{}{}{}", pixel % width, pixel / width,
                     level > 0 ? fmt::format(" of level {}", level) : "",
                     in.file().empty() ? "" : fmt::format(" of '{}'", in.file()));
}

BlobData find_texels(const Where& where, const v1::Texture::Image& in,
                     const ImageTextureSettings& layout, const BlobStore& blobs) {
  const auto digest = Digest::parse(in.texels().digest());
  const BlobData texels = digest ? blobs.find(*digest) : nullptr;
  if (!texels) {
    fail_value(where, "image.texels",
               in.file().empty() ? "missing" : fmt::format("not read from '{}'", in.file()),
               "a blob of the scene");
  }
  if (texels->size() != layout.bytes()) {
    fail_value(where, "image.texels", fmt::format("{} bytes", texels->size()),
               fmt::format("{}, for its size, channels, bits and levels", layout.bytes()));
  }
  if (const auto number = first_not_finite(*texels, layout.bits)) {
    fail_value(where, "image.texels",
               fmt::format("infinite or no number at {}", texel_place(in, layout, *number)),
               "finite numbers");
  }
  return texels;
}

void read_noise(const Where& where, const v1::Texture::Noise& in, Texture& out) {
  constexpr uint32_t kMostOctaves = 16;
  constexpr double kLargest = 1e9;
  out.kind = TextureKind::noise;
  switch (in.kind()) {
    case v1::Texture::Noise::TURBULENCE:
      out.noise = NoiseKind::turbulence;
      break;
    case v1::Texture::Noise::MARBLE:
      out.noise = NoiseKind::marble;
      break;
    case v1::Texture::Noise::WOOD:
      out.noise = NoiseKind::wood;
      break;
    default:
      out.noise = NoiseKind::perlin;
      break;
  }
  if (in.has_low()) out.low = checked(where, "noise.low", in.low());
  if (in.has_high()) out.high = checked(where, "noise.high", in.high());
  if (in.has_frequency()) {
    out.frequency = checked(where, "noise.frequency", in.frequency(),
                            {.min = 0, .max = kLargest, .above_min = true});
  }
  if (in.has_octaves()) out.octaves = whole(where, "noise.octaves", in.octaves(), 1, kMostOctaves);
  if (in.has_strength()) {
    out.strength = checked(where, "noise.strength", in.strength(), {.min = 0, .max = kLargest});
  }
}

void read_gradient(const Where& where, const v1::Texture::GradientRamp& in, Texture& out) {
  out.kind = TextureKind::gradient;
  if (in.positions().empty() || in.positions_size() != in.colors_size()) {
    fail_value(
        where, "the number of gradient.positions", std::to_string(in.positions_size()),
        fmt::format("one for each of the {} gradient.colors, and at least one", in.colors_size()));
  }
  for (int i = 0; i < in.positions_size(); ++i) {
    const bool first = i == 0;
    out.positions.push_back(
        checked(where, "gradient.positions", in.positions(i),
                {.min = first ? 0 : in.positions(i - 1), .max = 1, .above_min = !first}));
    out.colors.push_back(checked(where, "gradient.colors", in.colors(i)));
  }
}

}  // namespace

std::shared_ptr<const ImageTexture> read_image_texture(const Where& where,
                                                       const v1::Texture::Image& in,
                                                       const BlobStore& blobs) {
  ImageTextureSettings settings = read_layout(where, in);
  settings.wrap_s = read_wrap(in.wrap_s());
  settings.wrap_t = read_wrap(in.wrap_t());
  settings.filter = read_filter(in.filter());
  settings.is_srgb = in.encoding() == v1::Texture::Image::ENCODING_SRGB;
  settings.texels_at_corners = in.texels_at_corners();
  settings.is_associated = in.associated_alpha();
  if (settings.is_associated && settings.bits == 8) {
    fail_value(where, "image.associated_alpha", "true for texels of 8 bits", "16 or 32 bits");
  }
  const BlobData texels = find_texels(where, in, settings, blobs);
  return std::make_shared<ImageTexture>(settings,
                                        std::shared_ptr<const std::byte>(texels, texels->data()));
}

void read_mapping(const Where& where, const v1::Texture& in, Texture& out) {
  out.transform = read_transform(where, in.transform());
  switch (in.mapping()) {
    case v1::Texture::SECOND_UV:
      out.mapping = TextureMapping::second_uv;
      break;
    case v1::Texture::OBJECT:
      out.mapping = TextureMapping::object;
      break;
    case v1::Texture::WORLD:
      out.mapping = TextureMapping::world;
      break;
    case v1::Texture::OBJECT_NORMAL:
      out.mapping = TextureMapping::object_normal;
      break;
    case v1::Texture::VIEW_NORMAL:
      out.mapping = TextureMapping::view_normal;
      break;
    default:
      out.mapping = TextureMapping::uv;
      break;
  }
}

void read_pattern(const Where& where, const v1::Texture& in, Texture& out) {
  switch (in.kind_case()) {
    case v1::Texture::kNoise:
      return read_noise(where, in.noise(), out);
    case v1::Texture::kGradient:
      return read_gradient(where, in.gradient(), out);
    default:
      fail_value(where, "its kind", "missing", "image, checker, noise or gradient");
  }
}

}  // namespace tessera
