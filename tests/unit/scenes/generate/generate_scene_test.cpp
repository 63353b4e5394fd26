#include "scenes/generate/generate_scene.h"

#include <gtest/gtest.h>

#include "renderer/math/vec.h"
#include "scenes/formats/scene_summary.h"
#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

TEST(GenerateScene, MakesClosedUnitSpheres) {
  EXPECT_EQ(icosphere(3, true).triangle_count(), 20u * 64);
  EXPECT_EQ(icosphere(3, true).vertex_count(), 642u);
  for (const MeshData& mesh : {icosphere(2, true), uv_sphere(5, 7), diamond()}) {
    // Six times the volume under outward-wound triangles: positive and near that of the sphere.
    double volume = 0;
    for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
      const auto at = [&](size_t i) {
        const size_t v = 3 * size_t{mesh.triangles[t + i]};
        return Vec3{mesh.positions[v], mesh.positions[v + 1], mesh.positions[v + 2]};
      };
      volume += dot(at(0), cross(at(1), at(2)));
    }
    EXPECT_GT(volume, 7.9);
    EXPECT_LT(volume, 8 * 3.14159265);
  }
}

TEST(GenerateScene, IsTheSameEveryTimeAndNamesWhatItCannotMake) {
  for (const std::string& name : generated_scene_names()) {
    const std::string what = name + (name == "icosphere" ? ":2" : ":7");
    const LoadedScene a = generate_scene(what), b = generate_scene(what);
    EXPECT_EQ(a.scene.SerializeAsString(), b.scene.SerializeAsString());
    EXPECT_TRUE(summarize(a.scene, a.blobs).undefined.empty());
  }
  EXPECT_EQ(
      usage_error_of([] { generate_scene("soop"); }),
      "unknown scene 'soop'; expected one of forest, icosphere, soup, spheres, uvsphere; did you "
      "mean 'soup'?");
  EXPECT_EQ(usage_error_of([] { generate_scene("icosphere:11"); }),
            "'11' in 'icosphere:11'; expected a number from 0 to 10");
}

}  // namespace
}  // namespace tessera
