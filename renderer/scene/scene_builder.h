#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/weak_cache.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// What a built scene's parts are called in its description.
struct SceneNames {
  std::vector<std::string> instances;  ///< of the node, or else of the shape; may be empty
  std::vector<std::string> materials;  ///< one each of Scene::material_slots; empty: the default
};

/// What is built although the frame's picture does not depend on it.
struct BuildScope {
  bool all_meshes = false;      ///< at once: else the tree of a mesh is built when a ray reaches it
  bool all_attributes = false;  ///< of meshes: else those that a material or the frame reads
};

/// Builds the frame's scene. Throws a scene error where the description is wrong, or names an
/// integrator, camera or accelerator that there is not. `threads` do not change the result, nor
/// does where trees are shared. Fills `names`, if it is given.
std::shared_ptr<const Scene> build_scene(const v1::Scene& description, const BlobStore& blobs,
                                         const v1::FrameSettings& frame, int threads,
                                         const Sharing& sharing = {}, const BuildScope& scope = {},
                                         SceneNames* names = nullptr);

/// What was left out of a scene that hardly was meant to be, from its counters: whoever builds it
/// for a user tells.
std::vector<std::string> build_warnings(const CounterMap& counters);
/// Those of triangles alone, where nodes are told by their names.
std::vector<std::string> mesh_warnings(const CounterMap& counters);

}  // namespace tessera
