#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/math/bounds.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {

/// A scene of the octree study (Hiller 2018) in plain numbers, the same on every machine.
struct OctreeScene {
  struct Placed {
    Point3 center;
    double radius;
  };
  std::string name;
  std::vector<Placed> spheres;
  std::vector<Placed> diamonds;  ///< diamond()s: corners on the axes at `radius` from the centre
  MeshData mesh;                 ///< one object; empty but for the teapot
  Point3 eye, target;            ///< +y is up
  double field_of_view = 45;     ///< degrees, of the picture's height
  std::optional<Point3> point_light;  ///< with it goes a directional light along the camera's view
};

/// uniform-diamonds, random-diamonds, concentric-spheres, clumped-diamonds, teapot.
const std::vector<std::string>& octree_scene_names();
/// Throws a usage Error for an unknown name.
OctreeScene make_octree_scene(std::string_view name);

/// A pot with lid, spout and handle in about 25,000 triangles, made of revolved and swept curves of
/// our own; about 3 wide, standing on y = 0.
MeshData pot_mesh();
/// Puts the camera where `box` fills the picture's height.
void look_at_box(const Bounds3& box, OctreeScene& scene);

}  // namespace tessera
