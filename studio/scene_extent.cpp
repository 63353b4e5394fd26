#include "studio/scene_extent.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/digest.h"
#include "proto/wire/node_numbers.h"
#include "renderer/camera/camera.h"
#include "renderer/math/elementary.h"
#include "renderer/math/transform.h"
#include "scenes/import/to_affine.h"

namespace tessera {
namespace {

constexpr int kMostDepth = 32;
constexpr size_t kMostNodes = 20'000, kMostPoints = 1'000'000;

Point3 to_point(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// A box of half the lengths of a side around a point.
Bounds3 around(const Point3& center, const Vec3& half) { return {center - half, center + half}; }

class ExtentFinder {
 public:
  /// Adds the extent of each node to those of `nodes`, if it is there.
  explicit ExtentFinder(const LoadedScene& loaded,
                        std::unordered_map<const v1::Node*, NodeExtent>* nodes = nullptr)
      : loaded_(loaded), of_nodes_(nodes) {
    for (const v1::Object& object : loaded.scene.objects()) objects_[object.name()] = &object;
  }

  Bounds3 find() {
    for (const v1::Node& node : loaded_.scene.nodes()) visit(node, {}, 0);
    return found_;
  }

  /// Whether all nodes were looked at.
  bool is_whole() const { return nodes_ <= kMostNodes; }

 private:
  void visit(const v1::Node& node, const Affine& parent, int depth) {
    if (depth > kMostDepth || ++nodes_ > kMostNodes || node.hidden()) return;
    const Affine world = parent * to_affine(node.transform());
    const Bounds3 others = std::exchange(found_, {});
    visit_parts(node, world, depth);
    if (of_nodes_) {
      NodeExtent& extent = (*of_nodes_)[&node];
      extent.bounds.extend(found_);
      if (extent.times++ == 0) extent.world = world;
    }
    found_.extend(others);
  }

  void visit_parts(const v1::Node& node, const Affine& world, int depth) {
    if (node.has_shape()) add(node.shape(), world, depth);
    for (const v1::Node& child : node.children()) visit(child, world, depth + 1);
    const auto object = objects_.find(node.instance_of());
    if (object == objects_.end()) return;
    for (const v1::Node& child : object->second->nodes()) visit(child, world, depth + 1);
  }

  void add(const v1::Shape& shape, const Affine& world, int depth) {
    if (shape.has_csg()) {
      for (const v1::Node& operand : shape.csg().operands()) visit(operand, world, depth + 1);
      return;
    }
    const Bounds3 box = box_of(shape);
    if (box.empty()) return;
    for (int corner = 0; corner < 8; ++corner) {
      const Point3 p =
          world(Point3{corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                       corner & 4 ? box.max.z : box.min.z});
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) found_.extend(p);
    }
  }

  /// In the shape's own axes; empty for one that does not end.
  Bounds3 box_of(const v1::Shape& shape) {
    switch (shape.kind_case()) {
      case v1::Shape::kSphere: {
        const double r = shape.sphere().has_radius() ? shape.sphere().radius() : 1;
        return around(to_point(shape.sphere().center()), {r, r, r});
      }
      case v1::Shape::kDisc: {
        const double r = shape.disc().has_radius() ? shape.disc().radius() : 1;
        return around(to_point(shape.disc().center()), {r, r, r});
      }
      case v1::Shape::kRectangle: {
        const Point3 corner = to_point(shape.rectangle().corner());
        const Vec3 u = to_point(shape.rectangle().edge_u()) - Point3{};
        const Vec3 v = to_point(shape.rectangle().edge_v()) - Point3{};
        Bounds3 box;
        for (const Point3& p : {corner, corner + u, corner + v, corner + u + v}) box.extend(p);
        return box;
      }
      case v1::Shape::kPolygon: {
        Bounds3 box;
        for (const v1::Vec3& p : shape.polygon().points()) box.extend(to_point(p));
        return box;
      }
      case v1::Shape::kBox:
        return {shape.box().has_min() ? to_point(shape.box().min()) : Point3{-1, -1, -1},
                shape.box().has_max() ? to_point(shape.box().max()) : Point3{1, 1, 1}};
      case v1::Shape::kCylinder: {
        const double r = shape.cylinder().has_radius() ? shape.cylinder().radius() : 1;
        const double h = shape.cylinder().has_height() ? shape.cylinder().height() : 2;
        return around({}, {r, h / 2, r});
      }
      case v1::Shape::kCone: {
        const double r = std::max(shape.cone().has_radius() ? shape.cone().radius() : 1,
                                  shape.cone().top_radius());
        const double h = shape.cone().has_height() ? shape.cone().height() : 2;
        return around({}, {r, h / 2, r});
      }
      case v1::Shape::kTorus: {
        const double minor = shape.torus().has_minor_radius() ? shape.torus().minor_radius() : .25;
        const double r =
            (shape.torus().has_major_radius() ? shape.torus().major_radius() : 1) + minor;
        return around({}, {r, minor, r});
      }
      case v1::Shape::kMesh:
        return box_of(shape.mesh());
      default:
        return {};
    }
  }

  Bounds3 box_of(const v1::TriangleMesh& mesh) {
    Bounds3 box;
    for (int i = 0; i + 2 < mesh.inline_positions_size(); i += 3)
      box.extend(Point3{mesh.inline_positions(i), mesh.inline_positions(i + 1),
                        mesh.inline_positions(i + 2)});
    const auto digest = Digest::parse(mesh.positions().digest());
    const BlobData blob = digest ? loaded_.blobs.find(*digest) : nullptr;
    if (!blob) return box;
    const auto [at, is_new] = meshes_.try_emplace(mesh.positions().digest());
    if (is_new) at->second = box_of(*blob);
    box.extend(at->second);
    return box;
  }

  /// Of a mesh with very many vertices some are left out.
  static Bounds3 box_of(const Blob& positions) {
    Bounds3 box;
    std::array<float, 3> p;
    const size_t count = positions.size() / sizeof p;
    const size_t step = count / kMostPoints + 1;
    for (size_t i = 0; i < count; i += step) {
      std::memcpy(p.data(), positions.data() + i * sizeof p, sizeof p);
      box.extend(Point3{p[0], p[1], p[2]});
    }
    return box;
  }

  const LoadedScene& loaded_;
  std::unordered_map<const v1::Node*, NodeExtent>* of_nodes_;
  std::map<std::string, const v1::Object*> objects_;
  std::map<std::string, Bounds3> meshes_;  ///< by the digest of their positions
  size_t nodes_ = 0;
  Bounds3 found_;
};

std::string axis_name(v1::Perspective::Axis axis) {
  switch (axis) {
    case v1::Perspective::VERTICAL:
      return "vertical";
    case v1::Perspective::HORIZONTAL:
      return "horizontal";
    case v1::Perspective::LARGER:
      return "larger";
    default:
      return "smaller";
  }
}

std::array<double, 3> to_array(const Point3& p) { return {p.x, p.y, p.z}; }

CameraSettings settings_of(const v1::Camera& camera, const Affine& world) {
  CameraSettings settings{.world_from_camera = world};
  if (camera.has_orthographic()) {
    const v1::Orthographic& window = camera.orthographic();
    settings.projection = Projection::orthographic;
    if (window.has_min_y()) settings.min_y = window.min_y();
    if (window.has_max_y()) settings.max_y = window.max_y();
  } else if (camera.has_spherical() || camera.has_cylindrical()) {
    settings.projection = Projection::spherical;
  } else {
    const v1::Perspective& view = camera.perspective();
    if (view.has_field_of_view()) settings.field_of_view = portable::radians(view.field_of_view());
    settings.shift = {view.shift_x(), view.shift_y()};
    if (view.pixel_aspect() > 0) settings.pixel_aspect = view.pixel_aspect();
  }
  return settings;
}

/// The settings so that the camera sees the box in a picture that is wider than high.
CameraSettings framed(const CameraSettings& settings, const Bounds3& bounds) {
  std::vector<Point3> corners;
  for (const double x : {bounds.min.x, bounds.max.x})
    for (const double y : {bounds.min.y, bounds.max.y})
      for (const double z : {bounds.min.z, bounds.max.z}) corners.push_back({x, y, z});
  return framed_view(settings, 16, 9, corners);
}

}  // namespace

Bounds3 rough_bounds(const LoadedScene& loaded) { return ExtentFinder(loaded).find(); }

std::vector<NodeExtent> node_extents(const LoadedScene& loaded) {
  std::unordered_map<const v1::Node*, NodeExtent> found;
  ExtentFinder finder(loaded, &found);
  finder.find();
  std::vector<NodeExtent> extents(1);
  for_each_node(loaded.scene, [&](const v1::Node& node) {
    const auto at = found.find(&node);
    extents.push_back(at == found.end() ? NodeExtent() : at->second);
    if (!finder.is_whole()) extents.back().times = 0;
  });
  return extents;
}

FreeCamera free_camera_of(const v1::Camera& camera, const Bounds3& bounds) {
  const v1::Transform& transform =
      camera.keys_size() > 0 ? camera.keys(0).transform() : camera.world_from_camera();
  CameraSettings settings = settings_of(camera, to_affine(transform));
  const bool is_framed = camera.frame_all() && !bounds.empty();
  if (is_framed) settings = framed(settings, bounds);
  const Affine& world = settings.world_from_camera;
  const Point3 eye = world(Point3{});
  const Vec3 forward = normalize(world(Vec3{0, 0, -1}));
  double distance = bounds.empty() ? 1 : dot(bounds.center() - eye, forward);
  const int steps = transform.steps_size();
  if (!is_framed && steps > 0 && transform.steps(steps - 1).has_look_at()) {
    const v1::LookAt& look_at = transform.steps(steps - 1).look_at();
    distance = length(to_point(look_at.target()) - to_point(look_at.eye()));
  }
  if (!(distance > 0)) distance = 1;
  FreeCamera numbers{.eye = to_array(eye), .target = to_array(eye + forward * distance)};
  numbers.up = to_array(Point3{} + normalize(world(Vec3{0, 1, 0})));
  if (camera.has_orthographic()) numbers.orthographic = settings.max_y - settings.min_y;
  if (camera.perspective().has_field_of_view()) numbers.fov = camera.perspective().field_of_view();
  numbers.axis = axis_name(camera.perspective().axis());
  return numbers;
}

}  // namespace tessera
