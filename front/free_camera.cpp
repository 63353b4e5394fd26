#include "front/free_camera.h"

#include <utility>

#include "renderer/scene/read_camera.h"

namespace tessera {
namespace {

void set(v1::Vec3& to, const std::array<double, 3>& from) {
  to.set_x(from[0]);
  to.set_y(from[1]);
  to.set_z(from[2]);
}

v1::Perspective::Axis axis_of(const std::string& name) {
  if (name == "vertical") return v1::Perspective::VERTICAL;
  if (name == "horizontal") return v1::Perspective::HORIZONTAL;
  if (name == "larger") return v1::Perspective::LARGER;
  return v1::Perspective::SMALLER;
}

}  // namespace

void use_free_camera(v1::Scene& scene, const std::string& name, const FreeCamera& camera) {
  v1::Camera made;
  if (const v1::Camera* const used = find_camera(scene, name)) made = *used;
  made.clear_keys();
  made.clear_frame_all();
  made.clear_world_from_camera();
  v1::LookAt& look_at = *made.mutable_world_from_camera()->add_steps()->mutable_look_at();
  set(*look_at.mutable_eye(), camera.eye);
  set(*look_at.mutable_target(), camera.target);
  set(*look_at.mutable_up(), camera.up);
  if (camera.orthographic) {
    const double half = *camera.orthographic / 2;
    v1::Orthographic& window = *made.mutable_orthographic();
    window.set_min_x(-half);
    window.set_max_x(half);
    window.set_min_y(-half);
    window.set_max_y(half);
  } else if (!made.has_spherical() && !made.has_cylindrical()) {
    v1::Perspective& perspective = *made.mutable_perspective();
    perspective.set_field_of_view(camera.fov);
    perspective.set_axis(axis_of(camera.axis));
  }
  scene.clear_cameras();
  *scene.add_cameras() = std::move(made);
}

}  // namespace tessera
