#include "cli/texture_decoder.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/file.h"
#include "renderer/image/image_file.h"

namespace tessera {
namespace {

/// Numbers of 16 bits that 8 bits cannot hold are four times as far off.
bool is_8_bit(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) {
    return v >= 0 && v <= 1 && std::abs(v * 255 - std::round(v * 255)) < 1e-3f;
  });
}

}  // namespace

DecodedTexture decode_texture(const std::string& path) {
  check_input_file(path, UINT64_MAX);
  const RgbImage picture = read_image(path);
  DecodedTexture texture{.width = static_cast<uint32_t>(picture.width),
                         .height = static_cast<uint32_t>(picture.height),
                         .channels = 3,
                         .bits = 32,
                         .texels = {}};
  const std::vector<float>& values = picture.values;
  if (is_8_bit(values)) {
    texture.bits = 8;
    texture.texels.resize(values.size());
    for (size_t i = 0; i < values.size(); ++i)
      texture.texels[i] = static_cast<std::byte>(std::lround(values[i] * 255));
  } else {
    texture.texels.resize(values.size() * sizeof(float));
    std::memcpy(texture.texels.data(), values.data(), texture.texels.size());
  }
  return texture;
}

}  // namespace tessera
