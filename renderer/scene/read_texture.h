#pragma once

#include <memory>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/scene/check.h"
#include "renderer/shading/texture.h"

namespace tessera {

// From messages to what shading looks up. Each checks every number that it reads and throws a scene
// error that begins with `where`.

/// Sizes are held against the blob before anything is allocated for them.
std::shared_ptr<const ImageTexture> read_image_texture(const Where& where,
                                                       const v1::Texture::Image& image,
                                                       const BlobStore& blobs);
/// Mapping and transform.
void read_mapping(const Where& where, const v1::Texture& texture, Texture& out);
/// A kind that needs neither files nor other textures.
void read_pattern(const Where& where, const v1::Texture& texture, Texture& out);

}  // namespace tessera
