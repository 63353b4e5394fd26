#include <gtest/gtest.h>

#include "tests/unit/scenes/formats/gltf/gltf_files.h"

namespace tessera::gltf_files {
namespace {

const Floats kUp{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
/// A quarter turn about the x axis, and about the y axis.
const std::string kTurnX = R"("rotation":[0.70710678,0,0,0.70710678])",
                  kTurnY = R"("rotation":[0,0.70710678,0,0.70710678])";

/// Text with `part` in it replaced.
std::string replaced(std::string text, const std::string& part, const std::string& other) {
  const size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return text.replace(at, part.size(), other);
}

/// A square whose corner i is moved by `joints` and `weights` of numbers 4 i to 4 i + 3. Nodes: 0
/// shows it, itself moved far away; 1 to 3 are the joints. Bind matrix 0 takes x = 1 to 0.
struct SkinFile {
  std::string joint_nodes = R"({"translation":[0,0,5]},{"scale":[2,2,2]},{"scale":[-1,1,1]})";
  std::vector<uint8_t> joints{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  Floats weights{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  Floats normals = kUp;
  std::string part = "", other = "";  ///< in the JSON, the second in place of the first

  LoadedScene read() const {
    Floats binds;
    for (int joint = 0; joint < 3; ++joint)
      for (int i = 0; i < 16; ++i) binds.push_back(i % 5 == 0 ? 1 : i == 12 && joint == 0 ? -1 : 0);
    const std::string members =
        R"("scenes":[{"nodes":[0,1,2,3]}],"scene":0,)"
        R"("nodes":[{"mesh":0,"skin":0,"translation":[100,0,0]},)" +
        joint_nodes + R"(],"skins":[{"joints":[1,2,3],"inverseBindMatrices":4}],)" +
        mesh(R"({"attributes":{"POSITION":0,"NORMAL":1,"TANGENT":5,"JOINTS_0":2,"WEIGHTS_0":3},)"
             R"("mode":6})") +
        R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5126, 4, "VEC3") +
        "," + accessor(2, 5121, 4, "VEC4") + "," + accessor(3, 5126, 4, "VEC4") + "," +
        accessor(4, 5126, 3, "MAT4") + "," + accessor(5, 5126, 4, "VEC4") + "]";
    return gltf_files::read(Binary()
                                .put(kSquare)
                                .put(normals)
                                .put(joints)
                                .put(weights)
                                .put(binds)
                                .put(Floats{1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1})
                                .glb(part.empty() ? members : replaced(members, part, other)));
  }
};

Floats tangents_of(const LoadedScene& loaded) {
  return blob_values<float>(loaded.scene.nodes(0).shape().mesh().tangents(), loaded.blobs);
}

TEST(GltfSkin, BendsByTheJointsAsTheyStandWhereverTheNodeIs) {
  const LoadedScene loaded = SkinFile{}.read();
  EXPECT_EQ(first_mesh(loaded).positions, (Floats{-1, 0, 5, 0, 0, 5, 0, 1, 5, -1, 1, 5}));
  EXPECT_FALSE(loaded.scene.nodes(0).has_transform());
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
}

TEST(GltfSkin, WeighsJointsAndMakesTheWeightsOne) {
  SkinFile file;
  file.joints = {0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1, 1, 9, 0, 0};
  file.weights = {.5f, .5f, 0, 0, 3, 1, 0, 0, .25f, .25f, .25f, .25f, .1f, 0, 0, 0};
  const LoadedScene loaded = file.read();
  EXPECT_EQ(first_mesh(loaded).positions,
            (Floats{-.5f, 0, 2.5f, 1.5f, 0, 1.25f, 2, 2, 0, 0, 2, 0}));
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{}) << "a joint of no weight may be any";
}

TEST(GltfSkin, TurnsNormalsAndTangentsAndTheWindingOfMirroredTriangles) {
  SkinFile file;
  file.joint_nodes = "{" + kTurnX + "},{" + kTurnY + R"(,"scale":[1,1,4]},{"scale":[-1,1,1]})";
  file.joints = {0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  file.normals = {0, 0, 1, 0, 3, 16, 0, 0, 1, 0, 0, 1};
  const Floats normals = first_mesh(file.read()).normals;
  for (size_t i = 0; i < normals.size(); ++i)
    EXPECT_NEAR(normals[i], (Floats{0, -1, 0, .8f, .6f, 0, 1, 0, 0, 1, 0, 0})[i], 1e-6) << i;
  EXPECT_NEAR(tangents_of(file.read())[4 + 2], -1, 1e-6) << "x to -z";
  file.joints.assign(16, 2);
  file.normals = kUp;
  const LoadedScene mirrored = file.read();
  const Mesh m = first_mesh(mirrored);
  EXPECT_EQ(m.positions, (Floats{0, 0, 0, -1, 0, 0, -1, 1, 0, 0, 1, 0}));
  EXPECT_EQ(m.triangles, (Indices{1, 0, 2, 2, 0, 3})) << "from 1, 2, 0 and 2, 3, 0";
  EXPECT_EQ(m.normals, kUp);
  const Floats tangents = tangents_of(mirrored);
  EXPECT_EQ(Floats(tangents.begin(), tangents.begin() + 4), (Floats{-1, 0, 0, -1}));
}

TEST(GltfSkin, ReadsSeveralSetsOfJointsNormalisedWeightsAndAddsMorphTargetsBefore) {
  // Vertices 1 to 3 are those of joint 0; vertex 0 is half joint 1's, which is of the second set.
  const std::string file =
      Binary()
          .put(kSquare)
          .put(std::vector<uint16_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})
          .put(std::vector<uint8_t>{51, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0})
          .put(std::vector<uint16_t>{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})
          .put(Floats{.2f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})
          .put(Floats{0, 0, 3, 0, 0, 3, 0, 0, 3, 0, 0, 3})
          .glb(R"("nodes":[{"mesh":0,"skin":0},{"mesh":0,"skin":0},{"children":[3]},)"
               R"({"translation":[0,8,0]}],"skins":[{"joints":[2,3]}],"meshes":[{"weights":[2],)"
               R"("primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2,)"
               R"("JOINTS_1":3,"WEIGHTS_1":4},"targets":[{"POSITION":5}],"mode":6}]}],)"
               R"("accessors":[)" +
               accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5123, 4, "VEC4") + "," +
               accessor(2, 5121, 4, "VEC4", R"(,"normalized":true)") + "," +
               accessor(3, 5123, 4, "VEC4") + "," + accessor(4, 5126, 4, "VEC4") + "," +
               accessor(5, 5126, 4, "VEC3") + "]");
  const LoadedScene loaded = gltf_files::read(file);
  ASSERT_EQ(loaded.scene.nodes_size(), 2) << "two nodes may share a skin";
  for (const v1::Node& node : loaded.scene.nodes()) {
    const Floats at = mesh_of(node.shape(), loaded.blobs).positions;
    EXPECT_NEAR(at[1], 4, 1e-6);
    EXPECT_EQ(Floats(at.begin() + 2, at.end()), (Floats{6, 1, 0, 6, 1, 1, 6, 0, 1, 6}));
  }
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{}) << "bind matrices may be left out";
}

TEST(GltfSkin, WhatIsWrongCostsTheSkinAlone) {
  const auto check = [](const char* part, const char* other, const std::string& warning) {
    SkinFile file;
    file.part = part, file.other = other;
    const LoadedScene loaded = file.read();
    EXPECT_EQ(first_mesh(loaded).positions, kSquare) << other;
    const auto& rows = loaded.scene.nodes(0).transform().steps(0).matrix().rows();
    EXPECT_EQ(rows[3], 100) << other;
    EXPECT_NE(
        testing::PrintToString(loaded.warnings).find(": " + warning + "; the mesh is shown unbent"),
        std::string::npos)
        << testing::PrintToString(loaded.warnings);
    EXPECT_EQ(loaded.repairs.size(), 1u) << other;
  };
  check(R"("skin":0)", R"("skin":1)", "nodes/0/skin: skin 1; expected 0 to 0");
  check("[1,2,3]", "[]", "skins/0: no joints; expected at least one");
  check("[1,2,3]", "[1,2,7]", "skins/0/joints/2: node 7; expected a node of the scene");
  check("[1,2,3]", R"([1,2,"x"])", "skins/0/joints/2: 'x'; expected a whole number");
  check(R"("nodes":[0,1,2,3])", R"("nodes":[0,1,2])",
        "skins/0/joints/2: node 3; expected a node of the scene");
  check(R"("inverseBindMatrices":4)", R"("inverseBindMatrices":8)",
        "skins/0/inverseBindMatrices: accessor 8; expected 0 to 5");
  check(R"("inverseBindMatrices":4)", R"("inverseBindMatrices":5)",
        "accessors/5: 4 rows of 4; expected a MAT4 for each of 3 joints");
  check(R"("count":3,"type":"MAT4")", R"("count":2,"type":"MAT4")",
        "accessors/4: 2 rows of 16; expected a MAT4 for each of 3 joints");
}

TEST(GltfSkin, VerticesThatNoJointMovesStayWhereTheirNodeHasThem) {
  const auto check = [](const SkinFile& file, const Floats& first, const std::string& warning) {
    const LoadedScene loaded = file.read();
    const Floats at = first_mesh(loaded).positions;
    EXPECT_EQ(Floats(at.begin(), at.begin() + 3), first) << warning;
    if (warning.empty())
      EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
    else
      EXPECT_NE(testing::PrintToString(loaded.warnings).find(warning), std::string::npos)
          << testing::PrintToString(loaded.warnings);
  };
  SkinFile file;
  file.weights[0] = 0;
  check(file, {100, 0, 0}, "");
  file.weights[0] = -1;
  check(file, {100, 0, 0}, "WEIGHTS_0: a weight of -1; expected 0 or more; 0 is taken");
  file.weights[0] = 1;
  file.joints[0] = 3;
  check(file, {100, 0, 0}, "JOINTS_0: joint 3; expected 0 to 2; its weight is left out");
  file.joints[0] = 0;
  file.part = R"("JOINTS_0":2)", file.other = R"("JOINTS_0":9)";
  check(file, {100, 0, 0}, "JOINTS_0: accessor 9; expected 0 to 5; it is left out");
  file.other = R"("JOINTS_0":0)";
  check(file, {100, 0, 0}, "JOINTS_0: rows of 3; expected 4 numbers a row; it is left out");
  file.other = R"("JOINTS_7":2)";
  check(file, {100, 0, 0}, "attributes: no joints; expected JOINTS_0 and WEIGHTS_0");
}

}  // namespace
}  // namespace tessera::gltf_files
