#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/scenes/formats/gltf/gltf_files.h"

namespace tessera::gltf_files {
namespace {

/// A triangle shown at the frames that `attributes` say, by a node at x = 10. Accessors: 0 the
/// triangle, 1 shifts along y and x, 2 turns about z by 0 and 90 degrees in normalised shorts, 3
/// sizes 1 and 2, 4 one shift, 5 shifts, the second not finite, 6 the turns in normalised bytes.
LoadedScene instances(const std::string& attributes, const std::string& more = "") {
  return read(Binary()
                  .put(kSquare)
                  .put(Floats{0, 1, 0, 3, 0, 0})
                  .put(std::vector<int16_t>{0, 0, 0, 32767, 0, 0, 23170, 23170})
                  .put(Floats{1, 1, 1, 2, 2, 2})
                  .put(Floats{0, 1, 0, std::numeric_limits<float>::infinity(), 0, 0})
                  .put(std::vector<int8_t>{0, 0, 0, 127, 0, 0, 90, 90})
                  .glb(R"("nodes":[{"mesh":0,"translation":[10,0,0],"extensions":)"
                       R"({"EXT_mesh_gpu_instancing":{"attributes":{)" +
                       attributes + "}}}}" + more +
                       R"(],"extensionsRequired":["EXT_mesh_gpu_instancing"],)" +
                       mesh(R"({"attributes":{"POSITION":0}})") + R"(,"accessors":[)" +
                       accessor(0, 5126, 3, "VEC3") + "," + accessor(1, 5126, 2, "VEC3") + "," +
                       accessor(2, 5122, 2, "VEC4", R"(,"normalized":true)") + "," +
                       accessor(3, 5126, 2, "VEC3") + "," + accessor(1, 5126, 1, "VEC3") + "," +
                       accessor(4, 5126, 2, "VEC3") + "," +
                       accessor(5, 5120, 2, "VEC4", R"(,"normalized":true)") + "]"));
}

/// The numbers of a node's matrix.
std::vector<double> rows_of(const v1::Node& node) {
  const auto& rows = node.transform().steps(0).matrix().rows();
  return {rows.begin(), rows.end()};
}

TEST(GltfInstances, ShowsAMeshAtEveryFrame) {
  const LoadedScene loaded = instances(R"("TRANSLATION":1,"ROTATION":2,"SCALE":3)");
  ASSERT_EQ(loaded.scene.nodes_size(), 2);
  ASSERT_EQ(loaded.scene.objects_size(), 1) << "stored once";
  for (const v1::Node& node : loaded.scene.nodes())
    EXPECT_EQ(node.instance_of(), loaded.scene.objects(0).name());
  EXPECT_EQ(rows_of(loaded.scene.nodes(0)),
            (std::vector<double>{1, 0, 0, 10, 0, 1, 0, 1, 0, 0, 1, 0}));
  const std::vector<double> second = rows_of(loaded.scene.nodes(1));
  for (size_t i = 0; i < second.size(); ++i)
    EXPECT_NEAR(second[i], (std::vector<double>{0, -2, 0, 13, 2, 0, 0, 0, 0, 0, 2, 0})[i], 1e-12);
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  EXPECT_EQ(instances(R"("SCALE":3)", R"(,{"mesh":0})").scene.nodes_size(), 3);
  const LoadedScene bytes = instances(R"("ROTATION":6)");
  EXPECT_EQ(bytes.warnings, std::vector<std::string>{}) << "their length is 1.002";
  EXPECT_NEAR(rows_of(bytes.scene.nodes(1))[1], -1, 1e-12);
  const LoadedScene one = instances(R"("TRANSLATION":4)");
  ASSERT_EQ(one.scene.nodes_size(), 1);
  EXPECT_TRUE(one.scene.nodes(0).has_shape()) << "of one nothing is shared";
  EXPECT_EQ(rows_of(one.scene.nodes(0))[7], 1);
}

TEST(GltfInstances, WhatIsWrongCostsTheInstancesAlone) {
  const auto check = [](const char* attributes, const std::string& warning) {
    const LoadedScene loaded = instances(attributes);
    ASSERT_EQ(loaded.scene.nodes_size(), 1) << attributes;
    EXPECT_EQ(rows_of(loaded.scene.nodes(0))[3], 10) << attributes;
    EXPECT_EQ(only_warning(loaded),
              "nodes/0/extensions/EXT_mesh_gpu_instancing/attributes" + warning)
        << attributes;
  };
  const std::string once = "; the mesh is shown once";
  check("", ": no attribute; expected TRANSLATION, ROTATION or SCALE" + once);
  check(R"("TRANSLATION":9)", "/TRANSLATION: accessor 9; expected 0 to 6" + once);
  check(R"("ROTATION":1)", "/ROTATION: rows of 3; expected 4 numbers a row" + once);
  check(R"("TRANSLATION":1,"SCALE":4)", "/SCALE: 1 rows; expected 2, as of the others" + once);
  check(R"("TRANSLATION":5)",
        ": an instance whose frame is not finite; expected finite numbers; it is left out");
}

TEST(GltfInstances, TakeNoMoreMemoryThanAMachineHas) {
  const std::string file = Binary().put(kSquare).glb(
      R"("nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":)"
      R"({"TRANSLATION":1}}}}],)" +
      mesh(R"({"attributes":{"POSITION":0}})") + R"(,"accessors":[)" +
      accessor(0, 5126, 3, "VEC3") + R"(,{"componentType":5126,"count":16777216,"type":"VEC3"}])");
  EXPECT_NE(error(file).find("too much in all"), std::string::npos) << error(file);
}

}  // namespace
}  // namespace tessera::gltf_files
