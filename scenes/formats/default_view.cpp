#include "scenes/formats/default_view.h"

#include <algorithm>
#include <cstring>

#include "renderer/math/bounds.h"
#include "renderer/math/vec.h"

namespace tessera {
namespace {

constexpr double kFieldOfView = 35;               // degrees
constexpr double kTanHalf = 0.31529878887898355;  // of half of it
constexpr double kMargin = 1.06;

/// The frame that looks along -back.
struct Frame {
  Vec3 right, up, back;
};

Frame view_frame() {
  const Vec3 back = normalize(Vec3{0.55, 0.38, 1});
  const Vec3 right = normalize(cross(Vec3{0, 1, 0}, back));
  return {right, cross(back, right), back};
}

/// Calls action for each vertex of the meshes.
template <typename Action>
void for_each_point(const LoadedScene& loaded, const Action& action) {
  for (const v1::Node& node : loaded.scene.nodes()) {
    const auto digest = Digest::parse(node.shape().mesh().positions().digest());
    const BlobData blob = digest ? loaded.blobs.find(*digest) : nullptr;
    if (!blob) continue;
    for (size_t at = 0; at + 12 <= blob->size(); at += 12) {
      float p[3];
      std::memcpy(p, blob->data() + at, sizeof p);
      action(Vec3{p[0], p[1], p[2]});
    }
  }
}

/// The eye from which the model just fits the view, and the point that it looks at.
struct Fit {
  Vec3 eye, target;
};

Fit fit(const LoadedScene& loaded, const Frame& frame) {
  Bounds3 seen;  // in the frame's axes
  for_each_point(loaded, [&](const Vec3& p) {
    seen.extend(Point3{dot(p, frame.right), dot(p, frame.up), dot(p, frame.back)});
  });
  const Point3 middle = seen.empty() ? Point3{} : seen.center();
  double distance = 0;
  for_each_point(loaded, [&](const Vec3& p) {
    const double across =
        std::max(std::abs(dot(p, frame.right) - middle.x), std::abs(dot(p, frame.up) - middle.y));
    distance = std::max(distance, across * kMargin / kTanHalf + dot(p, frame.back) - middle.z);
  });
  if (distance <= 0) distance = 1;
  const Vec3 target = frame.right * middle.x + frame.up * middle.y + frame.back * middle.z;
  return {target + frame.back * distance, target};
}

void put(const Vec3& v, v1::Vec3* out) {
  out->set_x(v.x);
  out->set_y(v.y);
  out->set_z(v.z);
}

void put(double r, double g, double b, v1::Color* out) {
  out->set_r(r);
  out->set_g(g);
  out->set_b(b);
}

void add_light(v1::Scene& scene, const char* name, const Vec3& from, double intensity,
               double warm) {
  v1::Light& light = *scene.add_nodes()->mutable_light();
  light.set_name(name);
  put(-normalize(from), light.mutable_directional()->mutable_direction());
  put(1, 1 - 0.04 * warm, 1 - 0.1 * warm, light.mutable_color());
  light.set_intensity(intensity);
}

}  // namespace

void add_default_view(LoadedScene& loaded) {
  v1::Scene& scene = loaded.scene;
  const Frame frame = view_frame();
  const Fit view = fit(loaded, frame);
  v1::Camera& camera = *scene.add_cameras();
  camera.set_name("default");
  v1::LookAt& look = *camera.mutable_world_from_camera()->add_steps()->mutable_look_at();
  put(view.eye, look.mutable_eye());
  put(view.target, look.mutable_target());
  camera.mutable_perspective()->set_field_of_view(kFieldOfView);
  add_light(scene, "key", frame.back + frame.up * 0.9 - frame.right * 0.7, 0.85, 1);
  add_light(scene, "fill", frame.back + frame.right, 0.15, -0.5);
  add_light(scene, "rim", frame.up * 0.8 - frame.back + frame.right * 0.6, 0.3, -1);
  put(.06, .06, .07, scene.mutable_settings()->mutable_integrator()->mutable_ambient());
  v1::Background::Gradient& gradient = *scene.mutable_background()->mutable_gradient();
  put(.42, .5, .6, gradient.mutable_sky());
  put(.16, .17, .19, gradient.mutable_ground());
}

}  // namespace tessera
