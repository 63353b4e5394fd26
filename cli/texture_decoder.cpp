#include "cli/texture_decoder.h"

#include "base/file.h"
#include "renderer/image/image_file.h"

namespace tessera {

DecodedTexture decode_texture(const std::string& path) {
  check_input_file(path, UINT64_MAX);
  TextureImage picture = read_texture_image(path);
  return {.width = picture.width,
          .height = picture.height,
          .channels = picture.channels,
          .bits = picture.bits,
          .texels = std::move(picture.texels)};
}

}  // namespace tessera
