#include "scenes/import/texture_set.h"

#include <set>

#include "scenes/import/message_walk.h"

namespace tessera {

std::string TextureSet::add(v1::Texture texture) {
  const auto [known, is_new] = names_.try_emplace(texture.SerializeAsString());
  if (!is_new) return known->second;
  known->second = unique_(texture.name());
  texture.set_name(known->second);
  textures_.push_back(std::move(texture));
  return known->second;
}

void add_used_textures(const TextureSet& textures, v1::Scene& scene) {
  std::set<std::string> used;
  for (const v1::Material& material : scene.materials()) {
    walk_message(
        material, [](const google::protobuf::Message&) {},
        [&](const google::protobuf::FieldDescriptor& field, const std::string& text) {
          if (field.name() == "texture" || field.name() == "normal_map") used.insert(text);
        });
  }
  for (const v1::Texture& texture : textures.all())
    if (used.contains(texture.name())) *scene.add_textures() = texture;
}

}  // namespace tessera
