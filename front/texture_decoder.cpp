#include "front/texture_decoder.h"

#include "image/image_file.h"

namespace tessera {
namespace {

DecodedTexture as_texture(TextureImage picture) {
  return {.width = picture.width,
          .height = picture.height,
          .channels = picture.channels,
          .bits = picture.bits,
          .texels = std::move(picture.texels),
          .meaning = picture.meaning,
          .unused_channels = std::move(picture.unused_channels),
          .part_note = std::move(picture.part_note),
          .damage = std::move(picture.damage),
          .gamma = picture.gamma};
}

}  // namespace

DecodedTexture decode_texture(const std::string& path, bool to_srgb) {
  return as_texture(read_texture_image(path, to_srgb));
}

DecodedTexture decode_texture_bytes(std::string_view bytes, const std::string& name) {
  return as_texture(decode_texture_image(name, bytes));
}

}  // namespace tessera
