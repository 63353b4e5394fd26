#include "scenes/formats/default_view.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/math/transform.h"
#include "renderer/math/vec.h"
#include "scenes/import/put_vec3.h"
#include "scenes/import/standard_view.h"
#include "scenes/import/to_affine.h"

namespace tessera {
namespace {

constexpr uint32_t kSamples = 4;  // a pixel, so that edges are smooth
constexpr double kSoftBox = 32;   // degrees from the zenith towards the viewer

/// The frame that looks along -back.
struct Frame {
  Vec3 right, up, back;
};

Frame view_frame(bool z_is_up) {
  const StandardView view = standard_view("iso", z_is_up);
  const Vec3 right = normalize(cross(view.up, view.from));
  return {right, cross(view.from, right), view.from};
}

/// Finds the box of all meshes.
class BoundsFinder {
 public:
  explicit BoundsFinder(const LoadedScene& loaded) : loaded_(loaded) {
    for (const v1::Object& object : loaded.scene.objects()) objects_[object.name()] = &object;
  }

  Bounds3 find() {
    for (const v1::Node& node : loaded_.scene.nodes()) visit(node, {}, 0);
    return bounds_;
  }

 private:
  void visit(const v1::Node& node, const Affine& parent, int depth) {
    if (depth > kMaxDepth) return;
    const Affine world = parent * to_affine(node.transform());
    if (node.shape().has_mesh()) add(node.shape().mesh(), world);
    for (const v1::Node& child : node.children()) visit(child, world, depth + 1);
    const auto object = objects_.find(node.instance_of());
    if (object == objects_.end()) return;
    for (const v1::Node& child : object->second->nodes()) visit(child, world, depth + 1);
  }

  void add(const v1::TriangleMesh& mesh, const Affine& world) {
    const auto [at, is_new] = boxes_.try_emplace(mesh.positions().digest());
    Bounds3& box = at->second;
    if (is_new) {
      const auto digest = Digest::parse(mesh.positions().digest());
      const BlobData blob = digest ? loaded_.blobs.find(*digest) : nullptr;
      std::array<float, 3> p;
      for (size_t i = 0; blob && i + sizeof p <= blob->size(); i += sizeof p) {
        std::memcpy(p.data(), blob->data() + i, sizeof p);
        box.extend(Point3{p[0], p[1], p[2]});
      }
    }
    bounds_.extend(Transform(world).bounds(box));
  }

  static constexpr int kMaxDepth = 64;

  const LoadedScene& loaded_;
  std::map<std::string, const v1::Object*> objects_;
  std::map<std::string, Bounds3> boxes_;
  Bounds3 bounds_;
};

void put(double r, double g, double b, v1::Color* out) {
  out->set_r(r);
  out->set_g(g);
  out->set_b(b);
}

void add_light(v1::Scene& scene, const char* name, const Vec3& from, double intensity,
               double warm) {
  v1::Light& light = *scene.add_nodes()->mutable_light();
  light.set_name(name);
  put_vec3(-normalize(from), light.mutable_directional()->mutable_direction());
  put(1, 1 - 0.04 * warm, 1 - 0.1 * warm, light.mutable_color());
  light.set_intensity(intensity);
}

/// Gives cameras that stand within the model a light of their own: walls may keep all others out.
void add_headlights(v1::Scene& scene, const Bounds3& bounds) {
  for (v1::Camera& camera : *scene.mutable_cameras()) {
    if (!bounds.contains(to_affine(camera.world_from_camera())(Point3{}))) continue;
    v1::Light& light = *camera.mutable_headlight();
    light.mutable_point();
    light.set_intensity(0.3);
  }
}

/// What lies around the model sends about as much light as the ambient light, which stands for it
/// where paths are not followed.
void add_lights(v1::Scene& scene, const Frame& frame) {
  add_light(scene, "key", frame.back + frame.up * 0.9 - frame.right * 0.7, 0.65, 1);
  add_light(scene, "fill", frame.back + frame.right, 0.15, -0.5);
  add_light(scene, "rim", frame.up * 0.8 - frame.back + frame.right * 0.6, 0.3, -1);
  put(.18, .18, .2, scene.mutable_settings()->mutable_integrator()->mutable_ambient());
}

/// A studio: a round soft box over the viewer's head, and dim walls that grow darker away from it,
/// so that what mirrors them differs from what is seen behind it.
void add_background(v1::Scene& scene, const Frame& frame, bool z_is_up) {
  struct Ring {
    double angle, r, g, b;  ///< degrees from the middle of the soft box
  };
  constexpr Ring kRings[] = {{0, .8, .8, .8},
                             {18, .8, .8, .8},
                             {28, .2, .22, .25},
                             {110, .17, .19, .22},
                             {180, .05, .05, .06}};
  v1::Background& background = *scene.mutable_background();
  v1::Background::Rings& rings = *background.mutable_rings();
  for (const Ring& ring : kRings) {
    put(ring.r, ring.g, ring.b, rings.add_sky());
    if (ring.angle > 0) rings.add_sky_angles(ring.angle);
  }
  v1::Transform& orientation = *background.mutable_orientation();
  v1::AxisAngle& turn = *orientation.add_steps()->mutable_rotate();
  put_vec3(frame.right, turn.mutable_axis());
  turn.set_angle(kSoftBox);
  if (z_is_up) stand_up(orientation);
}

bool has_light(const google::protobuf::RepeatedPtrField<v1::Node>& nodes) {
  return std::any_of(nodes.begin(), nodes.end(), [](const v1::Node& node) {
    return node.has_light() || has_light(node.children());
  });
}

}  // namespace

void add_default_view(LoadedScene& loaded, bool z_is_up, const ReadOptions& options) {
  v1::Scene& scene = loaded.scene;
  const Frame frame = view_frame(z_is_up);
  const bool is_lit = !options.environment.empty() || has_light(scene.nodes());
  if (!is_lit) add_lights(scene, frame);
  if (scene.cameras().empty()) {
    *scene.add_cameras() = standard_camera("iso", z_is_up, kModelFieldOfView);
    scene.mutable_cameras(0)->set_name("default");
  } else if (!is_lit && !options.brings_camera) {
    add_headlights(scene, BoundsFinder(loaded).find());
  }
  if (!scene.has_background()) add_background(scene, frame, z_is_up);
  v1::Sampling& sampling = *scene.mutable_settings()->mutable_sampling();
  if (!sampling.has_samples_per_pixel()) sampling.set_samples_per_pixel(kSamples);
}

}  // namespace tessera
