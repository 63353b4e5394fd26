#include "renderer/integrator/views.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/accel/mesh_shape.h"
#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/surface_point.h"

namespace tessera {

namespace {

/// Calls use(point, distance in metres, hit) for the first surface that is there, if there is one.
/// What covers less than half of what is behind it is passed by.
template <typename Use>
void use_first_surface(const Scene& scene, Ray ray, TraceState& state, const Use& use) {
  ++state.counters.rays_primary;
  double start = 0;
  for (uint32_t pass = 0; scene.surfaces && pass < kMaxPasses; ++pass) {
    Hit hit;
    if (!scene.surfaces->closest_hit(ray, hit, state.counters.traversal)) break;
    SurfacePoint point(scene, hit.instance, ray, hit);
    look_up_textures(scene, ray, cone_width(state.cone, start + hit.t), point, state.counters);
    ++state.counters.hits;
    start += hit.t;
    if (!point.is_hidden && point.surface.vertex_alpha * point.material->alpha >= 0.5) {
      return use(point, start, hit);
    }
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
  }
}

/// The first surface, as a camera's ray sees it.
struct Seen {
  const Scene& scene;
  const Ray& ray;
  const SurfacePoint& point;
  double distance;  ///< metres along the ray
  const Hit& hit;
};

/// Shows of the first surface what `Show` makes of it.
template <typename Show>
class FirstSurfaceView final : public Integrator {
 public:
  explicit FirstSurfaceView(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}
  Color radiance(const Ray& ray, const SampleKey&, TraceState& state) const override {
    Color color = kBlack;
    use_first_surface(*scene_, ray, state,
                      [&](const SurfacePoint& point, double distance, const Hit& hit) {
                        color = Show()({*scene_, ray, point, distance, hit});
                      });
    return color;
  }
  Color background(const Ray&) const override { return kBlack; }

 private:
  std::shared_ptr<const Scene> scene_;
};

struct ShowNormal {
  Color operator()(const Seen& seen) const {
    const Vec3& n = seen.point.normal;
    return Color{n.x + 1, n.y + 1, n.z + 1} * 0.5;
  }
};

struct ShowDepth {
  Color operator()(const Seen& seen) const { return kWhite * seen.distance; }
};

Color albedo_of(const SurfacePoint& point) {
  return albedo(*point.material, surface_diffuse(point));
}
struct ShowAlbedo {
  Color operator()(const Seen& seen) const { return albedo_of(seen.point); }
};

/// Colours that tell neighbours apart, by a hash of the number (SplitMix64's finalizer).
struct ShowId {
  Color operator()(const Seen& seen) const {
    const SurfaceInteraction& surface = seen.point.surface;
    uint64_t v = (uint64_t{surface.instance} << 32 | surface.material) + 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    v ^= v >> 31;
    const auto level = [&](int shift) { return 0.1 + 0.9 * ((v >> shift) & 0xff) / 255.0; };
    return {level(0), level(8), level(16)};
  }
};

/// Edges of triangles as dark lines on grey, which is the brighter the more a surface faces the
/// viewer.
struct ShowWireframe {
  static constexpr double kHalfLine = 0.6;  ///< pixels
  static constexpr double kLine = 0.02, kSteepest = 0.2, kFacing = 0.6;

  Color operator()(const Seen& seen) const {
    if (is_at_edge(seen)) return kWhite * kLine;
    const double facing = std::min(std::abs(dot(seen.point.normal, seen.ray.direction)), 1.0);
    return kWhite * (kSteepest + (kFacing - kSteepest) * facing);
  }

 private:
  static bool is_at_edge(const Seen& seen) {
    const Instance& instance = seen.scene.instances[seen.hit.instance];
    const auto* mesh = dynamic_cast<const MeshShape*>(instance.shape.get());
    if (!mesh) return false;
    const double width = cone_width(seen.scene.camera->pixel_cone(), seen.distance);
    std::array<Point3, 3> corners = mesh->mesh().corners(seen.hit.primitive);
    for (Point3& corner : corners) corner = instance.world_from_object.point(corner);
    for (size_t i = 0; i < 3; ++i) {
      // From the point seen to the nearest one of the edge, across the ray.
      const Vec3 edge = corners[(i + 1) % 3] - corners[i];
      const Vec3 from = seen.point.surface.point - corners[i];
      const double along = std::clamp(dot(from, edge) / length_squared(edge), 0.0, 1.0);
      const Vec3 off = edge * along - from;
      const Vec3 across = off - seen.ray.direction * dot(off, seen.ray.direction);
      if (length(across) < kHalfLine * width) return true;
    }
    return false;
  }
};

/// The work of another integrator instead of what it sees.
class CostView final : public Integrator {
 public:
  explicit CostView(std::unique_ptr<const Integrator> inner) : inner_(std::move(inner)) {}
  Color radiance(const Ray& ray, const SampleKey& key, TraceState& state) const override {
    const TraversalCounters& counters = state.counters.traversal;
    const uint64_t before = counters.node_visits + counters.primitive_tests;
    state.last_occluders = {};  // lest the picture depend on what was traced before
    inner_->radiance(ray, key, state);
    return kWhite * static_cast<double>(counters.node_visits + counters.primitive_tests - before);
  }
  Color background(const Ray&) const override { return kBlack; }

 private:
  std::unique_ptr<const Integrator> inner_;
};

}  // namespace

std::optional<FirstSurface> first_surface(const Scene& scene, const Ray& ray, TraceState& state) {
  std::optional<FirstSurface> first;
  use_first_surface(scene, ray, state,
                    [&](const SurfacePoint& point, double distance, const Hit& hit) {
                      first = {.albedo = albedo_of(point),
                               .normal = point.normal,
                               .depth = distance,
                               .position = point.surface.point,
                               .instance = point.surface.instance,
                               .primitive = hit.primitive};
                    });
  return first;
}

std::unique_ptr<const Integrator> make_surface_view(std::shared_ptr<const Scene> scene, View view) {
  switch (view) {
    case View::normals:
      return std::make_unique<FirstSurfaceView<ShowNormal>>(std::move(scene));
    case View::depth:
      return std::make_unique<FirstSurfaceView<ShowDepth>>(std::move(scene));
    case View::albedo:
      return std::make_unique<FirstSurfaceView<ShowAlbedo>>(std::move(scene));
    case View::ids:
      return std::make_unique<FirstSurfaceView<ShowId>>(std::move(scene));
    case View::wireframe:
      return std::make_unique<FirstSurfaceView<ShowWireframe>>(std::move(scene));
    case View::none:
    case View::cost:
    case View::samples:
    case View::error:
      break;
  }
  return nullptr;
}

std::unique_ptr<const Integrator> make_cost_view(std::unique_ptr<const Integrator> inner) {
  return std::make_unique<CostView>(std::move(inner));
}

}  // namespace tessera
