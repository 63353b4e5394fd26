#include "renderer/integrator/views.h"

#include <optional>

#include "renderer/integrator/surface_point.h"

namespace tessera {

namespace {

struct FirstSurface {
  SurfacePoint point;
  double distance = 0;
};

std::optional<FirstSurface> first_surface(const Scene& scene, Ray ray, TraceState& state) {
  ++state.counters.rays_primary;
  double start = 0;
  Hit hit;
  for (uint32_t pass = 0; scene.surfaces && pass < kMaxPasses; ++pass) {
    if (!scene.surfaces->closest_hit(ray, hit, state.counters.traversal)) break;
    const SurfacePoint point = surface_point(scene, hit.instance, ray, hit);
    ++state.counters.hits;
    if (!point.is_hidden) return FirstSurface{point, start + hit.t};
    start += hit.t;
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
    hit = {};
  }
  return std::nullopt;
}

class NormalsView final : public Integrator {
 public:
  explicit NormalsView(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}
  Color radiance(const Ray& ray, const SampleKey&, TraceState& state) const override {
    const auto first = first_surface(*scene_, ray, state);
    if (!first) return kBlack;
    const Vec3& n = first->point.normal;
    return Color{n.x + 1, n.y + 1, n.z + 1} * 0.5;
  }
  Color background(const Ray&) const override { return kBlack; }

 private:
  std::shared_ptr<const Scene> scene_;
};

class DepthView final : public Integrator {
 public:
  explicit DepthView(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}
  Color radiance(const Ray& ray, const SampleKey&, TraceState& state) const override {
    const auto first = first_surface(*scene_, ray, state);
    return first ? kWhite * first->distance : kBlack;
  }
  Color background(const Ray&) const override { return kBlack; }

 private:
  std::shared_ptr<const Scene> scene_;
};

}  // namespace

std::unique_ptr<const Integrator> make_normals_view(std::shared_ptr<const Scene> scene) {
  return std::make_unique<NormalsView>(std::move(scene));
}

std::unique_ptr<const Integrator> make_depth_view(std::shared_ptr<const Scene> scene) {
  return std::make_unique<DepthView>(std::move(scene));
}

}  // namespace tessera
