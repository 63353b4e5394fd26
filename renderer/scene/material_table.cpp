#include "renderer/scene/material_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "renderer/scene/read_shading.h"

namespace tessera {

MaterialTable::MaterialTable(const v1::Scene& scene, TextureTable& textures)
    : scene_(scene), textures_(textures) {
  for (const v1::Material& material : scene.materials()) {
    const Where where{.kind = "material", .name = material.name()};
    if (material.name().empty()) fail_value(where, "name", "empty", "a name");
    if (!by_name_.try_emplace(material.name(), &material).second) {
      fail_value(where, "name", "used twice", "a name of its own");
    }
  }
}

uint32_t MaterialTable::use(const Where& where, const std::string& name) {
  const v1::Material* source = &v1::Material::default_instance();
  if (!name.empty()) {
    const auto found = by_name_.find(name);
    if (found == by_name_.end()) {
      std::vector<std::string> known;
      for (const v1::Material& material : scene_.materials()) known.push_back(material.name());
      throw scene_error(
          SourcePlace{where.str()},
          fmt::format("material '{}' is not defined{}", name, suggestion(name, known)), "");
    }
    source = found->second;
  }
  const auto [known, is_new] = used_.try_emplace(source, static_cast<uint32_t>(materials_.size()));
  const uint32_t index = known->second;
  if (!is_new) return index;
  const Where place{.kind = "material", .name = name};
  MaterialInputs inputs;
  materials_.push_back(read_material(place, *source, textures_, inputs));
  if (inputs.needs_point() || inputs.alpha_mode != AlphaMode::blend) {
    materials_.back().inputs = static_cast<uint32_t>(inputs_.size());
    inputs_.push_back(std::move(inputs));
  }
  // Its own number is known by now, so that materials may name each other.
  if (materials_[index].has_other_back()) {
    constexpr int kDeepest = 64;
    if (depth_ >= kDeepest) {
      fail_value(place, "backs of backs", fmt::format("{} deep", depth_ + 1),
                 fmt::format("at most {}", kDeepest));
    }
    ++depth_;
    const uint32_t back = use(place, source->back());
    --depth_;
    materials_[index].back = back;
  }
  return index;
}

bool MaterialTable::has_normal_map(uint32_t index) const {
  const uint32_t inputs = materials_[index].inputs;
  return inputs != kNoMaterialInputs && inputs_[inputs].normal_map != kNoTexture;
}

/// Whether `asks` says yes to a texture that the material looks at.
template <class Asks>
bool MaterialTable::any_texture(uint32_t index, const Asks& asks) const {
  if (materials_[index].inputs == kNoMaterialInputs) return false;
  const MaterialInputs& inputs = inputs_[materials_[index].inputs];
  const auto ask = [&](uint32_t texture) { return texture != kNoTexture && asks(texture); };
  return ask(inputs.normal_map) || ask(inputs.bump) ||
         std::any_of(inputs.slots.begin(), inputs.slots.end(),
                     [&](const MaterialInputs::Slot& slot) { return ask(slot.texture); });
}

bool MaterialTable::needs_uv(uint32_t index) const {
  // A normal map is laid along the directions in which the coordinates grow.
  return has_normal_map(index) ||
         any_texture(index, [&](uint32_t texture) { return textures_.needs_uv(texture); });
}

bool MaterialTable::needs_second_uv(uint32_t index) const {
  return any_texture(index, [&](uint32_t texture) { return textures_.needs_second_uv(texture); });
}

}  // namespace tessera
