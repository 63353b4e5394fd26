#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/unit/scenes/formats/gltf/gltf_files.h"

namespace tessera::gltf_files {
namespace {

const Floats kColors{1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};

/// A file whose one primitive has the mode, over the square's corners.
std::string of_mode(int mode, const std::string& more_attributes = "",
                    const std::string& node = kNode, const std::string& more = "") {
  return Binary().put(kSquare).put(kColors).glb(
      node +
      mesh(R"({"attributes":{"POSITION":0,"COLOR_0":1)" + more_attributes + R"(},"mode":)" +
           std::to_string(mode) + R"(,"material":0})") +
      R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5126, 4, "VEC3") +
      R"(],"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0,1]},)"
      R"("emissiveFactor":[0,0.5,0]}])" +
      more);
}

TEST(GltfStrokes, EveryModeIsSeen) {
  const size_t triangles[] = {4 * 8, 2 * 8, 4 * 8, 3 * 8, 1, 2, 2};
  for (int mode = 0; mode <= 6; ++mode) {
    const LoadedScene loaded = read(of_mode(mode));
    ASSERT_EQ(loaded.scene.nodes_size(), 1) << mode;
    EXPECT_EQ(first_mesh(loaded).triangles.size(), 3 * triangles[mode]) << mode;
    EXPECT_EQ(loaded.scene.nodes(0).casts_no_shadow(), mode < 4) << mode;
    EXPECT_EQ(loaded.scene.materials(0).has_unlit(), mode < 4) << mode;
    EXPECT_EQ(loaded.warnings.empty(), mode != 4) << mode << ": four corners are no two triangles";
  }
}

TEST(GltfStrokes, PointsShowTheColoursOfTheirVertices) {
  const LoadedScene loaded = read(of_mode(0));
  const Mesh m = first_mesh(loaded);
  ASSERT_EQ(m.colors.size(), 4u * 6 * 4);
  for (size_t v = 0; v < 24; ++v)
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(m.colors[v * 4 + c], kColors[v / 6 * 3 + c]) << v;
  const v1::Color& shown = loaded.scene.materials(0).unlit().color().value();
  EXPECT_EQ(shown.r(), .5);
  EXPECT_EQ(shown.g(), .75) << "with what it emits";
}

TEST(GltfStrokes, NormalsOfVerticesLightThem) {
  const LoadedScene loaded = read(of_mode(0, R"(,"NORMAL":1)"));
  EXPECT_TRUE(loaded.scene.materials(0).has_physical());
  const Mesh m = first_mesh(loaded);
  ASSERT_EQ(m.normals.size(), 24u * 3);
  EXPECT_EQ(Floats(m.normals.begin() + 18, m.normals.begin() + 21), (Floats{0, 1, 0}));
}

/// How far the vertices of the first point, which is at the origin, are from it, in metres.
double radius(const LoadedScene& loaded) {
  const Floats positions = first_mesh(loaded).positions;
  double out = 0;
  for (size_t v = 0; v < 6; ++v)
    out = std::max(
        out, double{std::hypot(positions[v * 3], positions[v * 3 + 1], positions[v * 3 + 2])});
  return out;
}

TEST(GltfStrokes, TheyAreAsWideAsTheViewAsksFor) {
  const double of_square = std::sqrt(2.) / 720;
  EXPECT_NEAR(radius(read(of_mode(0))), of_square, 1e-6) << "half of 1/360 of the whole";
  const std::string scaled = R"("nodes":[{"mesh":0,"scale":[10,10,10]}],)";
  EXPECT_NEAR(radius(read(of_mode(0, "", scaled))), of_square, 1e-6) << "in the node's lengths";
  const std::string seen = R"("nodes":[{"mesh":0},{"camera":0,"translation":[0,0,5]}],)";
  const std::string camera =
      R"(,"cameras":[{"type":"perspective","perspective":{"yfov":1.5707963}}])";
  EXPECT_NEAR(radius(read(of_mode(0, "", seen, camera))), 5. / 360, 1e-5) << "5 m from the camera";
}

TEST(GltfStrokes, OnePointAloneHasASizeWhereverItIs) {
  const auto file = [](const std::string& place) {
    return Binary()
        .put(Floats{0, 0, 0})
        .glb(R"("nodes":[{"mesh":0,"rotation":[0.6,0,0,0.8],"translation":)" + place + "}]," +
             mesh(R"({"attributes":{"POSITION":0},"mode":0})") + R"(,"accessors":[)" +
             accessor(0, 5126, 1, "VEC3") + "]");
  };
  EXPECT_NEAR(radius(read(file("[0,0,0]"))), 1. / 720, 1e-6);
  EXPECT_NEAR(radius(read(file("[0,1e6,0.1]"))), 1e6 / 720, 1);
}

TEST(GltfStrokes, WhatIsWrongCostsItselfAlone) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::string file =
      Binary()
          .put(Floats{0, 0, 0, 1, 0, 0, kNan, 0, 0})
          .put(std::vector<uint8_t>{0, 1, 1, 2, 0, 9, 1})
          .glb(kNode + mesh(R"({"attributes":{"POSITION":0},"indices":1,"mode":1})") +
               R"(,"accessors":[)" + accessor(0, 5126, 3, "VEC3") + "," +
               accessor(1, 5121, 7, "SCALAR") + "]");
  const LoadedScene loaded = read(file);
  EXPECT_EQ(first_mesh(loaded).triangles.size(), 3u * 8) << "the line from 0 to 1";
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{
                "t.glb: meshes/0/primitives/0/indices: 7 corners; expected 2 or a multiple of it; "
                "those left over are left out",
                "t.glb: meshes/0/primitives/0/indices: index 9 of 3 vertices; expected indices of "
                "vertices; the lines there are left out",
                "t.glb: meshes/0/primitives/0/attributes/POSITION: numbers that are not finite in "
                "single precision; expected finite numbers; the points and lines there are left "
                "out"}));
}

TEST(GltfStrokes, PointsBesideTrianglesKeepTheirLooks) {
  const std::string file = Binary().put(kSquare).glb(
      kNode +
      mesh(R"({"attributes":{"POSITION":0},"mode":6},{"attributes":{"POSITION":0},"mode":2})") +
      R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "]");
  const LoadedScene loaded = read(file);
  ASSERT_EQ(loaded.scene.nodes_size(), 1);
  const auto& shapes = loaded.scene.nodes(0).children();
  ASSERT_EQ(shapes.size(), 2);
  EXPECT_FALSE(shapes[0].casts_no_shadow());
  EXPECT_TRUE(shapes[1].casts_no_shadow());
  EXPECT_NE(shapes[0].shape().materials(0), shapes[1].shape().materials(0));
}

}  // namespace
}  // namespace tessera::gltf_files
