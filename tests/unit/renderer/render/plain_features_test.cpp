#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

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

struct Feature {
  const char *material, *light, *rest;
  bool plain = false;
};

// The variant that asks a hit for nothing is taken where that gives the same bits, and only there.
TEST(PlainFeatures, keep_the_bits_and_are_told_from_others) {
  for (const Feature& feature : {
           Feature{"classic { }", "", "", true},
           Feature{"classic { specular { value { r: .5 g: .5 b: .5 } } }", "", "", true},
           Feature{"classic { }", "ambient_intensity: .3", "", true},
           Feature{"classic { grain: .5 }", "", ""},
           Feature{"classic { flat: true }", "", ""},
           Feature{"sides: FRONT_ONLY classic { }", "", ""},
           Feature{"classic { diffuse_model: HALF_LAMBERT }", "", ""},
           Feature{"unlit { color { value { r: .5 } } }", "", ""},
           Feature{"classic { reflectivity { value { r: .5 } } }", "", ""},
           Feature{"classic { transparency { value: .5 } }", "", ""},
           Feature{"classic { }", "shadow_intensity: .5", ""},
           Feature{"classic { }", "shadow_distance: .6", ""},
           Feature{"classic { }", "ambient_intensity: .3 ambient_attenuated: true", ""},
           Feature{"classic { }", "", "fog { visibility_range: 9 }"},
       }) {
    const v1::Scene scene = parse_scene(scene_with(feature.material, feature.light, feature.rest));
    const PixelRect rect{0, 0, 24, 18};
    const auto picture = [&](const Skips& skips, uint64_t& absent) {
      const auto renderer = make_tile_renderer(scene, {}, frame_of(24, 18), 1, {}, skips);
      absent = renderer->build_counters().at("features_absent");
      return render_rect(*renderer, rect).values;
    };
    uint64_t absent = 0, without = 0, hit_switch_off = 0;
    const auto values = picture({}, absent);
    EXPECT_EQ(values, picture({.absent_features = false}, without)) << feature.material;
    EXPECT_EQ(values, picture({.dark_shadow_rays = false}, hit_switch_off)) << feature.material;
    // A switch that a hit would meet takes it back, and nothing else.
    EXPECT_EQ(absent - hit_switch_off, feature.plain ? 1u : 0u)
        << feature.material << feature.light << feature.rest;
    EXPECT_EQ(without, 0u);
  }
}

uint64_t count_of(const TilePixels& tile, const std::string& name) {
  const auto at = tile.counters.find(name);
  return at == tile.counters.end() ? 0 : at->second;
}

// The variant that follows a mirrored ray without a stack gives the bits, and the counts, of that
// which asks for all.
TEST(SimpleFeatures, keep_bits_and_counts) {
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
        const PixelRect rect{0, 0, 24, 18};
        const auto tile = [&](const Skips& skips) {
          const auto renderer = make_tile_renderer(scene, {}, frame_of(24, 18), 1, {}, skips);
          return render_rect(*renderer, rect);
        };
        const TilePixels simple = tile({}), full = tile({.absent_features = false});
        EXPECT_EQ(simple.values, full.values) << material << light << depth;
        for (const char* count : {"rays_primary", "rays_shadow", "rays_reflection", "hits",
                                  "shadow_rays_skipped", "branches_skipped", "samples"}) {
          EXPECT_EQ(count_of(simple, count), count_of(full, count))
              << count << ": " << material << light << depth;
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera
