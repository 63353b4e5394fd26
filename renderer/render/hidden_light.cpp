#include "renderer/render/hidden_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "renderer/accel/accelerator.h"
#include "renderer/film/block.h"
#include "renderer/math/elementary.h"
#include "renderer/render/tile_state.h"

namespace tessera {

namespace {

/// One block in 32 is looked at, but no fewer and no more than these.
constexpr int kLookedAt = 32, kLeastLookedAt = 32, kMostLookedAt = 256;

double sum_of_squares(const Color& c) { return c.r * c.r + c.g * c.g + c.b * c.b; }

/// What one sample alone met: the square of what it differs by from the mean of the others, where
/// that is more than those differ by from it, all together. A mean over the three channels.
std::optional<double> met_once(const std::vector<Color>& samples) {
  Color sum = kBlack;
  for (const Color& sample : samples) sum += sample;
  const Color mean = sum * (1.0 / static_cast<double>(samples.size()));
  const auto away = [&mean](const Color& c) { return sum_of_squares(c - mean); };
  const Color rarest =
      *std::max_element(samples.begin(), samples.end(),
                        [&away](const Color& a, const Color& b) { return away(a) < away(b); });
  const Color others = (sum - rarest) * (1.0 / static_cast<double>(samples.size() - 1));
  double rest = 0;
  for (const Color& sample : samples) rest += sum_of_squares(sample - others);
  const double square = sum_of_squares(rarest - others);
  rest -= square;
  if (!(square > rest)) return std::nullopt;
  return square / 3;
}

double brightest_emission(const Scene& scene, uint32_t instance) {
  double most = 0;
  for (uint32_t slot = 0; slot < scene.shading[instance].material_count; ++slot)
    most = std::max(most, max_component(scene.material(instance, slot).emission));
  return most;
}

}  // namespace

HiddenLight::HiddenLight(const Scene& scene, const SampleTracer& tracer)
    : blocks_across_((scene.settings.width + kBlockSide - 1) / kBlockSide) {
  look_at_blocks(scene, tracer);
  find_specks(scene);
}

int HiddenLight::block_of(int x, int y) const {
  return y / kBlockSide * blocks_across_ + x / kBlockSide;
}

void HiddenLight::look_at_blocks(const Scene& scene, const SampleTracer& tracer) {
  const int width = scene.settings.width, height = scene.settings.height;
  const int all = blocks_across_ * ((height + kBlockSide - 1) / kBlockSide);
  const int count = std::min(all, std::clamp(all / kLookedAt, kLeastLookedAt, kMostLookedAt));
  std::vector<Color> samples;
  TraceState uncounted;
  for (int i = 0; i < count; ++i) {
    // Evenly, along no line of the picture: by the golden ratio.
    const auto turn = static_cast<uint32_t>(i) * 0x9E3779B9u;
    const auto block = static_cast<int>(uint64_t{turn} * static_cast<uint64_t>(all) >> 32);
    const int x0 = block % blocks_across_ * kBlockSide, y0 = block / blocks_across_ * kBlockSide;
    samples.clear();
    for (int y = y0; y < std::min(y0 + kBlockSide, height); ++y) {
      for (int x = x0; x < std::min(x0 + kBlockSide, width); ++x) {
        const bool seen = is_seen(scene, x, y);
        if (!seen && scene.background.is_constant()) continue;
        for (uint32_t sample = 0; sample < scene.settings.first_look(); ++sample)
          samples.push_back(
              tracer.find({x, y, sample}, uncounted, SampleTracer::way_of(seen)).color);
      }
    }
    if (samples.size() < 2) continue;
    if (const auto square = met_once(samples))
      rare_.push_back(*square);
    else
      ++met_nothing_;
  }
}

void HiddenLight::find_specks(const Scene& scene) {
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const double radiance = brightest_emission(scene, i);
    if (!(radiance > 0)) continue;
    const Instance& instance = scene.instances[i];
    const Bounds3 box = instance.world_from_object.bounds(instance.shape->bounds());
    Vec2 low{1e30, 1e30}, high{-1e30, -1e30};
    bool is_before_camera = true;
    for (int corner = 0; corner < 8; ++corner) {
      const auto raster = scene.camera->raster_of({corner & 1 ? box.max.x : box.min.x,
                                                   corner & 2 ? box.max.y : box.min.y,
                                                   corner & 4 ? box.max.z : box.min.z});
      is_before_camera = raster.has_value();
      if (!raster) break;
      low = {std::min(low.x, raster->x), std::min(low.y, raster->y)};
      high = {std::max(high.x, raster->x), std::max(high.y, raster->y)};
    }
    if (!is_before_camera) continue;
    const double pixels = (high.x - low.x) * (high.y - low.y) * std::numbers::pi / 4;
    const Vec2 center{(low.x + high.x) / 2, (low.y + high.y) / 2};
    const bool in_frame = center.x >= 0 && center.y >= 0 && center.x < scene.settings.width &&
                          center.y < scene.settings.height;
    if (!(pixels < 1) || !in_frame) continue;
    Hit hit;
    TraversalCounters uncounted;
    const Ray ray = scene.camera->ray(center.x, center.y);
    if (!scene.surfaces->closest_hit(ray, hit, uncounted) || hit.instance != i) continue;
    specks_.push_back(
        {block_of(static_cast<int>(center.x), static_cast<int>(center.y)), pixels, radiance});
  }
  std::ranges::sort(specks_, {}, &Speck::block);
}

double HiddenLight::square_error(int x, int y, int pixels, uint32_t samples) const {
  const double n = samples;
  double error = 0;
  // What one sample of n met is an n-th of it in the pixel, which counts as white at most.
  for (const double square : rare_)
    error += std::min(square / (n * n), 1.0) / std::max(1.0, met_nothing_);
  const int block = block_of(x, y);
  auto speck = std::ranges::lower_bound(specks_, block, {}, &Speck::block);
  for (; speck != specks_.end() && speck->block == block; ++speck) {
    const double light = std::min(1.0, speck->radiance * speck->pixels);
    error += portable::exp(-speck->pixels * n) * light * light;
  }
  return error / pixels;
}

}  // namespace tessera
