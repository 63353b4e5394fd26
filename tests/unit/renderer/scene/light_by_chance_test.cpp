#include "renderer/scene/light_by_chance.h"

#include <gtest/gtest.h>

#include <string>

#include "renderer/scene/scene_builder.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

constexpr char kLamp[] =
    "materials { name: 'lamp' classic { emission { value { r: 3 g: 20 b: 5 } } } } "
    "nodes { shape { materials: 'lamp' sphere { center { y: 3 } } } } ";
constexpr char kSun[] = "background { sun_and_sky { sun_direction { y: 1 } turbidity: 3 } } ";

/// Of a ball of this material beside the light.
double found(const std::string& light, const std::string& material,
             const std::string& integrator = "path") {
  const std::string text = "settings { integrator { kind: '" + integrator + "' } } " + light +
                           "materials { name: 'm' " + material +
                           " } nodes { shape { materials: 'm' sphere {} } } ";
  return light_by_chance(*build_scene(parse_scene(text), {}, frame_of(8, 8), 1));
}

TEST(LightByChance, IsThatOfTheLampWhereMirrorsOrSmoothGlassThrowIt) {
  for (const std::string material :
       {"dielectric { }", "conductor { roughness { value: 0 } }",
        "physical { roughness { value: 0 } }",
        "physical { clearcoat { value: 1 } clearcoat_roughness { value: 0 } }",
        "classic { reflectivity { value { r: .1 } } }",
        "classic { transparency { value: .5 } refractive_index: 1.5 }"}) {
    EXPECT_EQ(found(kLamp, material), 20) << material;
    EXPECT_EQ(found(kLamp, material, "whitted"), 1) << material;
    EXPECT_EQ(found("", material), 1) << material;
    EXPECT_GT(found(kSun, material), 1000) << material;
  }
}

TEST(LightByChance, IsNoneWhereLightIsLookedFor) {
  for (const std::string material :
       {"unlit { }", "classic { }", "classic { transparency { value: .5 } }",
        "physical { roughness { value: .3 } }", "conductor { roughness { value: .3 } }",
        "dielectric { roughness { value: .3 } }"}) {
    EXPECT_EQ(found(kLamp, material), 1) << material;
    EXPECT_EQ(found(kSun, material), 1) << material;
  }
}

}  // namespace
}  // namespace tessera
