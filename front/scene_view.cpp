#include "front/scene_view.h"

#include <vector>

#include "base/error.h"
#include "front/check_buildable.h"
#include "renderer/camera/camera.h"
#include "renderer/math/bounds.h"
#include "renderer/math/elementary.h"
#include "renderer/scene/read_camera.h"
#include "renderer/scene/scene.h"
#include "scenes/import/put_vec3.h"
#include "scenes/import/standard_view.h"

namespace tessera {
namespace {

bool z_is_up(const RenderOptions& options, const v1::Scene& scene) {
  if (options.reading.up != ReadOptions::Up::by_format)
    return options.reading.up == ReadOptions::Up::z;
  if (scene.cameras().empty()) return false;
  for (const v1::Transform::Step& step : scene.cameras(0).world_from_camera().steps()) {
    const v1::Vec3& up = step.look_at().up();
    if (up.z() > 0 && up.x() == 0 && up.y() == 0) return true;
  }
  return false;
}

/// Around every surface that ends somewhere.
Bounds3 finite_bounds(const Scene& scene) {
  Bounds3 all;
  for (const Instance& instance : scene.instances) {
    const Bounds3 box = instance.shape->bounds();
    if (box.empty() || !is_finite(box.diagonal())) continue;
    all.extend(instance.world_from_object.bounds(box));
  }
  return all;
}

/// Points around the upright cylinder that holds the box however it is turned about the axis `up`
/// through its middle.
std::vector<Point3> turned_outline(const Bounds3& box, const Vec3& up) {
  constexpr int kDirections = 64;
  if (box.empty()) return {};
  const Vec3 half = box.diagonal() * 0.5;
  const Point3 middle = box.center();
  const Vec3 rise = up * dot(half, up);
  const double radius = length(half - rise);
  const Vec3 side{1, 0, 0};
  const Vec3 ahead = cross(side, up);
  std::vector<Point3> points;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * portable::kPi * i / kDirections;
    const Vec3 out = (side * portable::cos(angle) + ahead * portable::sin(angle)) * radius;
    points.push_back(middle + out + rise);
    points.push_back(middle + out - rise);
  }
  return points;
}

/// Has the scene's only camera, of that view, go around what there is in so many frames, as far
/// from it in each.
void turn_camera(const RenderOptions& options, const StandardView& view, const Vec3& up, int frames,
                 LoadedScene& loaded) {
  const Bounds3 box = finite_bounds(*check_buildable(options, loaded));
  const v1::FrameSettings size = frame_settings(options, loaded.scene, std::nullopt);
  const CameraSettings framed =
      framed_view(read_camera(loaded.scene, "", 0).settings, static_cast<int>(size.width()),
                  static_cast<int>(size.height()), turned_outline(box, up));
  const Vec3 middle = box.empty() ? Vec3{} : box.center() - Point3{};
  const Vec3 eye = framed.world_from_camera(Point3{}) - Point3{} - middle;
  v1::Camera& camera = *loaded.scene.mutable_cameras(0);
  camera.clear_world_from_camera();
  camera.clear_frame_all();
  const auto add_key = [&](double time, double angle) {
    v1::TransformKey& key = *camera.add_keys();
    key.set_time(time);
    put_vec3(middle, key.mutable_transform()->add_steps()->mutable_translate());
    v1::AxisAngle& turn = *key.mutable_transform()->add_steps()->mutable_rotate();
    put_vec3(up, turn.mutable_axis());
    turn.set_angle(angle);
    v1::LookAt& look = *key.mutable_transform()->add_steps()->mutable_look_at();
    put_vec3(eye, look.mutable_eye());
    put_vec3(eye - view.from * length(eye), look.mutable_target());
    put_vec3(view.up, look.mutable_up());
  };
  add_key(0, 0);
  add_key(frames / scene_frame_rate(options.scene, loaded.scene.settings()), 360);
}

}  // namespace

bool brings_camera(const RenderOptions& options) {
  return options.view || options.turntable || options.camera == kAutoCamera;
}

void check_view(const RenderOptions& options) {
  if (!options.camera || !(options.view || options.turntable)) return;
  throw usage_error(options.view
                        ? "--view: is a camera in place of the scene's; expected no --camera"
                        : "--turntable: has a camera of its own; expected no --camera");
}

void use_view(const RenderOptions& options, LoadedScene& loaded) {
  if (!brings_camera(options)) return;
  v1::Scene& scene = loaded.scene;
  const bool is_z_up = z_is_up(options, scene);
  const std::string name = options.view.value_or("iso");
  v1::Camera camera = standard_camera(name, is_z_up, kModelFieldOfView);
  if (options.camera) camera.set_name(*options.camera);
  if (!scene.cameras().empty() && scene.cameras(0).has_headlight())
    *camera.mutable_headlight() = scene.cameras(0).headlight();
  scene.clear_cameras();
  *scene.add_cameras() = std::move(camera);
  if (options.turntable)
    turn_camera(options, standard_view(name, is_z_up), stood_up({0, 1, 0}, is_z_up),
                *options.turntable, loaded);
}

}  // namespace tessera
