#include "renderer/integrator/views.h"

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/surface_point.h"

namespace tessera {

namespace {

/// Calls use(point, distance in metres) for the first surface that is there, if there is one. What
/// covers less than half of what is behind it is passed by.
template <typename Use>
void use_first_surface(const Scene& scene, Ray ray, TraceState& state, const Use& use) {
  ++state.counters.rays_primary;
  double start = 0;
  for (uint32_t pass = 0; scene.surfaces && pass < kMaxPasses; ++pass) {
    Hit hit;
    if (!scene.surfaces->closest_hit(ray, hit, state.counters.traversal)) break;
    SurfacePoint point(scene, hit.instance, ray, hit);
    look_up_textures(scene, ray, cone_width(scene, start + hit.t), point);
    ++state.counters.hits;
    start += hit.t;
    if (!point.is_hidden && point.surface.vertex_alpha * point.material->alpha >= 0.5) {
      return use(point, start);
    }
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
  }
}

class NormalsView final : public Integrator {
 public:
  explicit NormalsView(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}
  Color radiance(const Ray& ray, const SampleKey&, TraceState& state) const override {
    Color color = kBlack;
    use_first_surface(*scene_, ray, state, [&](const SurfacePoint& point, double) {
      color = Color{point.normal.x + 1, point.normal.y + 1, point.normal.z + 1} * 0.5;
    });
    return color;
  }
  Color background(const Ray&) const override { return kBlack; }

 private:
  std::shared_ptr<const Scene> scene_;
};

class DepthView final : public Integrator {
 public:
  explicit DepthView(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}
  Color radiance(const Ray& ray, const SampleKey&, TraceState& state) const override {
    Color color = kBlack;
    use_first_surface(*scene_, ray, state,
                      [&](const SurfacePoint&, double distance) { color = kWhite * distance; });
    return color;
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
