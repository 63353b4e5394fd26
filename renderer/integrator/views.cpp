#include "renderer/integrator/views.h"

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/surface_point.h"

namespace tessera {

namespace {

/// Finds the first surface that is there at all; false where there is none. Sets the distance in
/// metres. What covers less than half of what is behind it is passed by.
bool find_first_surface(const Scene& scene, Ray ray, TraceState& state, SurfacePoint& point,
                        double& distance) {
  ++state.counters.rays_primary;
  double start = 0;
  for (uint32_t pass = 0; scene.surfaces && pass < kMaxPasses; ++pass) {
    Hit hit;
    if (!scene.surfaces->closest_hit(ray, hit, state.counters.traversal)) break;
    find_surface_point<true>(scene, hit.instance, ray, hit, cone_width(scene, start + hit.t),
                             point);
    ++state.counters.hits;
    distance = start + hit.t;
    const bool is_there = point.surface.vertex_alpha * point.material->alpha >= 0.5;
    if (!point.is_hidden && is_there) return true;
    start += hit.t;
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
  }
  return false;
}

class NormalsView final : public Integrator {
 public:
  explicit NormalsView(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}
  Color radiance(const Ray& ray, const SampleKey&, TraceState& state) const override {
    SurfacePoint point;
    double distance;
    if (!find_first_surface(*scene_, ray, state, point, distance)) return kBlack;
    const Vec3& n = point.normal;
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
    SurfacePoint point;
    double distance;
    return find_first_surface(*scene_, ray, state, point, distance) ? kWhite * distance : kBlack;
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
