#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/whitted_surfaces.h"
#include "renderer/scene/scene_builder.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

/// A ball's shadow on a floor, with more in the material, the light and the scene.
std::string scene_with(const std::string& material, const std::string& light,
                       const std::string& rest) {
  return fmt::format(
      "cameras {{ world_from_camera {{ steps {{ look_at {{ eye {{ x: 1 y: 2 z: 4 }} }} }} }} }} "
      "materials {{ name: 'm' {} }} "
      "nodes {{ light {{ directional {{ direction {{ x: -1 y: -2 z: -.5 }} }} {} }} }} "
      "nodes {{ shape {{ materials: 'm' sphere {{ center {{ y: .5 }} radius: .7 }} }} }} "
      "nodes {{ shape {{ materials: 'm' plane {{ offset: -.5 }} }} }} {}",
      material, light, rest);
}

constexpr int kWidth = 24, kHeight = 18;

/// A sample of each pixel, in batches where the integrator takes them.
std::vector<Color> traced(const std::shared_ptr<const Scene>& scene, TraceState& state) {
  const auto integrator = make_integrator(scene);
  std::vector<Ray> rays;
  std::vector<SampleKey> keys;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      rays.push_back(scene->camera->ray(x + .5, y + .5));
      keys.push_back({x, y, 0});
    }
  }
  std::vector<Color> colors(rays.size());
  for (size_t i = 0; i < rays.size(); i += RayBatch::kMost) {
    const size_t n = std::min(RayBatch::kMost, rays.size() - i);
    integrator->radiances({&rays[i], n}, {&keys[i], n}, {&colors[i], n}, state);
  }
  return colors;
}

std::vector<uint64_t> counts_of(const TraceCounters& c) {
  return {c.rays_primary,        c.rays_shadow,      c.rays_reflection, c.hits,
          c.shadow_rays_skipped, c.branches_skipped, c.samples};
}

struct Feature {
  const char *material, *light, *rest;
  bool is_simple;
};

// Scenes of simple features are told from others, and have the bits that they have among those.
TEST(SimpleFeatures, KeepTheBitsAndAreToldFromOthers) {
  for (const Feature& feature : {
           Feature{"classic { }", "", "", true},
           Feature{"classic { specular { value { r: .5 g: .5 b: .5 } } }", "", "", true},
           Feature{"classic { }", "ambient_intensity: .3", "", true},
           Feature{"sides: FRONT_ONLY classic { }", "", "", false},
           Feature{"classic { diffuse_model: HALF_LAMBERT }", "", "", true},
           Feature{"classic { reflectivity { value { r: .5 } } }", "", "", true},
           Feature{"classic { }", "shadow_distance: .6", "", true},
           Feature{"classic { grain: .5 }", "", "", false},
           Feature{"classic { flat: true }", "", "", false},
           Feature{"unlit { color { value { r: .5 } } }", "", "", false},
           Feature{"classic { transparency { value: .5 } }", "", "", false},
           Feature{"classic { }", "shadow_intensity: .5", "", false},
           Feature{"classic { }", "ambient_intensity: .3 ambient_attenuated: true", "", false},
           Feature{"classic { }", "", "fog { visibility_range: 9 }", false},
       }) {
    const v1::Scene scene = parse_scene(scene_with(feature.material, feature.light, feature.rest));
    const auto chosen = build_scene(scene, {}, frame_of(kWidth, kHeight), 1);
    EXPECT_EQ(WhittedSurfaces(*chosen).are_simple(), feature.is_simple)
        << feature.material << feature.light << feature.rest;
    const auto full = with_every_feature(build_scene(scene, {}, frame_of(kWidth, kHeight), 1));
    TraceState state, full_state;
    EXPECT_EQ(traced(chosen, state), traced(full, full_state)) << feature.material;
  }
}

TEST(SimpleFeatures, KeepBitsAndCountsOfMirrors) {
  const char* const mirror = "reflectivity { value { r: .5 g: .7 b: .6 } }";
  const std::string wall =
      "nodes { shape { materials: 'm' plane { normal { x: 1 } offset: -2 } } } "
      "materials { name: 'front' sides: FRONT_ONLY classic { diffuse_model: SIGNED } } "
      "nodes { shape { materials: 'front' plane { normal { z: 1 } offset: -2 } } } ";
  for (const std::string& material : {
           fmt::format("classic {{ {} }}", mirror),
           fmt::format("classic {{ {} diffuse_model: SIGNED }}", mirror),
           fmt::format("classic {{ {} diffuse_model: HALF_LAMBERT }}", mirror),
           fmt::format("sides: FRONT_ONLY classic {{ {} }}", mirror),
           std::string("classic { diffuse_model: SIGNED }"),
           std::string("classic { reflectivity { value { r: 1e-6 } } }"),
       }) {
    for (const char* light : {"", "shadow_distance: .6", "ambient_intensity: .3"}) {
      for (const char* depth :
           {"max_depth: 0", "max_depth: 1 background_at_max_depth: true", "max_depth: 9"}) {
        const std::string settings = fmt::format(
            "settings {{ integrator {{ {} }} }} "
            "background {{ solid {{ r: .2 g: .3 b: .4 }} }}",
            depth);
        const v1::Scene scene = parse_scene(scene_with(material, light, wall + settings));
        TraceState state, full_state;
        const auto colors = traced(build_scene(scene, {}, frame_of(kWidth, kHeight), 1), state);
        const auto full = with_every_feature(build_scene(scene, {}, frame_of(kWidth, kHeight), 1));
        EXPECT_EQ(colors, traced(full, full_state)) << material << light << depth;
        EXPECT_EQ(counts_of(state.counters), counts_of(full_state.counters))
            << material << light << depth;
      }
    }
  }
}

}  // namespace
}  // namespace tessera
