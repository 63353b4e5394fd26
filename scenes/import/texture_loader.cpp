#include "scenes/import/texture_loader.h"

#include <fmt/format.h>

#include <map>
#include <tuple>

#include "base/error.h"
#include "base/file.h"
#include "scenes/import/mip_levels.h"

namespace tessera {
namespace {

/// Levels are for the filter that uses them; a picture without pixels' middles has none.
bool wants_levels(const v1::Texture::Image& image) {
  return image.filter() == v1::Texture::Image::TRILINEAR && !image.texels_at_corners();
}

v1::Texture::Image decode(const std::filesystem::path& file, const v1::Texture::Image& wanted,
                          const TextureDecoder& decoder, BlobStore& blobs) {
  DecodedTexture decoded = decoder(file.string());
  v1::Texture::Image image;
  image.set_width(decoded.width);
  image.set_height(decoded.height);
  image.set_channels(decoded.channels);
  image.set_bits(decoded.bits);
  const bool is_srgb = wanted.encoding() == v1::Texture::Image::ENCODING_SRGB;
  image.set_levels(wants_levels(wanted) ? add_mip_levels(decoded, is_srgb) : 1);
  image.mutable_texels()->set_size(decoded.texels.size());
  image.mutable_texels()->set_digest(blobs.put(std::move(decoded.texels)).hex());
  return image;
}

}  // namespace

void load_textures(LoadedScene& loaded, const std::filesystem::path& folder,
                   const TextureDecoder& decoder) {
  if (!decoder) return;
  std::map<std::tuple<std::filesystem::path, int, bool>, v1::Texture::Image> known;
  for (v1::Texture& texture : *loaded.scene.mutable_textures()) {
    const bool wanted = texture.has_image() && !texture.image().file().empty() &&
                        texture.image().texels().digest().empty();
    if (!wanted) continue;
    v1::Texture::Image& image = *texture.mutable_image();
    const auto file = resolve_inside(folder, image.file());
    if (!file)
      throw scene_error({folder.string()},
                        fmt::format("texture '{}' names the file '{}', which is not inside the "
                                    "scene's folder",
                                    texture.name(), image.file()),
                        "a file in the folder of the scene or below it");
    const auto [at, is_new] =
        known.try_emplace({*file, static_cast<int>(image.encoding()), wants_levels(image)});
    if (is_new) at->second = decode(*file, image, decoder, loaded.blobs);
    image.MergeFrom(at->second);
  }
}

}  // namespace tessera
