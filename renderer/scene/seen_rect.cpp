#include "renderer/scene/seen_rect.h"

#include <algorithm>
#include <cmath>

#include "renderer/scene/scene.h"

namespace tessera {

/// The pixels that the corners of the scene's box span, for the box is convex. The margin of a
/// pixel is far above the rounding errors of projecting and of tracing.
PixelRect seen_rect(const Scene& scene) {
  const RenderSettings& settings = scene.settings;
  const PixelRect frame{0, 0, settings.width, settings.height};
  if (!scene.surfaces) return {};
  if (scene.camera->lens_samples() > 0) return frame;  // what is out of focus spreads
  const Bounds3 box = scene.surfaces->bounds();
  Vec2 low{1e30, 1e30}, high{-1e30, -1e30};
  for (int corner = 0; corner < 8; ++corner) {
    const auto raster = scene.camera->raster_of({corner & 1 ? box.max.x : box.min.x,
                                                 corner & 2 ? box.max.y : box.min.y,
                                                 corner & 4 ? box.max.z : box.min.z});
    if (!raster || !std::isfinite(raster->x) || !std::isfinite(raster->y)) return frame;
    low = {std::min(low.x, raster->x), std::min(low.y, raster->y)};
    high = {std::max(high.x, raster->x), std::max(high.y, raster->y)};
  }
  const double margin = 1 + settings.sampler.filter_radius;
  const auto inside = [](double v, int side) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(side)));
  };
  return {
      inside(std::floor(low.x - margin), frame.x1), inside(std::floor(low.y - margin), frame.y1),
      inside(std::ceil(high.x + margin), frame.x1), inside(std::ceil(high.y + margin), frame.y1)};
}

}  // namespace tessera
