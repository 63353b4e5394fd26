#include "renderer/scene/light_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scenes/generate/random.h"

namespace tessera {
namespace {

/// Lamps of many reaches, some of them endless, in frames of many scales.
std::vector<Light> lamps(size_t count, double spread) {
  Random random(count);
  std::vector<Light> lights(count);
  for (Light& light : lights) {
    light.kind = random.uniform() < .5 ? LightKind::point : LightKind::spot;
    light.position = Point3{} + random.in_cube() * spread;
    light.cut_off = 1;
    light.frame_scale = .5 + random.uniform();
    light.radius = random.uniform() < .1 ? Bounds3::kInfinity : random.uniform();
    light.ambient = random.uniform() < .1 ? kWhite : kBlack;
    light.ambient_attenuated = random.uniform() < .5;
    set_spot_cosines(light);
  }
  return lights;
}

std::vector<uint32_t> every(size_t count) {
  std::vector<uint32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

TEST(LightGrid, leaves_out_only_lights_that_give_nothing) {
  size_t left_out = 0;
  for (const double spread : {1e-3, 1.0, 10.0, 1e6}) {
    for (const size_t count : {5u, 40u, 700u}) {
      const std::vector<Light> lights = lamps(count, spread);
      const LightGrid reach(lights, every(count));
      Random random(7);
      for (int i = 0; i < 2000; ++i) {
        // Half of them on the very edge of some light's reach.
        Point3 p = Point3{} + random.in_cube() * (1.1 * spread + 1);
        const Light& light = lights[random.bits() % count];
        if (i % 2 == 0 && std::isfinite(light.radius))
          p = light.position + normalize(random.in_cube()) * (light.radius / light.frame_scale);
        const auto found = reach.at(p);
        ASSERT_TRUE(std::is_sorted(found.begin(), found.end()));
        for (uint32_t k = 0; k < count; ++k) {
          if (std::binary_search(found.begin(), found.end(), k)) continue;
          ++left_out;
          LightSample sample;
          ASSERT_FALSE(sample_light(lights[k], p, 0, sample)) << spread << " " << count;
          ASSERT_TRUE(lights[k].ambient_attenuated || is_black(lights[k].ambient));
        }
      }
    }
  }
  EXPECT_GT(left_out, 1'000'000u);
}

TEST(LightGrid, keeps_all_where_it_is_not_worth_it) {
  const std::vector<Light> lights = lamps(100, 10);
  const Point3 far{1e9, 0, 0};
  EXPECT_EQ(LightGrid(lights, every(2)).at(far).size(), 2u);
  const LightGrid reach(lights, every(100));
  EXPECT_LT(reach.at(far).size(), 50u);
  EXPECT_EQ(reach.at({std::nan(""), 0, 0}).size(), 100u);
}

}  // namespace
}  // namespace tessera
