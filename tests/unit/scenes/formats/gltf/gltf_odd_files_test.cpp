// Files that break the format: what is left out with a warning, and what is refused.
#include <gtest/gtest.h>

#include <limits>

#include "renderer/math/elementary.h"
#include "scenes/formats/gltf/gltf_file.h"
#include "scenes/formats/gltf/gltf_value.h"
#include "tests/unit/scenes/formats/gltf/gltf_files.h"

namespace tessera::gltf_files {
namespace {

TEST(Gltf, HoldsCountsAgainstTheBytesThatAreThere) {
  const auto file = [](const std::string& accessors) {
    return Binary().put(kSquare).glb(kNode + mesh(R"({"attributes":{"POSITION":0}})") +
                                     R"(,"accessors":[)" + accessors + "]");
  };
  EXPECT_EQ(error(file(accessor(0, 5126, 5, "VEC3"))),
            "t.gltf: accessors/0: 5 rows; expected at most 4, which its buffer view holds");
  EXPECT_EQ(error(file(accessor(0, 5126, 4, "VEC3", R"(,"byteOffset":4)"))),
            "t.gltf: accessors/0: 4 rows; expected at most 3, which its buffer view holds");
  EXPECT_EQ(error(file(R"({"componentType":5126,"type":"VEC3","count":1000000000000})")),
            "t.gltf: accessors/0/count: 1000000000000 zeros; expected at most 16777216");
  EXPECT_EQ(error(file(accessor(0, 5126, 4, "MAT4"))),
            "t.gltf: accessors/0/type: 'MAT4'; expected SCALAR, VEC2, VEC3 or VEC4");
  EXPECT_EQ(error(file(accessor(0, 5124, 4, "VEC3"))),
            "t.gltf: accessors/0/componentType: 5124; expected 5120 to 5123, 5125 or 5126");
}

TEST(Gltf, ReadsNoMoreInAllThanAMachineHolds) {
  const std::string text = R"({"meshes":[{}]})";
  GltfFile file(text, "t.gltf", {});
  const GltfValue mesh = file.element("meshes", 0);
  file.spend(GltfFile::kMostRead - 1, mesh);
  file.spend(1, mesh);
  EXPECT_EQ(
      error_of([&] { file.spend(1, mesh); }),
      "t.gltf:1:12: meshes/0: too much in all; expected at most 2147483648 numbers, or bytes of "
      "pictures");
}

TEST(Gltf, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(error("{\n  \"a\": [1,\n  }"),
            "t.gltf:3:3: what is no JSON; expected the JSON of a glTF "
            "file");
  EXPECT_EQ(error("[]"), "t.gltf: no JSON object; expected the JSON of a glTF file");
  EXPECT_EQ(error("{}"), "t.gltf: no asset/version; expected glTF 2.0");
  EXPECT_EQ(error(R"({"asset":{"version":"1.0"}})"),
            "t.gltf:1:21: asset/version: version '1.0'; expected glTF 2.0");
  EXPECT_EQ(
      error("{\"asset\":{\"version\":\"2.0\"},\n \"extensionsRequired\":[\"KHR_material_ior\"]}"),
      "t.gltf:2:24: extensionsRequired/0: the file requires extension 'KHR_material_ior'; "
      "expected one that is read; did you mean 'KHR_materials_ior'?");
  EXPECT_EQ(error(std::string(1000, '[')),
            "t.gltf: JSON that is nested deeper; expected at most 64 levels");
  EXPECT_EQ(error("glTF"), "t.gltf: the file ends in its header; expected a .glb file");
  EXPECT_EQ(error(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)"
                  R"("attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"count":1,)"
                  R"("componentType":5126,"type":"VEC3"}],"bufferViews":[{"buffer":0,)"
                  R"("byteLength":12}],"buffers":[{"byteLength":12,"uri":"a.bin"}]})"),
            "t.gltf:1:262: buffers/0/uri: other files are not read here; expected a file that can "
            "be read");
}

std::vector<std::string> warnings(const std::string& text) {
  return parse_gltf(text, "t.gltf").warnings;
}

TEST(Gltf, NumbersThatAreNotFiniteAreLeftOut) {
  const LoadedScene loaded = parse_gltf(
      "{\"asset\": {\"version\": \"2.0\", \"extras\": \"NaN \\\" 1e999\"},\n"
      " \"nodes\": [{\"camera\": 0, \"translation\": [NaN, 2, -1e400]}],\n"
      " \"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 1,"
      " \"zfar\": Infinity, \"znear\": 1e-400}}]}",
      "t.gltf");
  const auto& rows = loaded.scene.cameras(0).world_from_camera().steps(0).matrix().rows();
  EXPECT_EQ(rows[3], 0);
  EXPECT_EQ(rows[7], 2);
  EXPECT_EQ(rows[11], 0);
  EXPECT_EQ(loaded.warnings,
            std::vector<std::string>{
                "t.gltf:2:42: NaN; expected a finite number; it is left out (3 times)"});
  EXPECT_EQ(warnings("{\"asset\":{\"version\":\"2.0\"},\n\"skins\":[{},{\"name\":42}]}"),
            std::vector<std::string>{"t.gltf:2:21: skins/1/name: a value of type number; expected "
                                     "text; it is left out"});
}

std::string with_node(const std::string& node) {
  return R"({"asset":{"version":"2.0"},"nodes":[{"camera":0},{"camera":0,)" + node +
         R"(,"children":[2]},{"camera":0}],"cameras":[{"type":"perspective","perspective":)"
         R"({"yfov":1}}]})";
}

TEST(Gltf, MatricesMayBeRounded) {
  const auto cameras = [](const std::string& numbers) {
    return parse_gltf(with_node("\"matrix\":[" + numbers + "]"), "t.gltf").scene.cameras_size();
  };
  EXPECT_EQ(cameras("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1"), 3);
  EXPECT_EQ(cameras("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,0.99999994"), 3);
  EXPECT_EQ(cameras("1e-3,0,0,-1e-8, 0,1e-3,0,0, 0,0,1e-3,0, 500,0,0,1.0000001"), 3);
  EXPECT_EQ(cameras("1000,0,0,1e-4, 0,1000,0,0, 0,0,1000,0, 0,0,0,1"), 3)
      << "rounding is relative to the matrix";
  EXPECT_EQ(cameras("1,0,0,0.01, 0,1,0,0, 0,0,1,0, 0,0,0,1"), 1) << "a projection";
  EXPECT_EQ(warnings(with_node(R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2])")),
            std::vector<std::string>{
                "t.gltf:1:71: nodes/1/matrix: a last row other than 0 0 0 1; expected an affine "
                "matrix; the node and what is below it are left out"});
}

TEST(Gltf, OddNodesDoNotCostTheFile) {
  EXPECT_EQ(warnings(with_node(R"("rotation":[0,0,0,0])")),
            std::vector<std::string>{"t.gltf:1:73: nodes/1/rotation: a quaternion of no length; "
                                     "expected a unit one; the node is not turned"});
  EXPECT_EQ(warnings(with_node(R"("scale":[0,1,1])")),
            std::vector<std::string>{
                "t.gltf:1:50: nodes/1: a camera in a flat frame; expected a frame that can be "
                "inverted; the camera is left out (2 times)"});
  EXPECT_EQ(warnings(with_node(R"("mesh":-1)")),
            std::vector<std::string>{
                "t.gltf:1:69: nodes/1/mesh: -1; expected a mesh, or no value; it is left out"});
}

TEST(Gltf, OddLightsAndCamerasDoNotCostTheFile) {
  const auto light = [](const std::string& members) {
    return parse_gltf(R"({"asset":{"version":"2.0"},"nodes":[{"extensions":)"
                      R"({"KHR_lights_punctual":{"light":0}}}],"extensions":)"
                      R"({"KHR_lights_punctual":{"lights":[{)" +
                          members + "}]}}}",
                      "t.gltf");
  };
  const LoadedScene hard =
      light(R"("type":"spot","spot":{"innerConeAngle":0.4,"outerConeAngle":0.4})");
  EXPECT_EQ(hard.warnings, std::vector<std::string>{}) << "Blender's hard edge";
  const v1::Light::Spot& spot = hard.scene.nodes(0).light().spot();
  EXPECT_EQ(spot.beam_width(), spot.cut_off());
  EXPECT_NEAR(spot.cut_off(), portable::degrees(.4), 1e-12);
  const LoadedScene odd =
      light(R"("type":"spot","spot":{"innerConeAngle":0.5,"outerConeAngle":0.4},"intensity":-3,)"
            R"("color":[1,-0.0000001,-2])");
  EXPECT_EQ(odd.scene.nodes(0).light().intensity(), 0);
  EXPECT_EQ(odd.scene.nodes(0).light().color().b(), 0);
  EXPECT_EQ(
      odd.warnings,
      (std::vector<std::string>{
          "t.gltf:1:239: extensions/KHR_lights_punctual/lights/0/color/2: -2; expected 0 or "
          "more; 0 is taken",
          "t.gltf:1:214: extensions/KHR_lights_punctual/lights/0/intensity: -3; expected 0 or "
          "more; 0 is taken",
          "t.gltf:1:176: extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle: 0.5; "
          "expected 0 to 0.4; 0.4 is taken"}));
  EXPECT_EQ(light(R"("type":"area")").scene.nodes_size(), 0);
  EXPECT_EQ(light(R"("type":"area")").repairs.size(), 1u);
  EXPECT_EQ(light(R"("type":"point","range":0)").scene.nodes(0).light().radius(), 0);
}

TEST(Gltf, OddMaterialsDoNotCostTheFile) {
  const LoadedScene loaded = read(material(
      R"("pbrMetallicRoughness":{"baseColorFactor":[-1,0.5,2,1],"metallicFactor":1.0000001,)"
      R"("roughnessFactor":1.5,"baseColorTexture":{}},"alphaMode":"CUTOUT",)"
      R"("extensions":{"KHR_materials_ior":{"ior":0.9}})"));
  const v1::Physical& p = loaded.scene.materials(0).physical();
  EXPECT_EQ(p.base_color().value().r(), 0);
  EXPECT_EQ(p.metallic().value(), 1);
  EXPECT_EQ(p.roughness().value(), 1);
  EXPECT_EQ(p.refractive_index(), 1);
  EXPECT_EQ(loaded.scene.materials(0).alpha(), v1::Material::ALPHA_OPAQUE);
  EXPECT_EQ(loaded.repairs.size(), 5u) << testing::PrintToString(loaded.warnings);
  const LoadedScene never = read(material(R"("alphaMode":"MASK","alphaCutoff":1.5)"));
  EXPECT_EQ(never.scene.materials(0).opacity().value(), 0) << "which no alpha reaches";
  EXPECT_EQ(never.warnings, std::vector<std::string>{});
}

TEST(Gltf, OddVerticesDoNotCostTheFile) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::string file =
      Binary()
          .put(Floats{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, kNan, 0})
          .put(Floats{0, 0, 1, kNan, 0, 1, 0, 0, 1, 0, 0, 1})
          .put(Floats{0, 0})
          .glb(kNode +
               mesh(R"({"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"mode":6},)"
                    R"({"attributes":{"POSITION":0},"mode":9})") +
               R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," +
               accessor(1, 5126, 4, "VEC3") + "," + accessor(2, 5126, 1, "VEC2") + "]");
  const LoadedScene loaded = read(file);
  const Mesh m = first_mesh(loaded);
  EXPECT_EQ(m.triangles, (Indices{1, 2, 0}));
  EXPECT_EQ(Floats(m.normals.begin() + 3, m.normals.begin() + 6), (Floats{0, 0, 0}));
  EXPECT_EQ(m.positions[10], 0) << "which nothing refers to";
  EXPECT_EQ(m.uvs, Floats{});
  EXPECT_EQ(loaded.repairs.size(), 4u) << testing::PrintToString(loaded.warnings);
}

TEST(Gltf, AContainerMayBeFilledUpWithZeros) {
  std::string bytes;
  size_t end = 0, last = 0;
  // One byte more, until there is something to fill up.
  for (std::string more; last == end; more += ' ') {
    bytes = Binary().put(kSquare).glb(more + kNode + kTriangle);
    end = bytes.find("BIN") - 4;
    last = bytes.rfind('}', end) + 1;
  }
  for (; last < end; ++last) bytes[last] = '\0';
  EXPECT_EQ(read(bytes).scene.nodes_size(), 1);
}

}  // namespace
}  // namespace tessera::gltf_files
