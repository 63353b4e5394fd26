#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/vec.h"

namespace tessera {

/// The direction, of unit length, from which what came without a camera is seen: from the front,
/// the right and above.
inline Vec3 three_quarters() { return normalize(Vec3{0.55, 0.38, 1}); }

/// A camera called "default" that looks from there, moved so that all just fits the picture.
/// `field_of_view`: degrees over the picture's smaller side.
inline v1::Camera three_quarters_camera(double field_of_view) {
  v1::Camera camera;
  camera.set_name("default");
  v1::LookAt& look = *camera.mutable_world_from_camera()->add_steps()->mutable_look_at();
  look.mutable_eye()->set_x(three_quarters().x);
  look.mutable_eye()->set_y(three_quarters().y);
  look.mutable_eye()->set_z(three_quarters().z);
  look.mutable_target();
  camera.mutable_perspective()->set_field_of_view(field_of_view);
  camera.set_frame_all(true);
  return camera;
}

}  // namespace tessera
