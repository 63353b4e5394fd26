#include "scenes/formats/gltf/gltf_reader.h"

#include <gtest/gtest.h>

#include "renderer/math/elementary.h"
#include "scenes/formats/gltf/gltf_value.h"
#include "tests/unit/scenes/formats/gltf/gltf_files.h"

namespace tessera::gltf_files {
namespace {

Indices triangles_of_mode(int mode, const std::vector<uint8_t>& corners) {
  const std::string file = Binary().put(kSquare).put(corners).glb(
      kNode +
      mesh(R"({"attributes":{"POSITION":0},"indices":1,"mode":)" + std::to_string(mode) + "}") +
      R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," +
      accessor(1, 5121, static_cast<int>(corners.size()), "SCALAR") + "]");
  const LoadedScene loaded = read(file);
  return loaded.scene.nodes_size() == 0 ? Indices{} : first_mesh(loaded).triangles;
}

TEST(Gltf, ReadsTrianglesStripsAndFans) {
  EXPECT_EQ(triangles_of_mode(4, {0, 1, 2, 0, 2, 3}), (Indices{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(triangles_of_mode(5, {0, 1, 3, 2}), (Indices{0, 1, 3, 3, 1, 2}));
  EXPECT_EQ(triangles_of_mode(6, {0, 1, 2, 3}), (Indices{1, 2, 0, 2, 3, 0}));
  EXPECT_EQ(triangles_of_mode(5, {0, 1, 1, 2}), Indices{}) << "a strip's joints have no surface";
}

TEST(Gltf, ReadsInterleavedNormalisedAndSparseAccessors) {
  // Rows of position, normal (bytes, one spare), uv (shorts) and colour (bytes): 24 bytes.
  std::string rows;
  const auto put = [&](auto value) {
    rows.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (int i = 0; i < 3; ++i) {
    for (const float c : {float(i == 1), float(i == 2), 0.f}) put(c);
    for (const int8_t c : {0, -128, 127, 0}) put(c);
    for (const uint16_t c : {0, 65535}) put(c);
    for (const uint8_t c : {255, 51, 0, 102}) put(c);
  }
  const std::string file =
      Binary()
          .put(std::vector<char>(rows.begin(), rows.end()), 24)
          .put(std::vector<uint16_t>{1})
          .put(Floats{5, 6, 7})
          .glb(kNode +
               mesh(R"({"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"COLOR_0":3}})") +
               R"(,"accessors":[)" +
               accessor(0, 5126, 3, "VEC3",
                        R"(,"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},)"
                        R"("values":{"bufferView":2}})") +
               "," + accessor(0, 5120, 3, "VEC3", R"(,"byteOffset":12,"normalized":true)") + "," +
               accessor(0, 5123, 3, "VEC2", R"(,"byteOffset":16,"normalized":true)") + "," +
               accessor(0, 5121, 3, "VEC4", R"(,"byteOffset":20,"normalized":true)") + "]");
  const Mesh m = first_mesh(read(file));
  EXPECT_EQ(m.positions, (Floats{0, 0, 0, 5, 6, 7, 0, 1, 0}));
  EXPECT_EQ(Floats(m.normals.begin(), m.normals.begin() + 3), (Floats{0, -1, 1}));
  EXPECT_EQ(Floats(m.uvs.begin(), m.uvs.begin() + 2), (Floats{0, 0})) << "v runs up here";
  EXPECT_EQ(Floats(m.colors.begin(), m.colors.begin() + 4), (Floats{1, .2f, 0, .4f}));
  EXPECT_EQ(m.triangles, (Indices{0, 1, 2}));
}

TEST(Gltf, MakesOneMeshOfPrimitivesOverTheSameVertices) {
  const std::string file =
      Binary()
          .put(kSquare)
          .put(std::vector<uint16_t>{1, 2, 3, 1, 3, 2, 0, 1, 2})
          .glb(kNode +
               mesh(R"({"attributes":{"POSITION":0},"indices":1,"material":0},)"
                    R"({"attributes":{"POSITION":0},"indices":2,"material":1},)"
                    R"({"attributes":{"POSITION":0,"NORMAL":0},"indices":1,"material":1})") +
               R"(,"materials":[{"name":"m"},{"name":"m"}],"accessors":[)" +
               accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5123, 3, "SCALAR") + "," +
               accessor(1, 5123, 3, "SCALAR", R"(,"byteOffset":6)") + "]");
  const LoadedScene loaded = read(file);
  ASSERT_EQ(loaded.scene.nodes_size(), 1);
  ASSERT_EQ(loaded.scene.nodes(0).children_size(), 2);
  const v1::Shape& both = loaded.scene.nodes(0).children(0).shape();
  const Mesh m = mesh_of(both, loaded.blobs);
  EXPECT_EQ(m.triangles, (Indices{0, 1, 2, 0, 2, 1})) << "only the vertices that are used";
  EXPECT_EQ(m.positions, Floats(kSquare.begin() + 3, kSquare.end()));
  EXPECT_EQ(m.face_materials, (Indices{0, 1}));
  EXPECT_EQ(both.materials(0), "m");
  EXPECT_EQ(both.materials(1), "m#2");
}

TEST(Gltf, AddsMorphTargetsByTheirWeights) {
  // Accessors: 0 positions, 1 normals, 2 offsets up, 3 offsets of one vertex (sparse), 4 its turn.
  const auto file = [](const std::string& nodes, const std::string& weights) {
    return Binary()
        .put(kSquare)
        .put(Floats{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1})
        .put(Floats{0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2})
        .put(std::vector<uint8_t>{2})
        .put(Floats{4, 0, 0})
        .glb("\"nodes\":[" + nodes + "]," + R"("meshes":[{)" + weights +
             R"("primitives":[{"attributes":{"POSITION":0,"NORMAL":1},)"
             R"("mode":6,"targets":[{"POSITION":2},{"POSITION":3,"NORMAL":3}]}]}],"accessors":[)" +
             accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5126, 4, "VEC3") + "," +
             accessor(2, 5126, 4, "VEC3") +
             R"(,{"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,"indices":)"
             R"({"bufferView":3,"componentType":5121},"values":{"bufferView":4}}}])");
  };
  const Mesh own = first_mesh(read(file(R"({"mesh":0})", R"("weights":[0.5,0.25],)")));
  EXPECT_EQ(own.positions, (Floats{0, 0, 1, 1, 0, 1, 2, 1, 1, 0, 1, 1}));
  EXPECT_EQ(own.normals, (Floats{0, 0, 1, 0, 0, 1, 1, 0, 1, 0, 0, 1}));
  const LoadedScene three =
      read(file(R"({"mesh":0,"weights":[1,0]},{"mesh":0},{"mesh":0})", R"("weights":[0,-0.25],)"));
  EXPECT_EQ(first_mesh(three).positions, (Floats{0, 0, 2, 1, 0, 2, 1, 1, 2, 0, 1, 2}))
      << "the node's go before";
  ASSERT_EQ(three.scene.objects_size(), 1) << "of the two that show the mesh by its own weights";
  EXPECT_EQ(mesh_of(three.scene.objects(0).nodes(0).shape(), three.blobs).positions,
            (Floats{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(three.unused, std::vector<std::string>{});
  const LoadedScene rest = read(file(R"({"mesh":0})", R"("weights":[0,0],)"));
  EXPECT_EQ(first_mesh(rest).positions, kSquare);
  EXPECT_EQ(rest.warnings, std::vector<std::string>{});
  const LoadedScene fewer = read(file(R"({"mesh":0,"weights":[1]})", ""));
  EXPECT_EQ(first_mesh(fewer).positions, (Floats{0, 0, 2, 1, 0, 2, 1, 1, 2, 0, 1, 2}));
  EXPECT_EQ(fewer.warnings,
            std::vector<std::string>{"t.glb: meshes/0/primitives/0: 2 morph targets; expected 1, "
                                     "one a weight; the others have no weight"});
  const LoadedScene beyond = read(file(R"({"mesh":0,"weights":[1e300,0]})", ""));
  EXPECT_EQ(beyond.scene.nodes_size(), 0);
  EXPECT_EQ(beyond.repairs.size(), 2u);
}

/// In time that grows with the square of their number these would outlast the test's time limit.
TEST(Gltf, ManyMorphTargetsAndNodesTakeTimeInTheirNumber) {
  const auto list = [](size_t count, const std::string& entry, const std::string& last) {
    std::string text;
    for (size_t i = 1; i < count; ++i) text += entry + ",";
    return "[" + text + last + "]";
  };
  constexpr size_t kTargets = 1'200'000, kNodes = 30'000;
  const LoadedScene loaded =
      read(Binary()
               .put(kSquare)
               .put(Floats{0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2})
               .glb(R"("nodes":)" + list(kNodes, R"({"mesh":0})", R"({"mesh":0})") +
                    R"(,"meshes":[{"weights":)" + list(kTargets, "0", "0.5") +
                    R"(,"primitives":[{"attributes":{"POSITION":0},"mode":6,"targets":)" +
                    list(kTargets, "{}", R"({"POSITION":1})") + R"(}]}],"accessors":[)" +
                    accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5126, 4, "VEC3") + "]"));
  ASSERT_EQ(loaded.scene.objects_size(), 1);
  EXPECT_EQ(mesh_of(loaded.scene.objects(0).nodes(0).shape(), loaded.blobs).positions,
            (Floats{0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1}));
  EXPECT_EQ(loaded.scene.nodes_size(), static_cast<int>(kNodes));
}

TEST(Gltf, PlacesNodesAndSharesMeshes) {
  const LoadedScene loaded = read(Binary().put(kSquare).glb(
      R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[)"
      R"({"translation":[1,2,3],"rotation":[0,0,0.7071067811865476,0.7071067811865476],)"
      R"("children":[1,2]},{"mesh":0,"scale":[2,-2,2]},)"
      R"({"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1]},{"mesh":0}],)" +
      kTriangle));
  ASSERT_EQ(loaded.scene.nodes_size(), 2) << "the last node is in no scene";
  ASSERT_EQ(loaded.scene.objects_size(), 1);
  EXPECT_EQ(loaded.blobs.size(), 2u);
  const auto rows = [&](int node) {
    const auto& in = loaded.scene.nodes(node).transform().steps(0).matrix().rows();
    return std::vector<double>(in.begin(), in.end());
  };
  const std::vector<double> scaled{0, 2, 0, 1, 2, 0, 0, 2, 0, 0, 2, 3};
  for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(rows(0)[i], scaled[i], 1e-12) << i;
  EXPECT_NEAR(rows(1)[3], 1, 1e-12);
  EXPECT_NEAR(rows(1)[7], 7, 1e-12);
  EXPECT_EQ(loaded.scene.nodes(1).instance_of(), loaded.scene.objects(0).name());
  EXPECT_EQ(loaded.unused, std::vector<std::string>{"node 3"});
}

TEST(Gltf, ConvertsLightsAndCameras) {
  const LoadedScene loaded =
      read(R"({"asset":{"version":"2.0"},"nodes":[)"
           R"({"translation":[0,5,0],"rotation":[-0.7071067811865476,0,0,0.7071067811865476],)"
           R"("scale":[3,3,3],"extensions":{"KHR_lights_punctual":{"light":0}}},)"
           R"({"extensions":{"KHR_lights_punctual":{"light":1}}},{"camera":0,"name":"eye"},)"
           R"({"camera":1,"name":"plan"}],"cameras":[)"
           R"({"type":"perspective","perspective":{"yfov":0.7853981633974483,"znear":0.1}},)"
           R"({"type":"orthographic","orthographic":{"xmag":2,"ymag":1,"znear":0,"zfar":9}}],)"
           R"("extensions":{"KHR_lights_punctual":{"lights":[)"
           R"({"type":"spot","intensity":10,"range":7,"spot":{"innerConeAngle":0.1,)"
           R"("outerConeAngle":0.5}},{"type":"directional","color":[1,0.5,0]}]}}})");
  const v1::Light& spot = loaded.scene.nodes(0).light();
  EXPECT_EQ(loaded.scene.nodes(0).transform().steps_size(), 0) << "a scale does not reach lights";
  EXPECT_NEAR(spot.intensity() * portable::kPi, 10, 1e-12);
  EXPECT_EQ(spot.attenuation().quadratic(), 1);
  EXPECT_EQ(spot.radius(), 7);
  EXPECT_EQ(spot.spot().position().y(), 5);
  EXPECT_NEAR(spot.spot().direction().y(), -1, 1e-12);
  EXPECT_NEAR(spot.spot().beam_width(), portable::degrees(.1), 1e-12);
  EXPECT_NEAR(spot.spot().cut_off(), portable::degrees(.5), 1e-12);
  const v1::Light& sun = loaded.scene.nodes(1).light();
  EXPECT_EQ(sun.directional().direction().z(), -1);
  EXPECT_EQ(sun.color().g(), .5);
  EXPECT_NEAR(sun.intensity() * portable::kPi, 1, 1e-12);
  ASSERT_EQ(loaded.scene.cameras_size(), 2);
  EXPECT_EQ(loaded.scene.cameras(0).name(), "eye");
  EXPECT_NEAR(loaded.scene.cameras(0).perspective().field_of_view(), 45, 1e-12);
  EXPECT_EQ(loaded.scene.cameras(0).perspective().axis(), v1::Perspective::VERTICAL);
  EXPECT_EQ(loaded.scene.cameras(1).orthographic().min_x(), -2);
  EXPECT_EQ(loaded.scene.cameras(1).orthographic().max_y(), 1);
}

TEST(Gltf, ConvertsMaterials) {
  const std::string textures =
      R"(,"images":[{"uri":"data:image/png;base64,AAEC"},{"bufferView":0}],)"
      R"("samplers":[{"wrapS":33071,"wrapT":33648,"magFilter":9728}],)"
      R"("textures":[{"source":0,"sampler":0},{"source":1}])";
  const LoadedScene loaded = read(material(
      R"("pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],"metallicFactor":0.5,)"
      R"("baseColorTexture":{"index":0},"metallicRoughnessTexture":{"index":1}},)"
      R"("normalTexture":{"index":1,"scale":2},"occlusionTexture":{"index":1},)"
      R"("emissiveFactor":[1,1,1],"emissiveTexture":{"index":0},"alphaMode":"BLEND",)"
      R"("extensions":{"KHR_materials_transmission":{"transmissionFactor":0.7},)"
      R"("KHR_materials_ior":{"ior":1.33},)"
      R"("KHR_materials_emissive_strength":{"emissiveStrength":4}})",
      textures));
  ASSERT_EQ(loaded.scene.materials_size(), 1);
  const v1::Material& m = loaded.scene.materials(0);
  const v1::Physical& p = m.physical();
  EXPECT_EQ(p.base_color().value().b(), .3);
  EXPECT_EQ(p.metallic().value(), .5);
  EXPECT_EQ(p.metallic().channel(), v1::FloatInput::BLUE);
  EXPECT_EQ(p.roughness().value(), 1);
  EXPECT_EQ(p.roughness().channel(), v1::FloatInput::GREEN);
  EXPECT_EQ(p.occlusion().channel(), v1::FloatInput::RED);
  EXPECT_EQ(p.metallic().texture(), p.occlusion().texture());
  EXPECT_EQ(p.emission().value().g(), 4);
  EXPECT_EQ(p.transmission().value(), .7);
  EXPECT_TRUE(p.thin()) << "no volume";
  EXPECT_EQ(p.refractive_index(), 1.33);
  EXPECT_EQ(m.alpha(), v1::Material::ALPHA_BLEND);
  EXPECT_EQ(m.opacity().value(), .4);
  EXPECT_EQ(m.normal_scale(), 2);
  EXPECT_EQ(m.sides(), v1::Material::FRONT_ONLY);
  ASSERT_EQ(loaded.scene.textures_size(), 2);
  const v1::Texture::Image& color = loaded.scene.textures(0).image();
  EXPECT_EQ(color.encoding(), v1::Texture::Image::ENCODING_SRGB);
  EXPECT_EQ(color.wrap_s(), v1::Texture::Image::CLAMP);
  EXPECT_EQ(color.wrap_t(), v1::Texture::Image::MIRROR);
  EXPECT_EQ(color.filter(), v1::Texture::Image::NEAREST);
  EXPECT_EQ(loaded.pictures.at(color.file()), std::string("\0\1\2", 3));
  const v1::Texture::Image& numbers = loaded.scene.textures(1).image();
  EXPECT_EQ(numbers.encoding(), v1::Texture::Image::ENCODING_LINEAR);
  EXPECT_EQ(loaded.pictures.at(numbers.file()).size(), 48u);
}

TEST(Gltf, ConvertsOtherKindsOfMaterials) {
  const auto first = [](const std::string& body) {
    return read(material(body)).scene.materials(0);
  };
  const v1::Material glass =
      first(R"("extensions":{"KHR_materials_transmission":{"transmissionFactor":1},)"
            R"("KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,)"
            R"("attenuationColor":[1,0.5,0]}})");
  EXPECT_FALSE(glass.physical().thin());
  EXPECT_EQ(glass.sides(), v1::Material::TWO_SIDED) << "light has to leave through back faces";
  EXPECT_EQ(glass.physical().absorption().r(), 0);
  EXPECT_NEAR(glass.physical().absorption().g(), .34657359, 1e-8);
  const v1::Material flat =
      first(R"("extensions":{"KHR_materials_unlit":{}},"doubleSided":true,"alphaMode":"MASK",)"
            R"("alphaCutoff":0.3,"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,0.25]})");
  EXPECT_EQ(flat.unlit().color().value().g(), 0);
  EXPECT_EQ(flat.sides(), v1::Material::TWO_SIDED);
  EXPECT_EQ(flat.alpha(), v1::Material::ALPHA_MASK);
  EXPECT_EQ(flat.alpha_cutoff(), .3);
  EXPECT_EQ(flat.opacity().value(), .25);
  EXPECT_EQ(first(R"("name":"plain")").alpha(), v1::Material::ALPHA_OPAQUE);
}

TEST(Gltf, ConvertsSpecularGlossiness) {
  const auto read_model = [](const std::string& model, const std::string& more = "") {
    return read(material(R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":)"
                         R"([0,0,1,1]},"extensions":{"KHR_materials_pbrSpecularGlossiness":{)" +
                             model + "}}",
                         R"(,"extensionsUsed":["KHR_materials_pbrSpecularGlossiness"],)"
                         R"("extensionsRequired":["KHR_materials_pbrSpecularGlossiness"])" +
                             more));
  };
  const LoadedScene plastic =
      read_model(R"("diffuseFactor":[0.8,0.4,0.2,0.5],"specularFactor":[0.04,0.04,0.04],)"
                 R"("glossinessFactor":0.75,"diffuseTexture":{"index":0})",
                 R"(,"images":[{"uri":"x.png"}],"textures":[{"source":0}])");
  EXPECT_EQ(plastic.warnings, std::vector<std::string>{});
  const v1::Physical& p = plastic.scene.materials(0).physical();
  EXPECT_NEAR(p.base_color().value().r(), .8, 1e-12);
  EXPECT_NEAR(p.base_color().value().b(), .2, 1e-12);
  EXPECT_NE(p.base_color().texture(), "");
  EXPECT_NEAR(p.metallic().value(), 0, 1e-12);
  EXPECT_EQ(p.roughness().value(), .25);
  EXPECT_EQ(plastic.scene.materials(0).opacity().value(), .5);

  // The extension's own example: gold.
  const v1::Physical gold = read_model(R"("diffuseFactor":[0,0,0,1],"specularFactor":)"
                                       R"([1,0.766,0.336],"glossinessFactor":0.9)")
                                .scene.materials(0)
                                .physical();
  EXPECT_NEAR(gold.metallic().value(), 1, 1e-12);
  EXPECT_NEAR(gold.base_color().value().r(), 1, 1e-12);
  EXPECT_NEAR(gold.base_color().value().g(), .766, 1e-12);
  EXPECT_NEAR(gold.base_color().value().b(), .336, 1e-12);

  // Between the two: both models send on as much light, head on and otherwise.
  const v1::Physical grey = read_model(R"("diffuseFactor":[0.5,0.5,0.5,1],"specularFactor":)"
                                       R"([0.3,0.3,0.3])")
                                .scene.materials(0)
                                .physical();
  const double m = grey.metallic().value();
  const double base = .5 * .7 / .96 / (1 - m);
  EXPECT_GT(m, .1);
  EXPECT_LT(m, .9);
  EXPECT_NEAR(.04 * (1 - m) + base * m, .3, 1e-12) << "F0 is the specular colour";

  const LoadedScene packed = read_model(R"("specularGlossinessTexture":{"index":0})");
  ASSERT_EQ(packed.warnings.size(), 1u);
  EXPECT_NE(packed.warnings[0].find("specularGlossinessTexture is not read; "), std::string::npos);
  EXPECT_NEAR(packed.scene.materials(0).physical().metallic().value(), 0, 1e-12);
  EXPECT_EQ(packed.scene.materials(0).physical().roughness().value(), .5);
}

TEST(Gltf, TellsOnceOfAnExtensionThatIsRequiredAndUsed) {
  EXPECT_EQ(read(material(R"("extensions":{"KHR_materials_sheen":{}})",
                          R"(,"extensionsUsed":["KHR_materials_sheen"],)"
                          R"("extensionsRequired":["KHR_materials_sheen"])"))
                .warnings.size(),
            1u);
}

TEST(Gltf, TurnsTextureTransformsOver) {
  // glTF: u' = 2 u + .25, v' = 3 v + .5 with v down; so up' = 1 - v' = 3 up - 2.5.
  const LoadedScene loaded =
      read(material(R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":)"
                    R"({"KHR_texture_transform":{"offset":[0.25,0.5],"scale":[2,3]}}}})",
                    R"(,"images":[{"uri":"x.png"}],"textures":[{"source":0}])"));
  const auto& rows = loaded.scene.textures(0).transform().steps(0).matrix().rows();
  const std::vector<double> expected{2, 0, 0, .25, 0, 3, 0, -2.5, 0, 0, 1, 0};
  EXPECT_EQ(std::vector<double>(rows.begin(), rows.end()), expected);
  EXPECT_EQ(loaded.scene.textures(0).image().file(), "x.png");
}

TEST(Gltf, AMaterialTakesTwoSetsOfTextureCoordinates) {
  const auto square_of = [](const std::string& pictures, const std::string& sets) {
    return read(
        Binary()
            .put(kSquare)
            .put(Floats{0, 0, 1, 0, 1, 1, 0, 1})
            .put(Floats{.5, .25, .5, .25, .5, .25, .5, .25})
            .glb(kNode +
                 mesh(R"({"attributes":{"POSITION":0)" + sets + R"(},"material":0,"mode":6})") +
                 R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," +
                 accessor(1, 5126, 4, "VEC2") + "," + accessor(2, 5126, 4, "VEC2") +
                 R"(],"images":[{"uri":"x.png"}],"textures":[{"source":0}],)"
                 R"("materials":[{)" +
                 pictures + "}]"));
  };
  const std::string base =
                        R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}})",
                    baked = R"(,"occlusionTexture":{"index":0})",
                    both = R"(,"TEXCOORD_0":1,"TEXCOORD_1":2)";
  const auto uvs = [](const LoadedScene& loaded) {
    const v1::TriangleMesh& in = loaded.scene.nodes(0).shape().mesh();
    return std::make_pair(blob_values<float>(in.uvs(), loaded.blobs),
                          blob_values<float>(in.second_uvs(), loaded.blobs));
  };
  const Floats up{0, 1, 1, 1, 1, 0, 0, 0}, level{.5, .75, .5, .75, .5, .75, .5, .75};
  const LoadedScene two = square_of(base + baked, both);
  EXPECT_EQ(uvs(two), std::make_pair(level, up));
  EXPECT_EQ(two.warnings, std::vector<std::string>{});
  ASSERT_EQ(two.scene.textures_size(), 2);
  EXPECT_EQ(two.scene.textures(0).mapping(), v1::Texture::UV);
  EXPECT_EQ(two.scene.textures(1).mapping(), v1::Texture::SECOND_UV);
  EXPECT_EQ(two.scene.materials(0).physical().occlusion().texture(), two.scene.textures(1).name());

  EXPECT_EQ(uvs(square_of(base, both)), std::make_pair(level, Floats{}))
      << "not what nothing takes";
  const LoadedScene lacks = square_of(base + baked, R"(,"TEXCOORD_1":2)");
  EXPECT_EQ(uvs(lacks), std::make_pair(level, Floats{}));

  const LoadedScene three = square_of(
      base + baked + R"(,"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0,"texCoord":2})",
      both);
  EXPECT_EQ(uvs(three), std::make_pair(level, up));
  ASSERT_EQ(three.warnings.size(), 1u);
  EXPECT_NE(three.warnings[0].find("more than two sets of texture coordinates"), std::string::npos)
      << three.warnings[0];
}

LoadedScene square_with_tangents(const Floats& tangents) {
  return read(Binary()
                  .put(kSquare)
                  .put(Floats{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1})
                  .put(tangents)
                  .glb(kNode +
                       mesh(R"({"attributes":{"POSITION":0,"NORMAL":1,"TANGENT":2},"mode":6})") +
                       R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," +
                       accessor(1, 5126, 4, "VEC3") + "," + accessor(2, 5126, 4, "VEC4") + "]"));
}

TEST(Gltf, TangentsAreRead) {
  const Floats tangents{0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, -1, 0, 1, 0, -1};
  const LoadedScene loaded = square_with_tangents(tangents);
  const v1::TriangleMesh& in = loaded.scene.nodes(0).shape().mesh();
  EXPECT_EQ(blob_values<float>(in.tangents(), loaded.blobs), tangents);
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
}

TEST(Gltf, TangentsThatSayNothingAreTold) {
  const LoadedScene loaded =
      square_with_tangents({0, 1, 0, 1, 0, 0, -3, 1, 0, 0, 0, -1, 0, 1, 0, -1});
  const v1::TriangleMesh& in = loaded.scene.nodes(0).shape().mesh();
  EXPECT_EQ(blob_values<float>(in.tangents(), loaded.blobs),
            (Floats{0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1, 0, 1, 0, -1}));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(loaded.warnings[0].find("2 tangents of length 0 or along the normal"),
            std::string::npos)
      << loaded.warnings[0];
}

TEST(Gltf, ListsWhatItDoesNotUse) {
  const LoadedScene loaded = read(Binary().put(kSquare).glb(
      R"("extensionsUsed":["KHR_materials_sheen"],"nodes":[{"mesh":0,"extensions":)"
      R"({"EXT_said_nowhere":{}}}],)" +
      mesh(R"({"attributes":{"POSITION":0,"COLOR_1":0,"_TEMPERATURE":0}},)"
           R"({"attributes":{"POSITION":0,"COLOR_1":0}})") +
      R"(,"accessors":[)" + accessor(0, 5126, 3, "VEC3") + "]"));
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{"t.glb: extension 'EXT_said_nowhere' is not read",
                                      "t.glb: extension 'KHR_materials_sheen' is not read",
                                      "t.glb: attribute COLOR_1 is not used",
                                      "t.glb: attribute _TEMPERATURE is not used"}));
}

TEST(GltfValue, FindsPlacesInJson) {
  const std::string text =
      "{ \"a\\\"b\" : [ {}, \"}]\" ],\n  \"c\": { \"d\": [1, [2, 3], true] } }";
  const auto place = [&](const char* path) { return find_json_place(text, path); };
  EXPECT_EQ(place("c"), std::pair(2, 8));
  EXPECT_EQ(place("c/d/0"), std::pair(2, 16));
  EXPECT_EQ(place("c/d/1/1"), std::pair(2, 23));
  EXPECT_EQ(place("c/d/2"), std::pair(2, 27));
  EXPECT_EQ(place("c/e"), std::pair(0, 0));
  EXPECT_EQ(place("c/d/3"), std::pair(0, 0));
}

}  // namespace
}  // namespace tessera::gltf_files
