#include "scenes/import/texture_set.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <set>

namespace tessera {
namespace {

namespace pb = google::protobuf;

void collect_textures(const pb::Message& message, std::set<std::string>& names) {
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    if (field->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE)
      collect_textures(reflection.GetMessage(message, field), names);
    else if (field->name() == "texture" || field->name() == "normal_map")
      names.insert(reflection.GetString(message, field));
  }
}

}  // namespace

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
  for (const v1::Material& material : scene.materials()) collect_textures(material, used);
  for (const v1::Texture& texture : textures.all())
    if (used.contains(texture.name())) *scene.add_textures() = texture;
}

}  // namespace tessera
