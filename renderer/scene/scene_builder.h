#pragma once

#include <memory>

#include "base/live_things.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// Builds the frame's scene. Throws a scene error where the description is wrong, or names an
/// integrator, camera or accelerator that there is not. `threads` do not change the result, nor
/// does where trees are shared.
/// `skips` change no picture beyond what docs/skipping.md says.
std::shared_ptr<const Scene> build_scene(const v1::Scene& description, const BlobStore& blobs,
                                         const v1::FrameSettings& frame, int threads,
                                         const Sharing& sharing = {}, const Skips& skips = {});

}  // namespace tessera
