#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/transform.h"
#include "renderer/scene/node_ways.h"
#include "renderer/shading/light.h"

namespace tessera {

/// A shape that is to be built once, however many nodes show it.
struct GraphShape {
  const v1::Shape* shape = nullptr;
  std::string path;  ///< of the first node that shows it
};

struct GraphInstance {
  uint32_t shape = 0;        ///< into SceneGraph::shapes
  Affine world_from_object;  ///< invertible
  uint32_t scope = 0;        ///< into SceneGraph::scopes
  bool casts_shadow = true;
  const std::string* name = nullptr;  ///< of the nearest node above that has one, or null
  uint32_t way = kNoWay;              ///< into NodeWays; kNoWay where they are not kept
};

/// The nodes unfolded, in drawing order, without what is hidden, off or flat.
struct SceneGraph {
  std::vector<GraphShape> shapes;
  std::vector<GraphInstance> instances;
  std::vector<Light> lights;
  std::vector<uint32_t> global_lights;  ///< those that light everything
  std::vector<std::vector<uint32_t>>
      scopes;  ///< the other lights of each scope; the first is empty
  NodeWays ways;
  size_t hidden_nodes = 0, flat_nodes = 0, lights_off = 0, objects_used = 0;
};

/// Bounds on what a description may unfold to.
inline constexpr int kMaxNodeDepth = 200;
inline constexpr size_t kMaxNodeVisits = size_t{1} << 24;
inline constexpr size_t kMaxLights = 100000;
inline constexpr size_t kMaxScopedLights = 10'000'000;  ///< summed over the scopes
inline constexpr size_t kMaxInstances = size_t{1} << 22;

/// Unfolds the scene's nodes and objects at `time`. Throws a scene error for cycles, unknown names,
/// and what is too deep or too much.
/// `viewer` is the frame of the camera that billboards turn to. Ways to instances are kept where
/// `keep_ways` is set.
SceneGraph unfold_graph(const v1::Scene& scene, double time, const Affine& viewer,
                        bool keep_ways = false);

}  // namespace tessera
