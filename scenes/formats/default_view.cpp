#include "scenes/formats/default_view.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/math/vec.h"
#include "scenes/import/three_quarters.h"
#include "scenes/import/to_affine.h"

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
  const Vec3 back = three_quarters();
  const Vec3 right = normalize(cross(Vec3{0, 1, 0}, back));
  return {right, cross(back, right), back};
}

using Points = std::vector<Point3>;

/// Adds corners of a box to the points, as they stand under `world`.
void add_box(const Bounds3& box, const Affine& world, Points& points) {
  for (int corner = 0; corner < 8; ++corner)
    points.push_back(
        world(Point3{corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                     corner & 4 ? box.max.z : box.min.z}));
}

/// Finds the points of meshes that a view has to show.
class PointFinder {
 public:
  explicit PointFinder(const LoadedScene& loaded) : loaded_(loaded) {
    for (const v1::Object& object : loaded.scene.objects()) objects_[object.name()] = &object;
  }

  Points find() {
    for (const v1::Node& node : loaded_.scene.nodes()) visit(node, {}, 0);
    return std::move(points_);
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

  /// All vertices, as long as they are few enough; then the corners of boxes.
  void add(const v1::TriangleMesh& mesh, const Affine& world) {
    const auto digest = Digest::parse(mesh.positions().digest());
    const BlobData blob = digest ? loaded_.blobs.find(*digest) : nullptr;
    if (!blob) return;
    const size_t count = blob->size() / 12;
    if (count <= kMostPoints && points_.size() <= kMostPoints - count) {
      const size_t needed = points_.size() + count;
      if (needed > points_.capacity()) points_.reserve(std::max(needed, 2 * points_.capacity()));
      for (size_t i = 0; i < count; ++i) points_.push_back(world(point(*blob, i)));
      return;
    }
    const auto [at, is_new] = boxes_.try_emplace(mesh.positions().digest());
    if (is_new)
      for (size_t i = 0; i < count; ++i) at->second.extend(point(*blob, i));
    add_box(at->second, world, points_);
  }

  static Point3 point(const Blob& blob, size_t index) {
    std::array<float, 3> p;
    std::memcpy(p.data(), blob.data() + index * sizeof p, sizeof p);
    return {p[0], p[1], p[2]};
  }

  static constexpr int kMaxDepth = 64;
  static constexpr size_t kMostPoints = size_t{1} << 22;

  const LoadedScene& loaded_;
  std::map<std::string, const v1::Object*> objects_;
  std::map<std::string, Bounds3> boxes_;
  Points points_;
};

/// The eye from which the model just fits the view, and the point that it looks at.
struct Fit {
  Vec3 eye, target;
};

Fit fit(const Points& points, const Frame& frame) {
  Bounds3 seen;  // in the frame's axes
  const auto along = [](const Point3& p, const Vec3& axis) { return dot(p - Point3{}, axis); };
  for (const Point3& p : points)
    seen.extend(Point3{along(p, frame.right), along(p, frame.up), along(p, frame.back)});
  const Point3 middle = seen.empty() ? Point3{} : seen.center();
  double distance = 0;
  for (const Point3& p : points) {
    const double across = std::max(std::abs(along(p, frame.right) - middle.x),
                                   std::abs(along(p, frame.up) - middle.y));
    distance = std::max(distance, across * kMargin / kTanHalf + along(p, frame.back) - middle.z);
  }
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

void add_camera(LoadedScene& loaded, const Frame& frame) {
  const Fit view = fit(PointFinder(loaded).find(), frame);
  v1::Camera& camera = *loaded.scene.add_cameras();
  camera.set_name("default");
  v1::LookAt& look = *camera.mutable_world_from_camera()->add_steps()->mutable_look_at();
  put(view.eye, look.mutable_eye());
  put(view.target, look.mutable_target());
  camera.mutable_perspective()->set_field_of_view(kFieldOfView);
}

void add_lights(v1::Scene& scene, const Frame& frame) {
  add_light(scene, "key", frame.back + frame.up * 0.9 - frame.right * 0.7, 0.85, 1);
  add_light(scene, "fill", frame.back + frame.right, 0.15, -0.5);
  add_light(scene, "rim", frame.up * 0.8 - frame.back + frame.right * 0.6, 0.3, -1);
  put(.06, .06, .07, scene.mutable_settings()->mutable_integrator()->mutable_ambient());
}

bool has_light(const google::protobuf::RepeatedPtrField<v1::Node>& nodes) {
  return std::any_of(nodes.begin(), nodes.end(), [](const v1::Node& node) {
    return node.has_light() || has_light(node.children());
  });
}

}  // namespace

void add_default_view(LoadedScene& loaded) {
  v1::Scene& scene = loaded.scene;
  const Frame frame = view_frame();
  if (scene.cameras().empty()) add_camera(loaded, frame);
  if (!has_light(scene.nodes())) add_lights(scene, frame);
  if (scene.has_background()) return;
  v1::Background::Gradient& gradient = *scene.mutable_background()->mutable_gradient();
  put(.42, .5, .6, gradient.mutable_sky());
  put(.16, .17, .19, gradient.mutable_ground());
}

}  // namespace tessera
