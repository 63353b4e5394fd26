#include "scenes/import/texture_loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <tuple>

#include "base/digest.h"
#include "base/error.h"
#include "scenes/import/mip_levels.h"
#include "scenes/import/picture_channel.h"
#include "scenes/import/picture_light.h"
#include "scenes/import/read_cache.h"
#include "scenes/import/warnings.h"

namespace tessera {
namespace {

/// Levels are for the filter that uses them; a picture without pixels' middles has none.
bool wants_levels(const v1::Texture::Image& image) {
  return image.filter() == v1::Texture::Image::TRILINEAR && !image.texels_at_corners();
}

v1::Texture::Image store(DecodedTexture decoded, const v1::Texture::Image& wanted,
                         BlobStore& blobs) {
  v1::Texture::Image image;
  image.set_width(decoded.width);
  image.set_height(decoded.height);
  image.set_channels(decoded.channels);
  image.set_bits(decoded.bits);
  const bool is_srgb = wanted.encoding() == v1::Texture::Image::ENCODING_SRGB;
  image.set_associated_alpha(decoded.meaning.is_associated);
  image.set_levels(wants_levels(wanted) ? add_mip_levels(decoded, is_srgb) : 1);
  image.mutable_texels()->set_size(decoded.texels->size());
  image.mutable_texels()->set_digest(blobs.put(std::move(decoded.texels)).hex());
  return image;
}

struct StoredTexture {
  v1::Texture::Image image;
  BlobStore blobs;
  std::vector<std::string> unused_channels;
  std::vector<PictureNote> notes;
};

/// What is told of the channels of a file that no texture shows.
std::string unused_text(const std::vector<std::string>& channels, const std::string& file) {
  constexpr size_t kMostTold = 8;
  const size_t told = std::min(channels.size(), kMostTold);
  const std::span names(channels.data(), told);
  return fmt::format(
      "{} {}{} of '{}'", channels.size() == 1 ? "channel" : "channels", fmt::join(names, ", "),
      channels.size() > told ? fmt::format(" and {} more", channels.size() - told) : "", file);
}

/// Tells of a file that was taken for another, once.
void add_note(const std::string& note, const std::string& texture, LoadedScene& loaded) {
  const std::string line = fmt::format("texture '{}': {}", texture, note);
  const auto& told = loaded.warnings;
  if (std::find(told.begin(), told.end(), line) != told.end()) return;
  add_warning(loaded, fmt::format("texture '{}'", texture), note);
}

std::filesystem::path file_of(const v1::Texture& texture, const AssetFolder& assets,
                              LoadedScene& loaded) {
  auto [file, note] = assets.find_asset(texture.image().file());
  if (!note.empty()) add_note(note, texture.name(), loaded);
  if (!file)
    throw scene_error(
        {assets.root.string()},
        fmt::format("texture '{}' names the file '{}', which is not inside {}", texture.name(),
                    texture.image().file(), assets.shown_root(texture.image().file())),
        "a file in that folder or below it");
  return *std::move(file);
}

}  // namespace

void load_textures(LoadedScene& loaded, const AssetFolder& assets, const ReadOptions& options) {
  using Kept = std::optional<PictureChannel>;
  std::map<std::tuple<std::filesystem::path, SampleEncoding, bool, bool, Kept>, v1::Texture::Image>
      known;
  std::set<std::pair<std::filesystem::path, std::string>> told;  // warnings of files
  for (v1::Texture& texture : *loaded.scene.mutable_textures()) {
    const bool wanted = texture.has_image() && !texture.image().file().empty() &&
                        texture.image().texels().digest().empty();
    if (!wanted) continue;
    v1::Texture::Image& image = *texture.mutable_image();
    const auto held = loaded.pictures.find(image.file());
    const bool is_held = held != loaded.pictures.end();
    if (is_held ? !options.decode_texture_bytes : !options.decode_texture) continue;
    const auto file =
        is_held ? std::filesystem::path(image.file()) : file_of(texture, assets, loaded);
    const bool to_srgb = loaded.profiled_pictures.contains(image.file());
    const auto channel = loaded.picture_channels.find(texture.name());
    const Kept kept =
        channel == loaded.picture_channels.end() ? std::nullopt : Kept(channel->second);
    const auto [at, is_new] =
        known.try_emplace({file, sample_encoding(image), wants_levels(image), to_srgb, kept});
    if (is_new) {
      const auto decode = [&] {
        if (!is_held) InputScope::note(file);
        DecodedTexture decoded = is_held ? options.decode_texture_bytes(held->second, held->first)
                                         : options.decode_texture(file.string(), to_srgb);
        const bool is_srgb = image.encoding() == v1::Texture::Image::ENCODING_SRGB;
        StoredTexture stored;
        stored.unused_channels = decoded.unused_channels;
        stored.notes = prepare_picture(decoded, sample_encoding(image));
        if (kept) keep_channel(decoded, *kept, is_srgb);
        stored.image = store(std::move(decoded), image, stored.blobs);
        return stored;
      };
      const std::string key =
          fmt::format("texture|{}|{}|{}|{}|{}|{}", is_held ? Digest::of(held->second).hex() : "",
                      static_cast<int>(sample_encoding(image)), wants_levels(image), to_srgb,
                      kept ? static_cast<int>(*kept) : -1, file.string());
      const auto stored = remembered<StoredTexture>(
          options.cache, key, decode,
          [](const StoredTexture& made) { return made.image.texels().size(); });
      for (const auto& [digest, blob] : stored->blobs.all()) loaded.blobs.put(digest, blob);
      at->second = stored->image;
      for (const auto& [what, is_repair] : stored->notes) {
        if (!told.emplace(file, what).second) continue;
        add_warning(loaded, file.string(), what);
        if (is_repair) loaded.repairs.push_back(loaded.warning_diagnostics.back());
      }
      if (!stored->unused_channels.empty() && told.emplace(file, "").second)
        loaded.unused.push_back(unused_text(stored->unused_channels, image.file()));
    }
    image.MergeFrom(at->second);
  }
  loaded.pictures.clear();
  loaded.picture_channels.clear();
}

}  // namespace tessera
