#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scenes/formats/gltf/gltf_file.h"
#include "scenes/import/loaded_scene.h"
#include "scenes/import/texture_set.h"
#include "scenes/import/unique_names.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// Which sets of texture coordinates a material's textures take, in the order of their first use:
/// TEXCOORD_n by its number. A mesh has two.
using GltfUvSets = std::vector<size_t>;

/// A glTF file's textures and samplers as ours. Pictures that the file holds itself go to
/// LoadedScene::pictures.
class GltfTextures {
 public:
  /// `check` is asked about a relative path, or the bytes of what the file holds itself.
  GltfTextures(GltfFile& file, PictureCheck check, LoadedScene& out, Warnings& warnings)
      : file_(file), check_(std::move(check)), out_(out), warnings_(warnings) {}

  /// The name of the texture that a textureInfo object refers to, empty where there is none. Its
  /// set of texture coordinates is added to its material's.
  std::string use(const GltfValue& info, v1::Texture::Image::Encoding encoding, GltfUvSets& sets);
  bool is_used(size_t index) const { return used_.contains(index); }
  /// Of the textures used so far.
  const TextureSet& all() const { return textures_; }

 private:
  std::optional<size_t> readable_image(const GltfValue& texture);
  std::string picture(const GltfValue& image, size_t index);
  static void sample(const GltfValue& sampler, v1::Texture::Image& image);
  static void place(const GltfValue& transform, v1::Texture& texture);
  v1::Texture::Mapping mapping(const GltfValue& info, GltfUvSets& sets);

  GltfFile& file_;
  PictureCheck check_;
  LoadedScene& out_;
  Warnings& warnings_;
  TextureSet textures_;
  std::set<size_t> used_;
  std::map<size_t, std::string> pictures_;  ///< what Image.file says of an image; empty: none
};

/// A material of a file, or without an index the one that glTF gives by default.
struct GltfMaterialUse {
  std::optional<size_t> index;
  bool is_unlit = false;  ///< of what shows its base colour and emission as they are
  friend auto operator<=>(const GltfMaterialUse&, const GltfMaterialUse&) = default;
};

/// A glTF file's materials as ours, each made when it is first used.
class GltfMaterials {
 public:
  GltfMaterials(GltfFile& file, PictureCheck check, LoadedScene& out, Warnings& warnings)
      : file_(file),
        textures_(file, std::move(check), out, warnings),
        out_(out),
        warnings_(warnings) {}

  /// Its name in the scene.
  const std::string& use(const GltfMaterialUse& which);
  const GltfUvSets& uv_sets(const GltfMaterialUse& which) { return find(which).uv_sets; }
  const TextureSet& textures() const { return textures_.all(); }
  bool is_used(size_t index) const {
    return known_.contains({index, false}) || known_.contains({index, true});
  }
  bool is_texture_used(size_t index) const { return textures_.is_used(index); }

 private:
  struct Known {
    std::string name;
    GltfUvSets uv_sets;
  };

  const Known& find(const GltfMaterialUse& which);
  v1::Material convert(const GltfValue& in, bool is_unlit);
  void physical(const GltfValue& in, v1::Material& out);
  void metallic_roughness(const GltfValue& in, v1::Physical& out);
  void specular_glossiness(const GltfValue& in, v1::Physical& out);
  void layers(const GltfValue& extensions, v1::Physical& out);
  void coverage(const GltfValue& in, const GltfValue& base_factor, v1::Material& out);
  void color(const std::vector<double>& factor, const GltfValue& info, v1::ColorInput* out);
  void number(const GltfValue& factor, double without, const GltfValue& info,
              v1::FloatInput::Channel channel, v1::FloatInput* out);

  GltfFile& file_;
  GltfTextures textures_;
  LoadedScene& out_;
  Warnings& warnings_;
  UniqueNames unique_;
  std::map<GltfMaterialUse, Known> known_;
  GltfUvSets uv_sets_;  ///< of the material that is converted
};

}  // namespace tessera
