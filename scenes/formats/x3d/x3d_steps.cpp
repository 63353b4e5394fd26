#include "scenes/formats/x3d/x3d_steps.h"
#include "renderer/math/elementary.h"

#include <cmath>

#include "scenes/import/standard_view.h"

namespace tessera {

void add_translation(const Vec3& by, v1::Transform& out) {
  if (!(by == Vec3{})) put_vec3(by, out.add_steps()->mutable_translate());
}

void add_rotation(const X3dRotation& turn, v1::Transform& out) {
  if (turn.angle == 0) return;
  v1::AxisAngle& rotate = *out.add_steps()->mutable_rotate();
  put_vec3(turn.axis, rotate.mutable_axis());
  rotate.set_angle(portable::degrees(turn.angle));
}

v1::Camera default_camera() {
  v1::Camera camera = standard_camera("iso", false, 45);
  camera.set_name("default");
  return camera;
}

double mean_scale(const v1::Transform& transform) {
  double volume = 1;
  for (const v1::Transform::Step& step : transform.steps())
    if (step.has_scale()) volume *= step.scale().x() * step.scale().y() * step.scale().z();
  return std::cbrt(std::abs(volume));
}

}  // namespace tessera
