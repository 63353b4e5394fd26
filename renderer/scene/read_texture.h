#pragma once

#include <memory>
#include <string>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/scene/check.h"
#include "renderer/shading/image_texture.h"

namespace tessera {

/// The image texture called `name`, its sizes held against its blob. Throws a scene error that
/// begins with `where`, for textures of other kinds too.
std::shared_ptr<const ImageTexture> read_image_texture(const Where& where, const v1::Scene& scene,
                                                       const BlobStore& blobs,
                                                       const std::string& name);

}  // namespace tessera
