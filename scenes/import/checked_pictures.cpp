#include "scenes/import/checked_pictures.h"

#include <utility>

#include "base/digest.h"
#include "base/error.h"
#include "scenes/import/read_cache.h"

namespace tessera {

ReadOptions CheckedPictures::reading() {
  ReadOptions out = options_;
  if (options_.decode_texture)
    out.decode_texture = [this](const std::string& path, bool to_srgb) {
      return !to_srgb && good_.contains(path) ? take(path) : options_.decode_texture(path, to_srgb);
    };
  if (options_.decode_texture_bytes)
    out.decode_texture_bytes = [this](std::string_view bytes, const std::string& name) {
      return good_.contains(name) ? take(name) : options_.decode_texture_bytes(bytes, name);
    };
  out.check_picture = [this](const std::string& name, const std::string* bytes) {
    return check(name, bytes);
  };
  return out;
}

std::string CheckedPictures::check(const std::string& name, const std::string* bytes) {
  if (bytes ? !options_.decode_texture_bytes : !options_.decode_texture) return "";
  if (!bytes) InputScope::note(name);
  if (good_.contains(name)) return "";
  const auto known = bad_.find(name);
  if (known != bad_.end()) return known->second;
  const auto decode = [&] {
    good_.emplace(name, bytes ? options_.decode_texture_bytes(*bytes, name)
                              : options_.decode_texture(name, false));
    return true;
  };
  try {
    const std::string key =
        "checked picture|" + (bytes ? Digest::of(*bytes).hex() : std::string()) + "|" + name;
    remembered<bool>(
        options_.cache, key,
        [&] {
          if (!bytes) InputScope::note(name);
          return decode();
        },
        [](bool) { return uint64_t{256}; });
    return "";
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_scene) throw;
    std::string reason = error.what();
    if (reason.starts_with(name + ": ")) reason.erase(0, name.size() + 2);
    return bad_.emplace(name, std::move(reason)).first->second;
  }
}

DecodedTexture CheckedPictures::take(const std::string& name) {
  return std::move(good_.extract(name).mapped());
}

}  // namespace tessera
