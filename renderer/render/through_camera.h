#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "base/uninitialized.h"
#include "renderer/integrator/integrator.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// How many samples are taken before it is told that a pixel gets on: about a thousand rays through
/// the camera. With a thousandth of a second a ray, which is slow, that is once a second.
inline uint32_t samples_at_once(const Scene& scene) {
  constexpr uint32_t kRays = 1024;
  return std::max(1u, kRays / std::max(1u, scene.camera->lens_samples()));
}

/// What `look(ray, key)` sees along the sample's camera ray, or the mean over the lens; and whether
/// the filter is negative there.
template <typename Look>
auto through_camera(const Scene& scene, const SampleKey& key, const Look& look) {
  using Seen = decltype(look(Ray{}, key));
  const Sampler::RasterSample raster = scene.sampler->raster_sample(key.x, key.y, key.sample);
  const Vec2& at = raster.point;
  const uint32_t lens_samples = scene.camera->lens_samples();
  if (lens_samples == 0) {
    return std::pair<Seen, bool>(look(scene.camera->ray(at.x, at.y), key), raster.negative);
  }
  Seen sum{};
  for (uint32_t i = 0; i < lens_samples; ++i) {
    // A ray through the lens has numbers of its own, whatever else it draws.
    const SampleKey own{key.x, key.y, key.sample * lens_samples + i};
    const Vec2 u = scene.sampler->pair(own.x, own.y, own.sample, SampleUse::lens);
    sum += look(scene.camera->lens_ray(at.x, at.y, u), own);
  }
  return std::pair<Seen, bool>(sum * (1.0 / lens_samples), raster.negative);
}

/// The same of many samples, which look at `rasters`, at most kMost rays at once.
template <size_t kMost>
void through_camera(const Scene& scene, const Integrator& integrator,
                    std::span<const SampleKey> keys, std::span<const Sampler::RasterSample> rasters,
                    std::span<Color> found, TraceState& state) {
  const Camera& camera = *scene.camera;
  const uint32_t lens_samples = camera.lens_samples();
  if (lens_samples == 0) {
    integrator.radiances(camera, rasters, keys, found, state);
    return;
  }
  Uninitialized<Ray, kMost> rays;
  Uninitialized<SampleKey, kMost> of_rays;
  Uninitialized<size_t, kMost> of;  // the sample's place
  Uninitialized<Color, kMost> colors;
  size_t count = 0;
  const auto trace = [&] {
    integrator.radiances({rays.data(), count}, {of_rays.data(), count}, {colors.data(), count},
                         state);
    for (size_t ray = 0; ray < count; ++ray) found[of[ray]] += colors[ray];
    count = 0;
  };
  std::ranges::fill(found, kBlack);
  for (size_t i = 0; i < keys.size(); ++i) {
    const auto& [x, y, sample] = keys[i];
    const Vec2& at = rasters[i].point;
    for (uint32_t ray = 0; ray < lens_samples; ++ray) {
      const uint32_t own = sample * lens_samples + ray;
      of[count] = i;
      of_rays[count] = {x, y, own};
      const Vec2 u = scene.sampler->pair(x, y, own, SampleUse::lens);
      rays[count++] = camera.lens_ray(at.x, at.y, u);
      if (count == kMost) trace();
    }
  }
  if (count > 0) trace();
  for (Color& color : found) color = color * (1.0 / lens_samples);
}

}  // namespace tessera
