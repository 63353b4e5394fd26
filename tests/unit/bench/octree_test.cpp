#include "bench/octree.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "bench/scene_mesh.h"
#include "scenes/generate/generate_scene.h"

namespace tessera {
namespace {

size_t objects(const OctreeScene& scene) {
  return scene.spheres.size() + scene.diamonds.size() + (scene.mesh.triangles.empty() ? 0 : 1);
}

TEST(OctreeScenes, HaveTheStudysNumbers) {
  EXPECT_EQ(objects(make_octree_scene("uniform-diamonds")), 728u);
  EXPECT_EQ(objects(make_octree_scene("random-diamonds")), 1000u);
  EXPECT_EQ(objects(make_octree_scene("concentric-spheres")), 5985u);
  EXPECT_EQ(objects(make_octree_scene("clumped-diamonds")), 3200u);
  EXPECT_EQ(objects(make_octree_scene("teapot")), 1u);
  EXPECT_EQ(diamond().triangle_count(), 8u);
  EXPECT_NEAR(static_cast<double>(pot_mesh().triangle_count()), 25000, 1500);
  EXPECT_THROW(make_octree_scene("teepot"), Error);
}

TEST(OctreeScenes, MeshesFaceOutward) {
  for (const TriangleMesh& mesh : {to_triangles(diamond()), to_triangles(pot_mesh())}) {
    double volume = 0;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [a, b, c] = mesh.corners(i);
      volume += dot(a - Point3{}, cross(b - Point3{}, c - Point3{})) / 6;
    }
    EXPECT_GT(volume, 1);
  }
}

OctreeBenchOptions small() {
  OctreeBenchOptions options;
  options.width = 192;
  options.height = 108;
  options.rounds = 1;
  return options;
}

TEST(OctreeBench, EveryAcceleratorGivesTheSamePicture) {
  for (const std::string& name : octree_scene_names()) {
    const auto rows = bench_octree(make_octree_scene(name), small());
    ASSERT_EQ(rows.size(), 5u);
    for (const OctreeBenchRow& row : rows) {
      EXPECT_EQ(row.differing_pixels, 0u) << row.scene << " " << row.accelerator;
      EXPECT_GT(row.object_tests_per_ray, 0);
      EXPECT_GT(row.seconds, 0);
      EXPECT_EQ(row.published.has_value(), row.accelerator.find("octree") != std::string::npos);
    }
  }
}

TEST(OctreeBench, TheNonuniformOctreeNeedsFewerVoxelsAndVisits) {
  OctreeBenchOptions options = small();
  options.accelerators = {"octree", "nonuniform-octree"};
  for (size_t i = 0; i < 4; ++i) {
    const auto rows = bench_octree(make_octree_scene(octree_scene_names()[i]), options);
    EXPECT_LT(rows[1].voxels, rows[0].voxels) << rows[0].scene;
    EXPECT_LE(rows[1].depth, rows[0].depth) << rows[0].scene;
    EXPECT_LT(rows[1].references, rows[0].references) << rows[0].scene;
    EXPECT_LT(rows[1].node_visits_per_ray, rows[0].node_visits_per_ray) << rows[0].scene;
    // Far below the study's own counts, whichever the octree.
    EXPECT_LT(rows[0].object_tests_per_ray, rows[0].published->object_tests_per_ray);
    EXPECT_LT(rows[0].voxels, rows[0].published->voxels);
  }
}

TEST(OctreeBench, WritesATableAndJson) {
  OctreeBenchOptions options = small();
  options.width = options.height = 32;
  options.accelerators = {"nonuniform-octree", "bvh"};
  const auto rows = bench_octree(make_octree_scene("random-diamonds"), options);
  const std::string table = octree_table(rows);
  EXPECT_NE(table.find("published"), std::string::npos);
  const auto json = nlohmann::json::parse(octree_json(rows));
  ASSERT_EQ(json["rows"].size(), 2u);
  for (const char* key : {"scene", "accelerator", "depth", "voxels", "object_tests_per_ray",
                          "node_visits_per_ray", "seconds", "differing_pixels"})
    EXPECT_TRUE(json["rows"][0].contains(key)) << key;
  EXPECT_EQ(json["rows"][0]["published"]["voxels"], 7064);
  EXPECT_FALSE(json["rows"][1].contains("published"));
  options.accelerators = {"octal-tree"};
  EXPECT_THROW(bench_octree(make_octree_scene("random-diamonds"), options), Error);
}

}  // namespace
}  // namespace tessera
