#include "bench/octree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

#include "base/error.h"
#include "bench/scene_mesh.h"
#include "bench/thread_seconds.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/accel/octree.h"
#include "renderer/math/elementary.h"
#include "renderer/shapes/sphere.h"
#include "scenes/generate/generate_scene.h"

namespace tessera {
namespace {

constexpr std::string_view kNloptName = "nonuniform-octree-nlopt";

/// Makes accelerators of one sort over meshes and over instances.
class Maker {
 public:
  explicit Maker(std::string_view name) : kind_(parse_accelerator(name)) {
    if (!kind_ && name != kNloptName)
      throw usage_error(fmt::format("'{}' is no accelerator of this benchmark", name));
  }
  std::unique_ptr<const Accelerator> over(std::shared_ptr<const TriangleMesh> mesh) const {
    if (kind_) return make_mesh_accelerator(std::move(mesh), *kind_, 1);
    return std::make_unique<MeshOctree>(*mesh, OctreeKind::nonuniform_nlopt, 1);
  }
  std::unique_ptr<const Accelerator> over(std::vector<Instance> instances) const {
    if (kind_) return make_instance_accelerator(std::move(instances), *kind_, 1);
    return std::make_unique<InstanceOctree>(std::move(instances), OctreeKind::nonuniform_nlopt, 1);
  }
  bool scans() const { return kind_ == AcceleratorKind::linear; }

 private:
  std::optional<AcceleratorKind> kind_;
};

/// Counts the tests of the object inside.
class CountingShape final : public Shape {
 public:
  CountingShape(std::shared_ptr<const Shape> shape, uint64_t* count)
      : shape_(std::move(shape)), count_(count) {}
  Bounds3 bounds() const override { return shape_->bounds(); }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    ++*count_;
    return shape_->closest_hit(ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    ++*count_;
    return shape_->any_hit(ray, counters);
  }
  LocalSurface surface(const Ray& ray, const Hit& hit) const override {
    return shape_->surface(ray, hit);
  }

 private:
  std::shared_ptr<const Shape> shape_;
  uint64_t* count_;
};

/// A scene with one accelerator over its objects and one over each mesh.
struct BuiltScene {
  std::vector<Instance> instances;  ///< the accelerator has its own; these are for surface_at
  std::unique_ptr<const Accelerator> accelerator;
  std::vector<std::shared_ptr<const MeshShape>> meshes;
  double build_seconds = 0;
};

BuiltScene build(const OctreeScene& scene, const Maker& maker, uint64_t* object_tests) {
  const auto octahedron = std::make_shared<const TriangleMesh>(to_triangles(diamond()));
  const auto mesh = std::make_shared<const TriangleMesh>(to_triangles(scene.mesh));
  BuiltScene built;
  const double start = thread_seconds();
  const auto mesh_shape = [&](const std::shared_ptr<const TriangleMesh>& triangles) {
    return built.meshes.emplace_back(std::make_shared<MeshShape>(triangles, maker.over(triangles)));
  };
  const auto place = [&](std::shared_ptr<const Shape> shape, const Affine& world_from_object) {
    if (object_tests) shape = std::make_shared<CountingShape>(std::move(shape), object_tests);
    Instance instance;
    instance.shape = std::move(shape);
    instance.world_from_object = Transform(world_from_object);
    built.instances.push_back(std::move(instance));
  };
  // Where they stand and without texture coordinates, as a scene file's spheres are built.
  for (const auto& [center, radius] : scene.spheres)
    place(std::make_shared<Sphere>(center, radius, false), Affine{});
  if (!scene.diamonds.empty()) {
    const auto shape = mesh_shape(octahedron);
    for (const auto& [center, radius] : scene.diamonds)
      place(shape, translation(center - Point3{}) * scaling({radius, radius, radius}));
  }
  if (!mesh->triangles.empty()) place(mesh_shape(mesh), Affine{});
  built.accelerator = maker.over(built.instances);
  built.build_seconds = thread_seconds() - start;
  return built;
}

struct View {
  Point3 eye;
  Vec3 forward, right, up;
  int width, height;

  View(const OctreeScene& scene, const OctreeBenchOptions& options)
      : eye(scene.eye), width(options.width), height(options.height) {
    const Affine camera = look_at(scene.eye, scene.target, {0, 1, 0});
    const double half = portable::tan(portable::radians(scene.field_of_view / 2));
    forward = camera(Vec3{0, 0, -1});
    up = camera(Vec3{0, half, 0});
    right = camera(Vec3{half, 0, 0});
  }
  /// Through the centre of the pixel.
  Ray ray(int x, int y) const {
    const double px = (2 * x + 1 - width) / double(height),
                 py = (height - 2 * y - 1) / double(height);
    return {eye, forward + right * px + up * py};
  }
};

/// What one pixel shows: ambient and diffuse light of two lights, told by its bits.
class Shader {
 public:
  Shader(const OctreeScene& scene, const View& view, const BuiltScene& built)
      : light_(scene.point_light), sun_(-view.forward), built_(built) {}

  double shade(const Ray& ray, TraversalCounters& counters) const {
    Hit hit;
    if (!built_.accelerator->closest_hit(ray, hit, counters)) return 0;
    SurfaceInteraction s = surface_at(built_.instances, ray, hit);
    if (dot(s.geometric_normal, ray.direction) > 0) s.geometric_normal = -s.geometric_normal;
    double value = 0.1;
    RayOrigins origins(s);
    const auto add = [&](const Ray& shadow) {
      const double facing = dot(s.geometric_normal, shadow.direction);
      const bool dark = built_.accelerator->any_hit(shadow, counters);
      if (!dark && facing > 0) value += facing / length(shadow.direction);
    };
    if (light_) add(origins.spawn_to(*light_));
    add(origins.spawn(sun_));
    return value;
  }

 private:
  std::optional<Point3> light_;
  Vec3 sun_;
  const BuiltScene& built_;
};

/// Tiles as the farm cuts them, pixel after pixel; `each(x, y)`.
template <typename Each>
void for_each_pixel(int width, int height, int step, const Each& each) {
  constexpr int kTile = 32;
  for (int ty = 0; ty < height; ty += kTile)
    for (int tx = 0; tx < width; tx += kTile)
      for (int y = ty; y < std::min(ty + kTile, height); y += step)
        for (int x = tx; x < std::min(tx + kTile, width); x += step) each(x, y);
}

constexpr int kSampleStep = 16;

double trace(const OctreeScene& scene, const OctreeBenchOptions& options, const BuiltScene& built,
             int step, std::vector<double>& picture, TraversalCounters& counters) {
  const View view(scene, options);
  const Shader shader(scene, view, built);
  picture.assign(static_cast<size_t>(options.width) * static_cast<size_t>(options.height), 0);
  const double start = thread_seconds();
  for_each_pixel(options.width, options.height, step, [&](int x, int y) {
    picture[static_cast<size_t>(y) * static_cast<size_t>(options.width) + static_cast<size_t>(x)] =
        shader.shade(view.ray(x, y), counters);
  });
  return thread_seconds() - start;
}

void describe(const BuiltScene& built, OctreeBenchRow& row) {
  const AcceleratorStatistics top = built.accelerator->statistics();
  row.depth = std::max(1, top.depth);
  row.voxels = std::max<size_t>(1, top.leaves);
  row.references = top.references;
  row.bytes = top.bytes;
  for (const auto& mesh : built.meshes) {
    const AcceleratorStatistics inner = mesh->accelerator().statistics();
    row.mesh_depth = std::max(row.mesh_depth, std::max(1, inner.depth));
    row.mesh_voxels += std::max<size_t>(1, inner.leaves);
    row.bytes += inner.bytes;
  }
}

size_t pixels_traced(const OctreeBenchOptions& options, int step) {
  size_t rays = 0;
  for_each_pixel(options.width, options.height, step, [&](int, int) { ++rays; });
  return rays;
}

int step_of(const OctreeBenchRow& row) { return row.sampled ? kSampleStep : 1; }

/// Builds and traces once more; the fastest counts.
void measure(const OctreeScene& scene, const OctreeBenchOptions& options, OctreeBenchRow& row,
             std::vector<double>& picture) {
  const double per_ray = 1 / static_cast<double>(pixels_traced(options, step_of(row)));
  const BuiltScene built = build(scene, Maker(row.accelerator), nullptr);
  TraversalCounters counters;
  const double seconds = trace(scene, options, built, step_of(row), picture, counters);
  const double scale = static_cast<double>(picture.size()) * per_ray;
  const auto keep_least = [](double& least, double value) {
    if (least == 0 || value < least) least = value;
  };
  keep_least(row.build_seconds, built.build_seconds);
  keep_least(row.trace_seconds, seconds * scale);
  row.seconds = row.build_seconds + row.trace_seconds;
  row.primitive_tests_per_ray = static_cast<double>(counters.primitive_tests) * per_ray;
  row.node_visits_per_ray = static_cast<double>(counters.node_visits) * per_ray;
  describe(built, row);
}

/// In a run of its own, as the counting costs time.
void count_object_tests(const OctreeScene& scene, const OctreeBenchOptions& options,
                        OctreeBenchRow& row) {
  uint64_t tests = 0;
  TraversalCounters ignored;
  std::vector<double> picture;
  trace(scene, options, build(scene, Maker(row.accelerator), &tests), step_of(row), picture,
        ignored);
  row.object_tests_per_ray =
      static_cast<double>(tests) / static_cast<double>(pixels_traced(options, step_of(row)));
}

size_t count_differing(const OctreeBenchOptions& options, int step, const std::vector<double>& a,
                       const std::vector<double>& b) {
  size_t count = 0;
  for_each_pixel(options.width, options.height, step, [&](int x, int y) {
    const auto at =
        static_cast<size_t>(y) * static_cast<size_t>(options.width) + static_cast<size_t>(x);
    if (std::bit_cast<uint64_t>(a[at]) != std::bit_cast<uint64_t>(b[at])) ++count;
  });
  return count;
}

std::optional<PublishedOctree> published(std::string_view scene, std::string_view accelerator) {
  struct Line {
    std::string_view scene;
    PublishedOctree uniform, nonuniform;
  };
  static constexpr std::array<Line, 5> kLines{{
      {"uniform-diamonds", {9, 8653, 10.53, 13.03, 10.379}, {6, 5552, 10.51, 12.88, 9.899}},
      {"random-diamonds", {9, 9381, 8.29, 22.24, 13.850}, {8, 7064, 5.42, 21.88, 12.533}},
      {"concentric-spheres", {8, 9178, 16.02, 12.35, 8.607}, {8, 8422, 12.00, 12.10, 8.382}},
      {"clumped-diamonds", {9, 22807, 2.87, 11.49, 21.539}, {9, 15401, 2.99, 10.24, 14.386}},
      {"teapot", {1, 1, 0.26, 0.14, 213.8}, {1, 1, 0.26, 0.14, 213.9}},
  }};
  for (const Line& line : kLines) {
    if (line.scene != scene) continue;
    if (accelerator == "octree") return line.uniform;
    if (accelerator.starts_with("nonuniform-octree")) return line.nonuniform;
  }
  return std::nullopt;
}

}  // namespace

std::vector<OctreeBenchRow> bench_octree(const OctreeScene& scene,
                                         const OctreeBenchOptions& options) {
  std::vector<OctreeBenchRow> rows;
  for (const std::string& name : options.accelerators) {
    OctreeBenchRow& row = rows.emplace_back();
    row.scene = scene.name;
    row.accelerator = name;
    row.sampled = Maker(name).scans();
    row.published = published(scene.name, name);
  }
  std::vector<double> first, picture;
  // In turn, so that a machine that slows down does so for all.
  for (int round = 0; round < std::max(1, options.rounds); ++round) {
    for (OctreeBenchRow& row : rows) {
      if (round > 0 && row.sampled) continue;
      measure(scene, options, row, picture);
      if (round > 0) continue;
      if (&row == &rows.front()) first = picture;
      const int step = std::max(step_of(row), step_of(rows.front()));
      row.differing_pixels = count_differing(options, step, first, picture);
    }
  }
  for (OctreeBenchRow& row : rows) count_object_tests(scene, options, row);
  return rows;
}

}  // namespace tessera
