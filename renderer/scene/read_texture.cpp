#include "renderer/scene/read_texture.h"

#include <fmt/format.h>

#include <vector>

#include "base/digest.h"
#include "base/error.h"

namespace tessera {

namespace {

constexpr uint32_t kMaxSide = 65536;

const v1::Texture& find_texture(const Where& where, const v1::Scene& scene,
                                const std::string& name) {
  std::vector<std::string> known;
  for (const v1::Texture& texture : scene.textures()) {
    if (texture.name() == name) return texture;
    known.push_back(texture.name());
  }
  fail_value(where, "texture", fmt::format("'{}'", name),
             "a texture of the scene" + suggestion(name, known));
}

void check_size(const Where& where, std::string_view field, uint32_t value) {
  if (value < 1 || value > kMaxSide) {
    fail_value(where, field, std::to_string(value), fmt::format("1 to {}", kMaxSide));
  }
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

BlobData find_texels(const Where& where, const v1::Texture::Image& in, const BlobStore& blobs) {
  const auto digest = Digest::parse(in.texels().digest());
  const BlobData texels = digest ? blobs.find(*digest) : nullptr;
  if (!texels) {
    fail_value(where, "image.texels", in.file().empty() ? "missing" : "not read from its file",
               "a blob of the scene");
  }
  const uint64_t needed = uint64_t{in.width()} * in.height() * in.channels() * (in.bits() / 8);
  if (texels->size() < needed) {
    fail_value(where, "image.texels", fmt::format("{} bytes", texels->size()),
               fmt::format("at least {}", needed));
  }
  return texels;
}

}  // namespace

std::shared_ptr<const ImageTexture> read_image_texture(const Where& parent, const v1::Scene& scene,
                                                       const BlobStore& blobs,
                                                       const std::string& name) {
  const v1::Texture& texture = find_texture(parent, scene, name);
  const Where where{.parent = &parent, .kind = "texture", .name = name};
  if (!texture.has_image()) fail_unsupported(where, "a texture without an image, here");
  const v1::Texture::Image& in = texture.image();
  if (in.bits() == 16) fail_unsupported(where, "an image of 16 bits");
  check_size(where, "image.width", in.width());
  check_size(where, "image.height", in.height());
  if (in.channels() < 1 || in.channels() > 4) {
    fail_value(where, "image.channels", std::to_string(in.channels()), "1 to 4");
  }
  if (in.bits() != 8 && in.bits() != 32) {
    fail_value(where, "image.bits", std::to_string(in.bits()), "8, 16 or 32");
  }
  ImageTextureSettings settings{.width = in.width(),
                                .height = in.height(),
                                .channels = in.channels(),
                                .bits = in.bits(),
                                .wrap_s = read_wrap(in.wrap_s()),
                                .wrap_t = read_wrap(in.wrap_t()),
                                .is_srgb = in.encoding() == v1::Texture::Image::ENCODING_SRGB,
                                .is_nearest = in.filter() == v1::Texture::Image::NEAREST,
                                .texels_at_corners = in.texels_at_corners()};
  return std::make_shared<ImageTexture>(settings, find_texels(where, in, blobs));
}

}  // namespace tessera
