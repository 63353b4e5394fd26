#pragma once

#include <map>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "scenes/import/unique_names.h"

namespace tessera {

/// The textures that an importer makes, each different one once and under a name of its own.
class TextureSet {
 public:
  /// The name of the texture like `texture`, which is added where there is none. The name that
  /// comes with it is a wish: one that is taken gets a number.
  std::string add(v1::Texture texture);
  /// In the order of their first use.
  const std::vector<v1::Texture>& all() const { return textures_; }

 private:
  std::vector<v1::Texture> textures_;
  std::map<std::string, std::string> names_;  ///< by the whole message with the wished name
  UniqueNames unique_;
};

/// Adds those textures of the set that a material of the scene names.
void add_used_textures(const TextureSet& textures, v1::Scene& scene);

}  // namespace tessera
