#include "scenes/import/picture_light.h"

#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "renderer/math/encodings.h"

namespace tessera {
namespace {

void copy_as_floats(const DecodedTexture& picture, std::span<float> floats) {
  const std::byte* const from = picture.texels->data();
  for (size_t i = 0; i < floats.size(); ++i) {
    if (picture.bits == 8) {
      floats[i] = static_cast<float>(from[i]) / 255;
    } else if (picture.bits == 16) {
      uint16_t half = 0;
      std::memcpy(&half, from + i * sizeof half, sizeof half);
      floats[i] = half_to_float(half);
    } else {
      std::memcpy(&floats[i], from + i * sizeof(float), sizeof(float));
    }
  }
}

}  // namespace

SampleEncoding sample_encoding(const v1::Texture::Image& image) {
  if (!image.has_encoding()) return SampleEncoding::automatic;
  return image.encoding() == v1::Texture::Image::ENCODING_SRGB ? SampleEncoding::srgb
                                                               : SampleEncoding::linear;
}

void set_integer_encoding(v1::Texture::Image::Encoding encoding, v1::Texture::Image& image) {
  if (encoding != v1::Texture::Image::ENCODING_SRGB) image.set_encoding(encoding);
}

void decode_picture(DecodedTexture& picture, SampleEncoding encoding) {
  SampleMeaning meaning = picture.meaning;
  meaning.from_integers |= picture.bits == 8;
  const bool stays = picture.bits == 8 ? !meaning.is_associated : !holds_codes(meaning, encoding);
  if (stays) return;
  std::vector<std::byte> bytes(picture.texels->size() / (picture.bits / 8) * sizeof(float));
  const std::span floats(reinterpret_cast<float*>(bytes.data()), bytes.size() / sizeof(float));
  copy_as_floats(picture, floats);
  decode_samples(floats, picture.channels, meaning, encoding);
  picture.texels = make_blob(std::move(bytes));
  picture.bits = 32;
  picture.meaning.from_integers = false;
}

}  // namespace tessera
