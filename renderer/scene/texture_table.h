#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/scene/check.h"
#include "renderer/shading/texture.h"

namespace tessera {

/// The textures that materials and the background ask for, read when first asked: what nothing uses
/// is not even looked at.
class TextureTable {
 public:
  /// Both must outlive this. Throws a scene error where a name comes twice.
  TextureTable(const v1::Scene& scene, const BlobStore& blobs);

  /// The index of the texture that `field` calls `name`. Throws a scene error that names the field
  /// for an unknown one, and one for a texture that is wrong or a part of itself.
  uint32_t use(const Where& where, std::string_view field, const std::string& name);
  /// The same of an image texture alone, for where no other can be.
  std::shared_ptr<const ImageTexture> use_image(const Where& where, std::string_view field,
                                                const std::string& name);
  /// `input`'s colour, `fallback` where it is not given.
  TexturedColor read(const Where& where, std::string_view field, const v1::ColorInput& input,
                     const Color& fallback);

  const Texture& operator[](uint32_t index) const { return textures_[index]; }
  /// Whether its value depends on texture coordinates of the shape.
  bool needs_uv(uint32_t index) const { return facts_[index].needs_uv; }
  /// Whether on its second ones, where it has any.
  bool needs_second_uv(uint32_t index) const { return facts_[index].needs_second_uv; }
  /// Bytes of texels that some texture uses, each blob once.
  uint64_t texel_bytes() const;
  size_t size() const { return textures_.size(); }
  std::vector<Texture> take() { return std::move(textures_); }

 private:
  const v1::Texture& find(const Where& where, std::string_view field,
                          const std::string& name) const;
  std::shared_ptr<const ImageTexture> read_image(const Where& where, const v1::Texture::Image& in);

  const v1::Scene& scene_;
  const BlobStore& blobs_;
  std::unordered_map<std::string_view, const v1::Texture*> by_name_;
  std::unordered_map<const v1::Texture*, uint32_t> used_;
  std::unordered_map<std::string, uint64_t> blob_bytes_;
  std::vector<const v1::Texture*> active_;  ///< being read, each for the one before
  struct Facts {
    bool needs_uv = false, needs_second_uv = false;
    int depth = 1;
  };
  std::vector<Facts> facts_;  ///< one a texture
  std::vector<Texture> textures_;
};

}  // namespace tessera
