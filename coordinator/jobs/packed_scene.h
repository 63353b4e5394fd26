#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "base/digest.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// What a coordinator has to know of a scene. It is read once, when the scene comes, as reading
/// millions of nodes takes seconds, in which the farm is not served.
struct SceneFacts {
  std::vector<v1::BlobRef> blobs{};  ///< each once
  bool moves = true;                 ///< as job/scene_motion.h has it
};

using SceneFactsMap = std::unordered_map<Digest, SceneFacts>;

/// Nothing where a blob that it refers to has no name.
std::optional<SceneFacts> facts_of(const v1::Scene& scene);

/// A scene as workers get it. A value; the bytes are shared.
struct PackedScene {
  BlobData bytes;
  Digest digest;
  bool moves = true;
};

PackedScene pack_scene(const v1::Scene& scene);

}  // namespace tessera
