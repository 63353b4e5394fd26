// Numbers that break the rules of the format: what is taken in their place.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "renderer/math/elementary.h"
#include "tests/unit/scenes/formats/gltf/gltf_files.h"

namespace tessera::gltf_files {
namespace {

TEST(Gltf, NumbersThatAreNotFiniteAreLeftOut) {
  const LoadedScene loaded = parse_gltf(
      "{\"asset\": {\"version\": \"2.0\", \"extras\": \"NaN \\\" 1e999\"},\n"
      " \"nodes\": [{\"camera\": 0, \"translation\": [NaN, 2, -1e400]}],\n"
      " \"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 1,"
      " \"zfar\": Infinity, \"extras\": 1e-400}}]}",
      "t.gltf");
  const auto& rows = loaded.scene.cameras(0).world_from_camera().steps(0).matrix().rows();
  EXPECT_EQ(rows[3], 0);
  EXPECT_EQ(rows[7], 2);
  EXPECT_EQ(rows[11], 0);
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{
                "t.gltf:2:42: nodes/0/translation/0: 'NaN'; expected a finite number; it is left "
                "out (2 times)",
                "t.gltf:3:73: cameras/0/perspective/zfar: 'Infinity'; expected a finite number; it "
                "is left out"}));
  EXPECT_EQ(
      warnings("{\"asset\":{\"version\":\"2.0\"},\n\"skins\":[{},{\"name\":42}]}"),
      std::vector<std::string>{"t.gltf:2:21: skins/1/name: 42; expected text; it is left out"});
}

/// Of the camera's place in the world: 3 rows of 4 numbers.
std::vector<double> rows_of(const LoadedScene& loaded, int camera) {
  const auto& rows = loaded.scene.cameras(camera).world_from_camera().steps(0).matrix().rows();
  return {rows.begin(), rows.end()};
}

TEST(Gltf, ANullIsLeftOutWithAWarning) {
  const LoadedScene loaded = parse_gltf(
      with_node(R"("translation":[null,2,3],"scale":[2,null,2],"rotation":null,"mesh":null)"),
      "t.gltf");
  EXPECT_EQ(rows_of(loaded, 1), (std::vector<double>{2, 0, 0, 0, 0, 1, 0, 2, 0, 0, 2, 3}));
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{
                "t.gltf:1:77: nodes/1/translation/0: null; expected a value; it is left out",
                "t.gltf:1:117: nodes/1/rotation: null; expected a value; it is left out",
                "t.gltf:1:98: nodes/1/scale/1: null; expected a value; it is left out",
                "t.gltf:1:129: nodes/1/mesh: null; expected a value; it is left out"}));
}

TEST(Gltf, MatricesMayBeRounded) {
  const auto said = [](const std::string& numbers) {
    return warnings(with_node("\"matrix\":[" + numbers + "]"));
  };
  const std::vector<std::string> nothing;
  EXPECT_EQ(said("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1"), nothing);
  EXPECT_EQ(said("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,0.99999994"), nothing);
  EXPECT_EQ(said("1e-3,0,0,-1e-8, 0,1e-3,0,0, 0,0,1e-3,0, 500,0,0,1.0000001"), nothing);
  EXPECT_EQ(said("1000,0,0,1e-4, 0,1000,0,0, 0,0,1000,0, 0,0,0,1"), nothing)
      << "rounding is relative to the matrix";
}

TEST(Gltf, AMatrixThatIsNotAffineKeepsItsNode) {
  for (const auto& [first, last] :
       {std::pair("0.5", "1"), std::pair("0", "2"), std::pair("0", "0")}) {
    const LoadedScene loaded = parse_gltf(
        with_node(fmt::format(R"("matrix":[2,0,0,{},0,2,0,0,0,0,2,0,3,4,5,{}])", first, last)),
        "t.gltf");
    ASSERT_EQ(loaded.scene.cameras_size(), 3) << "what is below the node is there";
    EXPECT_EQ(rows_of(loaded, 2), (std::vector<double>{2, 0, 0, 3, 0, 2, 0, 4, 0, 0, 2, 5}));
    EXPECT_EQ(loaded.warnings,
              std::vector<std::string>{fmt::format(
                  "t.gltf:1:71: nodes/1/matrix: a last row of {} 0 0 {}; expected 0 0 0 "
                  "1; that is taken",
                  first, last)});
  }
  EXPECT_EQ(warnings(with_node(R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],"scale":[2,2,2])")),
            std::vector<std::string>{"t.gltf:1:50: nodes/1: a matrix beside translation, rotation "
                                     "or scale; expected one or the other; the matrix is taken"});
  const LoadedScene shorter = parse_gltf(
      with_node(R"("matrix":[0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],"scale":[2,2,2])"), "t.gltf");
  EXPECT_EQ(rows_of(shorter, 1), (std::vector<double>{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}));
  EXPECT_EQ(only_warning(shorter),
            "nodes/1/matrix: an array of 15; expected 16 numbers; it is left out");
}

TEST(Gltf, RotationsAreMadeUnitOnes) {
  const auto turned = [](const std::string& rotation) {
    return parse_gltf(with_node("\"rotation\":[" + rotation + "]"), "t.gltf");
  };
  const std::vector<double> half_turn{-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0},
      none{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  EXPECT_EQ(turned("0,0,0.9995,0").warnings, std::vector<std::string>{}) << "rounding";
  EXPECT_EQ(rows_of(turned("0,0,1e-30,0"), 1), half_turn);
  EXPECT_EQ(rows_of(turned("0,0,99,0"), 1), half_turn);
  EXPECT_EQ(turned("0,0,99,0").warnings,
            std::vector<std::string>{"t.gltf:1:73: nodes/1/rotation: a quaternion of length 99; "
                                     "expected a unit one; its direction is taken"});
  EXPECT_EQ(rows_of(turned("0,0,0,0"), 1), none);
  EXPECT_EQ(turned("0,0,0,0").warnings,
            std::vector<std::string>{"t.gltf:1:73: nodes/1/rotation: a quaternion of length 0; "
                                     "expected a unit one; nothing is turned"});
}

LoadedScene with_light(const std::string& members) {
  return parse_gltf(R"({"asset":{"version":"2.0"},"nodes":[{"extensions":)"
                    R"({"KHR_lights_punctual":{"light":0}}}],"extensions":)"
                    R"({"KHR_lights_punctual":{"lights":[{)" +
                        members + "}]}}}",
                    "t.gltf");
}

LoadedScene with_camera(const std::string& type, const std::string& members) {
  return parse_gltf(R"({"asset":{"version":"2.0"},"nodes":[{"camera":0}],"cameras":[{"type":")" +
                        type + "\",\"" + type + "\":{" + members + "}}]}",
                    "t.gltf");
}

TEST(Gltf, NumbersBeyondSinglePrecisionAreLimited) {
  constexpr double kMost = std::numeric_limits<float>::max();
  const std::string taken =
      "1e+300; expected a number that single precision can hold; 3.4028234663852886e+38 is taken";
  const LoadedScene lit = with_light(R"("type":"point","intensity":1e300)");
  EXPECT_EQ(lit.scene.nodes(0).light().intensity(), kMost / portable::kPi);
  EXPECT_EQ(only_warning(lit), "extensions/KHR_lights_punctual/lights/0/intensity: " + taken);
  const LoadedScene moved = parse_gltf(with_node(R"("translation":[0,-1e300,0])"), "t.gltf");
  EXPECT_EQ(rows_of(moved, 2)[7], -kMost);
  EXPECT_EQ(only_warning(moved),
            "nodes/1/translation/1: -1e+300; expected a number that single precision can hold; "
            "-3.4028234663852886e+38 is taken");
  const LoadedScene glowing =
      read(material(R"("emissiveFactor":[1,1,1],"extensions":{"KHR_materials_emissive_strength":)"
                    R"({"emissiveStrength":1e300}})"));
  EXPECT_EQ(glowing.scene.materials(0).physical().emission().value().g(), kMost);
  EXPECT_EQ(only_warning(glowing),
            "materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength: " + taken);
  EXPECT_EQ(with_light(R"("type":"point","range":3.4028235e38)").warnings,
            std::vector<std::string>{})
      << "the largest one, rounded";
}

TEST(Gltf, OddCamerasAreMendedOrLeftOut) {
  const std::string angle = "cameras/0/perspective/yfov: ";
  const auto angled = [](const std::string& members) {
    return with_camera("perspective", members);
  };
  const LoadedScene mirrored = angled(R"("yfov":-1)");
  EXPECT_NEAR(mirrored.scene.cameras(0).perspective().field_of_view(), portable::degrees(1), 1e-12);
  EXPECT_EQ(only_warning(mirrored),
            angle + "-1; expected a number above 0 and below pi; it is taken without its sign");
  for (const char* value : {"0", "4", "-4"}) {
    const LoadedScene lost = angled(std::string(R"("yfov":)") + value);
    EXPECT_EQ(lost.scene.cameras_size(), 0);
    EXPECT_EQ(only_warning(lost),
              angle + value + "; expected a number above 0 and below pi; the camera is left out");
  }
  EXPECT_EQ(only_warning(angled(R"("znear":1)")),
            angle + "no value; expected a number above 0 and below pi; the camera is left out");
  EXPECT_EQ(angled(R"("yfov":3.1415926535)").scene.cameras_size(), 1);
  for (const char* unused : {"znear", "zfar", "aspectRatio"}) {
    const LoadedScene odd = angled(std::string(R"("yfov":1,")") + unused + "\":0");
    EXPECT_EQ(odd.scene.cameras_size(), 1);
    EXPECT_EQ(only_warning(odd), std::string("cameras/0/perspective/") + unused +
                                     ": 0; expected a number above 0; it is left out");
  }
  const auto flat = [](const std::string& members) { return with_camera("orthographic", members); };
  EXPECT_EQ(flat(R"("xmag":2,"ymag":1,"znear":0,"zfar":9)").warnings, std::vector<std::string>{});
  const LoadedScene turned = flat(R"("xmag":-2,"ymag":1)");
  EXPECT_EQ(turned.scene.cameras(0).orthographic().min_x(), -2);
  EXPECT_EQ(
      only_warning(turned),
      "cameras/0/orthographic/xmag: -2; expected a number above 0; it is taken without its sign");
  const LoadedScene line = flat(R"("xmag":2,"ymag":0)");
  EXPECT_EQ(line.scene.cameras_size(), 0);
  EXPECT_EQ(only_warning(line),
            "cameras/0/orthographic/ymag: 0; expected a number above 0; the camera is left out");
  EXPECT_EQ(only_warning(with_camera("fisheye", "")),
            "cameras/0/type: 'fisheye'; expected perspective or orthographic; the camera is left "
            "out");
}

TEST(Gltf, OddLightsAndCamerasDoNotCostTheFile) {
  const LoadedScene hard =
      with_light(R"("type":"spot","spot":{"innerConeAngle":0.4,"outerConeAngle":0.4})");
  EXPECT_EQ(hard.warnings, std::vector<std::string>{}) << "Blender's hard edge";
  const v1::Light::Spot& spot = hard.scene.nodes(0).light().spot();
  EXPECT_EQ(spot.beam_width(), spot.cut_off());
  EXPECT_NEAR(spot.cut_off(), portable::degrees(.4), 1e-12);
  const LoadedScene odd = with_light(
      R"("type":"spot","spot":{"innerConeAngle":0.5,"outerConeAngle":0.4},"intensity":-3,)"
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
  EXPECT_EQ(with_light(R"("type":"area")").scene.nodes_size(), 0);
  EXPECT_EQ(
      only_warning(with_light(R"("type":"spot","spot":{"innerConeAngle":0.2,"outerConeAngle":0})")),
      "extensions/KHR_lights_punctual/lights/0/spot: a cone of no width; expected an "
      "outerConeAngle above 0; the light is left out");
  EXPECT_EQ(
      only_warning(with_light(R"("color":[1,1,1])")),
      "extensions/KHR_lights_punctual/lights/0/type: no value; expected directional, point or "
      "spot; the light is left out");
  const LoadedScene endless = with_light(R"("type":"point","range":-5)");
  EXPECT_EQ(endless.scene.nodes(0).light().radius(), 0);
  EXPECT_EQ(only_warning(endless),
            "extensions/KHR_lights_punctual/lights/0/range: -5; expected a number above 0; it is "
            "left out");
  const LoadedScene bright = with_light(R"("type":"point","color":[1,5])");
  EXPECT_EQ(bright.scene.nodes(0).light().color().g(), 5);
  EXPECT_EQ(bright.scene.nodes(0).light().color().b(), 1);
  EXPECT_EQ(bright.repairs.size(), 1u) << testing::PrintToString(bright.warnings);
}

struct OddFactor {
  std::string body, warning;
  double (*value)(const v1::Material&);
  double taken;
};

TEST(Gltf, FactorsAreLimitedToTheirRange) {
  const std::string pbr = "pbrMetallicRoughness/", clear = R"("KHR_materials_transmission":{)";
  const std::vector<OddFactor> cases{
      {R"("pbrMetallicRoughness":{"baseColorFactor":[1,1,7,1]})",
       pbr + "baseColorFactor/2: 7; expected 0 to 1; 1 is taken",
       [](const v1::Material& m) { return m.physical().base_color().value().b(); }, 1},
      {R"("pbrMetallicRoughness":{"baseColorFactor":[0,0,0.5]})",
       pbr + "baseColorFactor: an array of 3; expected 4 numbers; the others are the default",
       [](const v1::Material& m) { return m.physical().base_color().value().b(); }, .5},
      {R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,-2]})",
       pbr + "baseColorFactor/3: -2; expected 0 to 1; 0 is taken",
       [](const v1::Material& m) { return m.opacity().value(); }, 0},
      {R"("pbrMetallicRoughness":{"metallicFactor":-1})",
       pbr + "metallicFactor: -1; expected 0 to 1; 0 is taken",
       [](const v1::Material& m) { return m.physical().metallic().value(); }, 0},
      {R"("emissiveFactor":[3,-3,0])", "emissiveFactor/1: -3; expected 0 or more; 0 is taken",
       [](const v1::Material& m) { return m.physical().emission().value().r(); }, 3},
      {R"("alphaMode":"MASK","alphaCutoff":-0.5)",
       "alphaCutoff: -0.5; expected 0 or more; 0 is taken",
       [](const v1::Material& m) { return m.alpha_cutoff(); }, 0},
      {R"("extensions":{)" + clear + R"("transmissionFactor":5}})",
       "extensions/KHR_materials_transmission/transmissionFactor: 5; expected 0 to 1; 1 is taken",
       [](const v1::Material& m) { return m.physical().transmission().value(); }, 1},
      {R"("extensions":{)" + clear + R"(},"KHR_materials_volume":{"thicknessFactor":-2}})",
       "extensions/KHR_materials_volume/thicknessFactor: -2; expected 0 or more; 0 is taken",
       [](const v1::Material& m) { return m.physical().thin() ? 1. : 0; }, 1},
      {R"("extensions":{"KHR_materials_volume":{"attenuationDistance":-2,)"
       R"("attenuationColor":[0.5,1,1]}})",
       "extensions/KHR_materials_volume/attenuationDistance: -2; expected a number above 0; it is "
       "left out",
       [](const v1::Material& m) { return m.physical().absorption().r(); }, 0},
      {R"("extensions":{"KHR_materials_volume":{"attenuationDistance":1,)"
       R"("attenuationColor":[1,2,1]}})",
       "extensions/KHR_materials_volume/attenuationColor/1: 2; expected 0 to 1; 1 is taken",
       [](const v1::Material& m) { return m.physical().absorption().g(); }, 0},
  };
  for (const OddFactor& c : cases) {
    const LoadedScene loaded = read(material(c.body));
    EXPECT_EQ(c.value(loaded.scene.materials(0)), c.taken) << c.body;
    EXPECT_EQ(only_warning(loaded), "materials/0/" + c.warning);
  }
}

TEST(Gltf, OddMaterialsDoNotCostTheFile) {
  const LoadedScene loaded = read(material(
      R"("pbrMetallicRoughness":{"baseColorFactor":[-1,0.5,1,1],"metallicFactor":1.0000001,)"
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

TEST(Gltf, ColoursOfVerticesAreLimited) {
  const LoadedScene loaded = read(
      Binary()
          .put(kSquare)
          .put(Floats{1, 1, 1, 1, 5, 1, 1, 1, 1, -2, 1, 1})
          .glb(kNode + mesh(R"({"attributes":{"POSITION":0,"COLOR_0":1}})") + R"(,"accessors":[)" +
               accessor(0, 5126, 3, "VEC3") + "," + accessor(1, 5126, 3, "VEC4") + "]"));
  EXPECT_EQ(first_mesh(loaded).colors, (Floats{1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 1, 1}));
  EXPECT_EQ(only_warning(loaded),
            "meshes/0/primitives/0/attributes/COLOR_0: a component of 5; expected 0 to 1; the "
            "nearest one is taken");
}

}  // namespace
}  // namespace tessera::gltf_files
