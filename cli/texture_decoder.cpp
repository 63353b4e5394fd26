#include "cli/texture_decoder.h"

#include <cmath>
#include <cstring>
#include <optional>

#include "base/file.h"
#include "renderer/image/image_file.h"

namespace tessera {
namespace {

/// The values as bytes; nothing where bytes do not hold them. Numbers of 16 bits that bytes cannot
/// hold are at least four times as far off as the rounding of floats.
std::optional<std::vector<std::byte>> as_bytes(const std::vector<float>& values) {
  std::vector<std::byte> bytes(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const float scaled = values[i] * 255;
    if (!(scaled >= 0 && scaled <= 255)) return std::nullopt;
    const int nearest = static_cast<int>(scaled + 0.5f);
    if (std::abs(scaled - static_cast<float>(nearest)) > 1e-3f) return std::nullopt;
    bytes[i] = static_cast<std::byte>(nearest);
  }
  return bytes;
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
  if (auto bytes = as_bytes(values)) {
    texture.bits = 8;
    texture.texels = std::move(*bytes);
  } else {
    texture.texels.resize(values.size() * sizeof(float));
    std::memcpy(texture.texels.data(), values.data(), texture.texels.size());
  }
  return texture;
}

}  // namespace tessera
