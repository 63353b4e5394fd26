#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/scene/check.h"
#include "renderer/scene/texture_table.h"
#include "renderer/shading/material.h"
#include "renderer/shading/material_inputs.h"

namespace tessera {

/// The materials that shapes ask for, read when first asked: what nothing uses is not even looked
/// at.
class MaterialTable {
 public:
  /// Both must outlive this. Throws a scene error where a name comes twice.
  MaterialTable(const v1::Scene& scene, TextureTable& textures);

  /// The index of the material called `name`; the default one for an empty name. Throws a scene
  /// error that begins with `where` for an unknown one.
  uint32_t use(const Where& where, const std::string& name);

  const std::vector<Material>& materials() const { return materials_; }
  /// Whether shading with it depends on texture coordinates.
  bool needs_uv(uint32_t index) const;
  /// Whether on the shape's second ones, where it has any.
  bool needs_second_uv(uint32_t index) const;
  bool has_normal_map(uint32_t index) const;
  std::vector<Material> take() { return std::move(materials_); }
  std::vector<MaterialInputs> take_inputs() { return std::move(inputs_); }

 private:
  const v1::Scene& scene_;
  TextureTable& textures_;
  std::unordered_map<std::string_view, const v1::Material*> by_name_;
  std::unordered_map<const v1::Material*, uint32_t> used_;
  std::vector<Material> materials_;
  std::vector<MaterialInputs> inputs_;
  int depth_ = 0;  ///< of backs within backs, in use()

  template <class Asks>
  bool any_texture(uint32_t index, const Asks& asks) const;
};

}  // namespace tessera
