#pragma once

#include <cstddef>
#include <vector>

#include "front/free_camera.h"
#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/bounds.h"
#include "renderer/math/transform.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// About where a scene's shapes are: a box around those that end somewhere, at the beginning of all
/// motion. Empty where there are none. For cameras to begin with: the renderer, which knows better,
/// need not have built the scene. Of very large scenes a part is looked at.
Bounds3 rough_bounds(const LoadedScene& loaded);

/// Where a node is with all below it, wherever it is placed.
struct NodeExtent {
  Bounds3 bounds;    ///< about
  size_t times = 0;  ///< how often it is placed; 0: not known
  Affine world;      ///< from its axes to the world's, where it was found first
};

/// That of each node, by its number (proto/wire/node_numbers.h); at 0 nothing.
std::vector<NodeExtent> node_extents(const LoadedScene& loaded);

/// A camera of the scene in the numbers of a pointer: what it looks at is the scene's middle, as
/// far away as that is. Of one that frames all, about where the renderer places it: it sees the
/// box.
FreeCamera free_camera_of(const v1::Camera& camera, const Bounds3& bounds);

}  // namespace tessera
