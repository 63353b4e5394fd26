#include "renderer/render/aov_tracer.h"

#include <cmath>
#include <optional>

#include "renderer/accel/mesh_shape.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/integrator/views.h"
#include "renderer/render/through_camera.h"

namespace tessera {

namespace {

/// What is averaged over rays; a normal's axes as a colour's channels.
struct Averaged {
  Color albedo, normal;
  Averaged& operator+=(const Averaged& o) {
    albedo += o.albedo;
    normal += o.normal;
    return *this;
  }
  Averaged operator*(double s) const { return {albedo * s, normal * s}; }
};

/// Appends numbers to a pixel.
class Channels {
 public:
  explicit Channels(float* out) : out_(out) {}
  void put(double value) {
    const auto channel = static_cast<float>(value);
    *out_++ = std::isfinite(channel) ? channel : 0;
  }
  void put(const Color& c) { put(c.r), put(c.g), put(c.b); }

 private:
  float* out_;
};

/// As the description has it, of whose meshes some triangles may have been left out.
uint32_t primitive_of(const Scene& scene, const FirstSurface& surface) {
  const Shape* const shape = scene.instances[surface.instance].shape.get();
  const auto* const mesh = dynamic_cast<const MeshShape*>(shape);
  if (!mesh || mesh->mesh().original_numbers.empty()) return surface.primitive;
  return mesh->mesh().original_numbers[surface.primitive];
}

}  // namespace

struct AovTracer::Surfaces {
  Color albedo, normal;               ///< means over the samples
  std::optional<FirstSurface> first;  ///< along the first ray
};

AovTracer::AovTracer(std::shared_ptr<const Scene> scene)
    : scene_(std::move(scene)), aovs_(scene_->settings.aovs) {
  if (aovs_.has(Aov::alpha)) at_camera_ = media_at_camera(*scene_);
}

AovTracer::Surfaces AovTracer::surfaces_of(int x, int y, uint32_t first_sample, uint32_t count,
                                           TraceState& state, TileProgress& progress) const {
  const uint32_t at_once = samples_at_once(*scene_);
  Surfaces surfaces;
  const double gain = scene_->sampler->filter_gain();
  SampleSum albedo(gain), normal(gain);
  bool is_first = true;
  for (uint32_t i = 0; i < count; ++i) {
    const SampleKey key{x, y, first_sample + i};
    state.cone = scene_->cones.of(key.sample);
    const auto [mean, negative] =
        through_camera(*scene_, key, [&](const Ray& ray, const SampleKey&) {
          const auto surface = first_surface(*scene_, ray, state);
          if (is_first) surfaces.first = surface;
          is_first = false;
          if (!surface) return Averaged{};
          const Vec3& n = surface->normal;
          return Averaged{surface->albedo, {n.x, n.y, n.z}};
        });
    albedo.add({mean.albedo, negative});
    normal.add({mean.normal, negative});
    if ((i + 1) % at_once == 0 && !progress.go_on()) break;
  }
  surfaces.albedo = albedo.mean();
  surfaces.normal = normal.mean();
  return surfaces;
}

DirectBackground AovTracer::background_of(int x, int y, uint32_t first_sample, uint32_t count,
                                          TraceState& state, TileProgress& progress) const {
  const uint32_t at_once = samples_at_once(*scene_);
  const double gain = scene_->sampler->filter_gain();
  SampleSum share(gain), light(gain);
  for (uint32_t i = 0; i < count; ++i) {
    const SampleKey key{x, y, first_sample + i};
    state.cone = scene_->cones.of(key.sample);
    const auto [mean, negative] =
        through_camera(*scene_, key, [&](const Ray& ray, const SampleKey& own) {
          return direct_background(*scene_, at_camera_, ray, own, state);
        });
    share.add({mean.share, negative});
    light.add({is_representable(mean.light) ? mean.light : kBlack, negative});
    if ((i + 1) % at_once == 0 && !progress.go_on()) break;
  }
  return {share.mean(), light.mean()};
}

void AovTracer::write(int x, int y, uint32_t first_sample, bool seen, const SampleSum& light,
                      double alpha, TraceState& state, TileProgress& progress, float* out) const {
  Surfaces surfaces;
  if (seen && aovs_.needs_surfaces()) {
    const bool averages = aovs_.has(Aov::albedo) || aovs_.has(Aov::normal);
    surfaces = surfaces_of(x, y, first_sample, averages ? light.count() : 1, state, progress);
  }
  const FirstSurface nothing{};
  const FirstSurface& first = surfaces.first ? *surfaces.first : nothing;
  Channels channels(out);
  if (aovs_.has(Aov::albedo)) channels.put(surfaces.albedo);
  if (aovs_.has(Aov::normal)) channels.put(surfaces.normal);
  if (aovs_.has(Aov::depth)) channels.put(first.depth);
  if (aovs_.has(Aov::position)) {
    channels.put(Color{first.position.x, first.position.y, first.position.z});
  }
  if (aovs_.has(Aov::id)) channels.put(surfaces.first ? first.instance + 1.0 : 0);
  if (aovs_.has(Aov::variance)) channels.put(light.variance());
  if (aovs_.has(Aov::samples)) channels.put(light.count());
  if (aovs_.has(Aov::origin)) {
    const Origins::Chain chain =
        surfaces.first ? scene_->origins->of(first.instance, first.primitive) : Origins::Chain{};
    for (const uint32_t node : chain) channels.put(node);
  }
  if (aovs_.has(Aov::primitive))
    channels.put(surfaces.first ? primitive_of(*scene_, first) + 1.0 : 0);
  if (aovs_.has(Aov::alpha)) channels.put(alpha);
}

}  // namespace tessera
