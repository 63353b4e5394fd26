#pragma once

#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/vec.h"

namespace tessera {

/// `v` of a world whose y axis points up, in one whose z axis does where `z_is_up`: what was in
/// front, at +z, is at -y.
inline Vec3 stood_up(const Vec3& v, bool z_is_up) { return z_is_up ? Vec3{v.x, -v.z, v.y} : v; }

/// Adds that turn to a transform, as the first that acts.
void stand_up(v1::Transform& transform);

/// Directions of unit length: from where a scene is seen, and what is up in its picture.
struct StandardView {
  Vec3 from, up;
};

/// front, back, left, right, side (the same as right), top, bottom and iso, which is from the
/// front, the right and above.
const std::vector<std::string>& standard_view_names();
/// `name`: one of those.
StandardView standard_view(const std::string& name, bool z_is_up);

/// A camera of that view and name, moved so that all just fits the picture. `field_of_view`:
/// degrees over the picture's smaller side.
v1::Camera standard_camera(const std::string& name, bool z_is_up, double field_of_view);

/// Of cameras that see a model by itself, degrees.
inline constexpr double kModelFieldOfView = 35;

}  // namespace tessera
