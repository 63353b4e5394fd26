#include "scenes/formats/read_scene.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <span>

#include "renderer/math/encodings.h"
#include "renderer/math/vec.h"
#include "scenes/formats/scene_summary.h"
#include "scenes/generate/generate_scene.h"
#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class ReadScene : public testing::Test {
 protected:
  ReadScene() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    outside_ = fs::path(testing::TempDir()) / (std::string("tessera_read_scene_") + test->name());
    fs::remove_all(outside_);
    folder_ = outside_ / "scene";
    fs::create_directories(folder_);
  }
  ~ReadScene() override { fs::remove_all(outside_); }

  std::string write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return (folder_ / name).string();
  }
  std::string error(const std::string& path) {
    std::string message = error_of([&] { read_scene(path); });
    for (size_t at; (at = message.find(folder_.string() + "/")) != std::string::npos;)
      message.erase(at, folder_.string().size() + 1);
    return message;
  }

  static constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  fs::path outside_, folder_;
};

TEST_F(ReadScene, RefusesWhatIsNoSceneFile) {
  EXPECT_EQ(error((folder_ / "none.obj").string()), "none.obj: no such file");
  EXPECT_EQ(error((folder_ / "none").string()), "none: no such file");
  EXPECT_EQ(error(write("empty.x3d", "")), "empty.x3d: the file is empty");
  fs::create_directories(folder_ / "folder.obj");
  EXPECT_EQ(error((folder_ / "folder.obj").string()), "folder.obj: is a folder; expected a file");
  const std::string known =
      "one of .tessera, .tesserab, .json, .obj, .ply, .stl, .gltf, .glb, .x3d, "
      ".x3dv, .wrl, .crt";
  EXPECT_EQ(error(write("a.fbx", "{}")),
            "a.fbx: files of type .fbx are not read; expected " + known);
  EXPECT_EQ(error(write("a.xyz", "0 0 0")), "a.xyz: unknown ending '.xyz'; expected " + known);
  EXPECT_EQ(error(write("b.tesserab", "\x01\x02")).substr(0, 24), "b.tesserab: the bytes ar");
  EXPECT_EQ(read_scene(write("by_content", "<X3D><Scene/></X3D>")).scene.cameras_size(), 1);
}

TEST_F(ReadScene, StepsOverAByteOrderMark) {
  const std::string mark = "\xEF\xBB\xBF";
  const std::string facet =
      "FACET NORMAL 0 0 1 OUTER LOOP VERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0 1 0 ENDLOOP ENDFACET\n";
  const LoadedScene part = read_scene(write("part", mark + "SOLID part\n" + facet));
  EXPECT_TRUE(part.scene.nodes(0).shape().has_mesh()) << "the content says what the file is";
  const std::string script =
      "cam = Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> 60 }\n"
      "Settings { camera -> cam }\nScene { }\n";
  EXPECT_EQ(read_scene(write("a.crt", mark + script)).scene.cameras_size(), 1);
  EXPECT_EQ(error(write("b.crt", mark + "1 +")).substr(0, 8), "b.crt:1:");
}

/// What a text is in another encoding, or with two of the marks before it, of each text format.
TEST_F(ReadScene, TellsOfTextInUtf16AndStepsOverMarks) {
  const std::string stl =
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid s\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 "
      "0\n3 0 1 2\n";
  write("m.obj", std::string("mtllib m.mtl\nusemtl m\n") + kTriangle);
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"a.tessera", "nodes { }"},
           {"a.json", "{ }"},
           {"a.obj", kTriangle},
           {"m.mtl", "newmtl m\n"},
           {"a.ply", ply},
           {"a.stl", stl},
           {"a.gltf", R"({"asset":{"version":"2.0"}})"},
           {"a.x3d", "<X3D><Scene/></X3D>"},
           {"a.wrl", "#VRML V2.0 utf8\n"},
           {"a.crt",
            "cam = Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> 60 }\n"
            "Settings { camera -> cam }\nScene { }\n"}}) {
    const std::string read = name == "m.mtl" ? "m.obj" : name;
    write(name, "\xEF\xBB\xBF\xEF\xBB\xBF" + text);
    EXPECT_NO_THROW(read_scene((folder_ / read).string())) << name;
    for (const std::string mark : {"\xFF\xFE", "\xFE\xFF", ""}) {
      std::string wide;
      for (const char c : text)
        wide += mark == "\xFE\xFF" ? std::string{'\0', c} : std::string{c, '\0'};
      write(name, mark + wide);
      EXPECT_EQ(error((folder_ / read).string()),
                name +
                    ":1:1: text in UTF-16; expected UTF-8, as `iconv -f UTF-16 -t UTF-8` makes "
                    "of it");
    }
  }
}

TEST_F(ReadScene, ReadsAnEndingInAnyCase) {
  EXPECT_EQ(read_scene(write("T.OBJ", kTriangle)).scene.metadata().source_file(), "T.OBJ");
}

TEST_F(ReadScene, FindsMaterialsBesideAnObj) {
  write("my colours.mtl", "newmtl red\nKd 1 0 0\n");
  write("sub/b.mtl", "newmtl blue\nKd 0 0 1\n");
  std::ofstream(outside_ / "secret.mtl") << "newmtl green\nKd 0 1 0\n";
  const LoadedScene loaded = read_scene(
      write("t.obj", std::string("mtllib my colours.mtl\nmtllib sub\\b.mtl\nmtllib ../secret.mtl\n"
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl blue\n"
                                 "f 1 2 3\nusemtl green\nf 1 2 3\n")));
  ASSERT_EQ(loaded.scene.materials_size(), 3);
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().r(), 1);
  EXPECT_EQ(loaded.scene.materials(1).classic().diffuse().value().b(), 1);
  EXPECT_NEAR(loaded.scene.materials(2).classic().diffuse().value().g(), .8, 1e-9);
  EXPECT_EQ(loaded.warnings.size(), 2u) << testing::PrintToString(loaded.warnings);
}

TEST_F(ReadScene, GivesABareModelAView) {
  const LoadedScene loaded =
      read_scene(write("t.obj", "v 99 0 0\nv 101 0 0\nv 100 3 0\nf 1 2 3\n"));
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  const v1::LookAt& look = loaded.scene.cameras(0).world_from_camera().steps(0).look_at();
  EXPECT_NEAR(look.target().x(), 100, 1);
  EXPECT_GT(look.eye().z(), 2);
  EXPECT_EQ(summarize(loaded.scene, loaded.blobs).undefined.size(), 0u);
}

TEST_F(ReadScene, PlacesIncludedFilesOfAnyFormatOnce) {
  write("models/t.obj", kTriangle);
  write("models/s.x3d",
        "<X3D><Scene><Shape><Appearance><Material DEF='M'/></Appearance><Sphere/>"
        "</Shape><PointLight/></Scene></X3D>");
  const LoadedScene loaded = read_scene(
      write("main.tessera",
            "materials { name: 'M' }\n"
            "includes { file: 'models/t.obj' transform { steps { translate { x: 1 } } } }\n"
            "includes { file: 'models/t.obj' }\n"
            "includes { file: 'models/t.obj' material: 'M' }\n"
            "includes { file: 'models/s.x3d' geometry_only: true }\n"));
  const v1::Scene& scene = loaded.scene;
  EXPECT_EQ(scene.includes_size(), 0);
  ASSERT_EQ(scene.nodes_size(), 4);
  EXPECT_EQ(scene.nodes(0).transform().steps(0).translate().x(), 1);
  EXPECT_EQ(scene.nodes(0).instance_of(), scene.nodes(1).instance_of());
  EXPECT_NE(scene.nodes(0).instance_of(), scene.nodes(2).instance_of());
  ASSERT_EQ(scene.objects_size(), 3);
  EXPECT_EQ(scene.objects(1).nodes(0).shape().materials(0), "M");
  EXPECT_EQ(scene.cameras_size(), 0);
  EXPECT_EQ(summarize(scene, loaded.blobs).undefined, std::vector<std::string>{});
  EXPECT_EQ(loaded.blobs.size(), 2u);
}

TEST_F(ReadScene, CopiesLightsAndCamerasOfIncludedFilesIntoPlace) {
  write("s.x3d", "<X3D><Scene><Viewpoint DEF='V'/><PointLight/></Scene></X3D>");
  const LoadedScene loaded = read_scene(write(
      "main.tessera", "includes { file: 's.x3d' transform { steps { translate { y: 2 } } } }"));
  ASSERT_EQ(loaded.scene.nodes_size(), 1);
  EXPECT_TRUE(loaded.scene.nodes(0).children(0).light().has_point());
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  EXPECT_EQ(loaded.scene.cameras(0).name(), "s/V");
  EXPECT_EQ(loaded.scene.cameras(0).world_from_camera().steps(0).translate().y(), 2);
}

TEST_F(ReadScene, KeepsIncludesInsideTheFolderAndFreeOfCycles) {
  std::ofstream(outside_ / "t.obj") << kTriangle;
  EXPECT_NE(error(write("a.tessera", "includes { file: '../t.obj' }")).find("not inside"),
            std::string::npos);
  EXPECT_NE(error(write("b.tessera", "includes { file: '/etc/hostname' }")).find("not inside"),
            std::string::npos);
  fs::create_symlink(outside_ / "t.obj", folder_ / "link.obj");
  EXPECT_NE(error(write("c.tessera", "includes { file: 'link.obj' }")).find("not inside"),
            std::string::npos);
  write("d.tessera", "includes { file: 'e.tessera' }");
  EXPECT_NE(error(write("e.tessera", "includes { file: 'd.tessera' }")).find("in turn"),
            std::string::npos);
  EXPECT_EQ(error(write("f.tessera", "includes { file: 'g.obj' }")), "g.obj: no such file");
}

TEST(SceneSummary, TellsUsedUnusedAndUndefinedNamesApart) {
  v1::Scene scene;
  scene.add_materials()->set_name("red");
  scene.add_materials()->set_name("blue");
  scene.add_objects()->set_name("thing");
  v1::Node& node = *scene.add_nodes();
  node.mutable_shape()->mutable_sphere();
  node.mutable_shape()->add_materials("blu");
  scene.add_nodes()->set_instance_of("thing");
  scene.add_nodes()->mutable_light()->mutable_point();
  const SceneSummary summary = summarize(scene, {});
  EXPECT_EQ(summary.unused, (std::vector<std::string>{"material 'red'", "material 'blue'"}));
  EXPECT_EQ(summary.undefined, (std::vector<std::string>{"material 'blu'; did you mean 'blue'?"}));
  std::map<std::string, uint64_t> counts;
  for (const auto& [what, count] : summary.counts) counts[what] = count;
  EXPECT_EQ(counts["shapes, sphere"], 1u);
  EXPECT_EQ(counts["lights, point"], 1u);
  EXPECT_EQ(counts["instances"], 1u);
  EXPECT_EQ(counts["nodes"], 3u);
}

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

v1::Include placement(const std::string& file, double x) {
  v1::Include include;
  include.set_file(file);
  include.mutable_transform()->add_steps()->mutable_translate()->set_x(x);
  return include;
}

TEST_F(ReadScene, PlacesFilesOfAnyFolderAndTheSceneItself) {
  const std::string scene = write("a.obj", kTriangle);
  write("b.tessera", "includes { file: \"c.obj\" }");
  write("c.obj", kTriangle);
  fs::rename(folder_ / "b.tessera", outside_ / "b.tessera");
  fs::rename(folder_ / "c.obj", outside_ / "c.obj");
  ReadOptions options;
  options.placements = {placement((outside_ / "b.tessera").string(), 10),
                        placement((outside_ / "b.tessera").string(), 20), placement("", 30)};
  const LoadedScene loaded = read_scene(scene, options);
  const v1::Scene& s = loaded.scene;
  EXPECT_EQ(s.objects_size(), 2) << "b and c, however often they are placed";
  ASSERT_GE(s.nodes_size(), 1);
  const v1::Node& whole = s.nodes(0);
  EXPECT_EQ(whole.transform().steps(0).translate().x(), 30);
  ASSERT_EQ(whole.children_size(), 3);
  EXPECT_EQ(whole.children(1).transform().steps(0).translate().x(), 10);
  EXPECT_EQ(whole.children(2).transform().steps(0).translate().x(), 20);
  EXPECT_EQ(whole.children(1).instance_of(), whole.children(2).instance_of());
  // Points from 30 to 51 along x are in view: the model's own and those of both placements.
  ASSERT_EQ(s.cameras_size(), 1);
  const v1::Vec3& target = s.cameras(0).world_from_camera().steps(0).look_at().target();
  EXPECT_GT(target.x(), 35);
  EXPECT_LT(target.x(), 46);
}

TEST_F(ReadScene, GivesAModelOnlyWhatItCameWithout) {
  const std::string head = "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[";
  const std::string camera =
      "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1}}]";
  const std::string light =
      "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}}";
  const v1::Scene seen =
      read_scene(write("seen.gltf", head + "{\"camera\":0}]," + camera + "}")).scene;
  EXPECT_EQ(seen.cameras_size(), 1);
  EXPECT_EQ(seen.nodes_size(), 3) << "lights";
  const v1::Scene lit = read_scene(write("lit.gltf", head +
                                                         "{\"extensions\":{\"KHR_lights_punctual\":"
                                                         "{\"light\":0}}}]," +
                                                         light + "}"))
                            .scene;
  EXPECT_EQ(lit.cameras_size(), 1);
  EXPECT_EQ(lit.cameras(0).name(), "default");
  EXPECT_EQ(lit.nodes_size(), 1);
  EXPECT_FALSE(lit.settings().integrator().has_ambient());
}

TEST_F(ReadScene, LoadsPicturesFromBesideAndFromWithin) {
  ReadOptions options;
  std::vector<std::string> decoded;
  const DecodedTexture grey{
      .width = 1, .height = 1, .channels = 1, .bits = 8, .texels = make_blob({std::byte{7}})};
  options.decode_texture = [&](const std::string& path, bool) {
    decoded.push_back(fs::path(path).filename().string());
    return grey;
  };
  options.decode_texture_bytes = [&](std::string_view bytes, const std::string& name) {
    decoded.push_back(name + "=" + std::string(bytes));
    return grey;
  };
  write("there.png", "x");
  const std::string materials =
      "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},"
      "\"metallicRoughnessTexture\":{\"index\":1}},\"normalTexture\":{\"index\":2}}],"
      "\"textures\":[{\"source\":0},{\"source\":1},{\"source\":2}],"
      "\"images\":[{\"uri\":\"th%65re.png\"},{\"uri\":\"data:;base64,YWJj\"},{\"uri\":\"../"
      "x.png\"}]";
  const std::string triangle =
      "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
      "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
      "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":"
      "\"b%20c.bin\"}]";
  std::string floats(36, '\0');
  floats[15] = floats[27] = '?';
  write("b c.bin", floats);
  const LoadedScene loaded =
      read_scene(write("t.gltf", "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}]," +
                                     materials + "," + triangle + "}"),
                 options);
  EXPECT_EQ(decoded, (std::vector<std::string>{"there.png", "t.gltf#images/1=abc"}));
  EXPECT_TRUE(loaded.pictures.empty());
  ASSERT_EQ(loaded.scene.textures_size(), 2);
  EXPECT_EQ(loaded.scene.textures(1).image().width(), 1u);
  EXPECT_EQ(loaded.scene.materials(0).normal_map(), "") << "outside the folder";
  EXPECT_EQ(loaded.warnings.size(), 1u);
}

TEST_F(ReadScene, KeepsOfAPictureTheNumberThatAMapTakes) {
  ReadOptions options;
  options.decode_texture = [&](const std::string& path, bool) {
    const bool has_alpha = fs::path(path).filename() == "alpha.png";
    DecodedTexture blue{.width = 1, .height = 1, .channels = 3, .bits = 8, .texels = {}};
    std::vector<std::byte> texels{std::byte{10}, std::byte{20}, std::byte{200}};
    if (has_alpha) blue.channels = 4, texels.push_back(std::byte{77});
    blue.texels = make_blob(std::move(texels));
    return blue;
  };
  write("a.obj", std::string("mtllib a.mtl\nusemtl a\n") + kTriangle);
  write("plain.png", "x");
  write("alpha.png", "x");
  const auto texel = [&](const std::string& statement) {
    write("a.mtl", "newmtl a\n" + statement + "\n");
    const LoadedScene loaded = read_scene((folder_ / "a.obj").string(), options);
    const v1::Texture::Image& image = loaded.scene.textures(0).image();
    EXPECT_EQ(image.channels(), 1u);
    EXPECT_TRUE(loaded.picture_channels.empty());
    if (image.bits() == 8)
      return double{static_cast<double>(blob_values<uint8_t>(image.texels(), loaded.blobs).at(0))};
    return double{half_to_float(blob_values<uint16_t>(image.texels(), loaded.blobs).at(0))};
  };
  EXPECT_EQ(texel("bump plain.png"), 31);  // .2126 * 10 + .7152 * 20 + .0722 * 200 = 30.87
  EXPECT_EQ(texel("bump alpha.png"), 31);
  EXPECT_EQ(texel("map_d plain.png"), 31);
  EXPECT_EQ(texel("map_d alpha.png"), 77);
  EXPECT_EQ(texel("map_d -imfchan l alpha.png"), 31);
  // The light of the codes: .0030353, .0069954, .5775804.
  EXPECT_NEAR(texel("bump -colorspace sRGB plain.png"), .047350, 5e-5);
}

TEST_F(ReadScene, TakesAMapThatCannotBeDecodedForAMissingOne) {
  ReadOptions options;
  int decoded = 0;
  options.decode_texture = [&](const std::string& path, bool) {
    ++decoded;
    if (fs::path(path).filename() == "bad.png")
      throw scene_error(SourcePlace{path}, "no picture", "one");
    return DecodedTexture{
        .width = 1, .height = 1, .channels = 1, .bits = 8, .texels = make_blob({std::byte{7}})};
  };
  write("bad.png", "x");
  write("good.png", "x");
  write("a.mtl",
        "newmtl idle\nmap_Kd bad.png\nnewmtl a\nKd 0 0 0\nmap_Kd bad.png\nKs 1\nmap_Ks good.png\n");
  const LoadedScene loaded =
      read_scene(write("a.obj", std::string("mtllib a.mtl\nusemtl a\n") + kTriangle), options);
  EXPECT_EQ(loaded.scene.textures_size(), 1);
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().r(), 0) << "as without map_Kd";
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(loaded.warnings[0].find("a.mtl: picture 'bad.png' no picture; expected one"),
            std::string::npos)
      << loaded.warnings[0];
  EXPECT_EQ(decoded, 2) << "each once";
}

TEST_F(ReadScene, TakesAPictureOfAModelThatCannotBeDecodedForAMissingOne) {
  ReadOptions options;
  options.decode_texture = [](const std::string& path, bool) -> DecodedTexture {
    if (fs::path(path).filename() == "bad.png")
      throw scene_error(SourcePlace{path}, "no picture", "one");
    return {.width = 1, .height = 1, .channels = 1, .bits = 8, .texels = make_blob({std::byte{7}})};
  };
  options.decode_texture_bytes = [](std::string_view, const std::string& name) -> DecodedTexture {
    throw scene_error(SourcePlace{name}, "no picture", "one");
  };
  write("bad.png", "x");
  write("good.png", "x");
  const LoadedScene ply =
      read_scene(write("a.ply",
                       "ply\nformat ascii 1.0\ncomment TextureFile bad.png\nelement vertex 3\n"
                       "property float x\nproperty float y\nproperty float z\nproperty float u\n"
                       "property float v\nelement face 1\nproperty list uchar int vertex_indices\n"
                       "end_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n"),
                 options);
  EXPECT_EQ(ply.scene.textures_size(), 0);
  ASSERT_EQ(ply.warnings.size(), 1u);
  EXPECT_TRUE(ply.warnings[0].ends_with("a.ply: picture 'bad.png' no picture; expected one"))
      << ply.warnings[0];
  const LoadedScene gltf = read_scene(
      write("a.gltf",
            "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
            "\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
            "\"materials\":[{\"normalTexture\":{\"index\":0},\"pbrMetallicRoughness\":{"
            "\"baseColorTexture\":{\"index\":1}},"
            "\"occlusionTexture\":{\"index\":2}}],\"textures\":[{\"source\":0},{\"source\":1},"
            "{\"source\":2,\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}],\"images\":[\n"
            "{\"uri\":\"bad.png\"},\n{\"uri\":\"data:;base64,YWJj\"},\n{\"uri\":\"good.png\"}]}"),
      options);
  ASSERT_EQ(gltf.scene.textures_size(), 1) << "the next image of a texture that has two";
  EXPECT_EQ(gltf.scene.textures(0).image().file(), "good.png");
  EXPECT_EQ(gltf.scene.materials(0).normal_map(), "");
  ASSERT_EQ(gltf.warnings.size(), 2u);
  EXPECT_TRUE(gltf.warnings[0].ends_with("a.gltf: line 3: picture 'a.gltf#images/1' no picture; "
                                         "expected one") ||
              gltf.warnings[1].ends_with("a.gltf: line 3: picture 'a.gltf#images/1' no picture; "
                                         "expected one"))
      << testing::PrintToString(gltf.warnings);
}

TEST_F(ReadScene, LeavesOutInlinesThatCannotBeReadWhateverTheirFormat) {
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  write("good.obj", kTriangle);
  write("bad.gltf", "{");
  const LoadedScene loaded =
      read_scene(write("a.x3d",
                       "<X3D><Scene><Inline url='\"bad.obj\" \"good.obj\"'/>\n"
                       "<Inline url='\"bad.gltf\"'/><Inline url='\"good.obj\"'/></Scene></X3D>"));
  EXPECT_EQ(loaded.scene.objects_size(), 2) << "good.obj and what the Inlines refer to";
  EXPECT_EQ(loaded.scene.nodes(0).instance_of(), loaded.scene.nodes(2).instance_of());
  EXPECT_EQ(loaded.scene.nodes(1).instance_of(), "");
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(loaded.warnings[0].find("a.x3d: line 2: Inline of 'bad.gltf' is left out: "),
            std::string::npos)
      << loaded.warnings[0];
  EXPECT_NE(loaded.warnings[0].find("bad.gltf:1:2: what is no JSON"), std::string::npos);
  ReadOptions strict;
  strict.x3d_strict = true;
  EXPECT_NE(error_of([&] {
              read_scene((folder_ / "a.x3d").string(), strict);
            }).find("a.x3d:2:2: Inline of 'bad.gltf': "),
            std::string::npos);
  EXPECT_EQ(error(write("b.tessera", "includes { file: 'bad.gltf' }")).substr(0, 12),
            "bad.gltf:1:2")
      << "an include that is not read is an error";
}

/// However deep what is wrong lies: in the file that is named, or in one that this includes.
TEST_F(ReadScene, LeavesOutInlinesThatIncludeWhatCannotBeRead) {
  write("good.obj", kTriangle);
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  write("radius.x3d", "<X3D><Scene><Shape><Sphere radius='-1'/></Shape></Scene></X3D>");
  const auto inline_of = [&](const std::string& includes) {
    write("outer.tessera", "includes { file: 'good.obj' }\nincludes { file: 'inner.tessera' }");
    write("inner.tessera", includes);
    return read_scene(write("a.x3d",
                            "<X3D><Scene><Inline url='\"outer.tessera\" \"good.obj\"'/>\n"
                            "<Inline url='outer.tessera'/><Inline url='good.obj'/></Scene></X3D>"));
  };
  for (const auto& [file, reason] :
       {std::pair<std::string, std::string>{"none.obj", "none.obj: no such file"},
        {"bad.obj", "bad.obj:2:"},
        {"../out.obj", "inner.tessera: includes '../out.obj', which is not inside the scene's"},
        {"radius.x3d", "radius.x3d:1:"}}) {
    const LoadedScene loaded = inline_of("includes { file: '" + file + "' }");
    EXPECT_EQ(loaded.scene.objects_size(), 2) << "good.obj and what the Inlines refer to";
    EXPECT_EQ(loaded.scene.nodes(0).instance_of(), loaded.scene.nodes(2).instance_of());
    EXPECT_EQ(loaded.scene.nodes(1).instance_of(), "");
    ASSERT_EQ(loaded.warnings.size(), 1u) << file;
    EXPECT_NE(loaded.warnings[0].find("a.x3d: line 2: Inline of 'outer.tessera' is left out: "),
              std::string::npos)
        << loaded.warnings[0];
    EXPECT_NE(loaded.warnings[0].find(reason), std::string::npos) << loaded.warnings[0];
  }
  EXPECT_EQ(inline_of("includes { file: 'good.obj' }").warnings, std::vector<std::string>{});
  EXPECT_NE(error_of([&] { inline_of("includes { file: 'a.x3d' }"); }).find("in turn"),
            std::string::npos)
      << "what has no end is an error";
}

TEST_F(ReadScene, LooksForFilesInTheAssetsAlone) {
  ReadOptions options;
  options.assets = (outside_ / "assets").string();
  std::vector<std::string> decoded;
  options.decode_texture = [&](const std::string& path, bool) -> DecodedTexture {
    decoded.push_back(fs::path(path).lexically_relative(fs::canonical(outside_)).string());
    return {.width = 1, .height = 1, .channels = 1, .bits = 8, .texels = make_blob({std::byte{7}})};
  };
  // "scene" is the folder beside; what lies there is not to be found.
  for (const std::string folder : {"../assets/", "../assets/models/", ""}) {
    const std::string colour = folder.empty() ? "1 0 0" : "0 1 0";
    write(folder + "a.mtl", "newmtl a\nKd " + colour + "\nmap_Kd a.png\n");
    write(folder + "a.png", "x");
  }
  write("../assets/a.obj", std::string("mtllib a.mtl\nusemtl a\n") + kTriangle);
  write("../assets/models/m.obj", std::string("mtllib a.mtl\nusemtl a\n") + kTriangle);
  write("../assets/models/m.x3d",
        "<X3D><Scene><Inline url='m.obj'/><Inline url='../a.obj'/><Inline "
        "url='models/m.obj'/></Scene></X3D>");
  const auto read = [&](const std::string& name, const std::string& text) {
    decoded.clear();
    return read_scene(write(name, text), options);
  };
  const std::string obj = std::string("mtllib a.mtl\nusemtl a\n") + kTriangle;
  const LoadedScene beside = read("s.obj", obj);
  EXPECT_EQ(beside.scene.materials(0).classic().diffuse().value().g(), 1);
  EXPECT_EQ(decoded, std::vector<std::string>{"assets/a.png"});
  read("../assets/models/s.obj", obj);
  EXPECT_EQ(decoded, std::vector<std::string>{"assets/models/a.png"}) << "its own folder is first";
  const LoadedScene inlines =
      read("s.x3d",
           "<X3D><Scene><Inline url='models/m.x3d'/><Shape><Appearance><ImageTexture "
           "url='models/a.png'/></Appearance><Sphere/></Shape><Inline url='../scene/s.obj'/>"
           "</Scene></X3D>");
  EXPECT_EQ(decoded, (std::vector<std::string>{"assets/models/a.png", "assets/a.png",
                                               "assets/models/a.png"}))
      << testing::PrintToString(decoded);
  ASSERT_EQ(inlines.warnings.size(), 1u) << testing::PrintToString(inlines.warnings);
  EXPECT_NE(inlines.warnings[0].find("not inside"), std::string::npos);
  const std::string both =
      "includes { file: 'models/m.obj' }\ntextures { name: 't' image { file: 'models/a.png' } }";
  read("s.tessera", both);
  EXPECT_EQ(decoded.size(), 2u);
  read("../assets/models/s.tessera", both);
  EXPECT_EQ(decoded.size(), 2u) << "from the assets' folder where the file's own has none";
  EXPECT_NE(error_of([&] {
              read("t.tessera", "includes { file: '../scene/s.obj' }");
            }).find("not inside"),
            std::string::npos);
}

/// Whatever names the file, the message names the folder that it has to be in.
TEST_F(ReadScene, SaysWhichFolderAFileIsOutsideOf) {
  ReadOptions options;
  options.assets = (outside_ / "assets").string();
  options.decode_texture = [](const std::string&, bool) { return DecodedTexture{}; };
  fs::create_directories(options.assets);
  const std::string root = "the asset root '" + fs::canonical(options.assets).string() + "'";
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"s.tessera", "includes { file: '../x.obj' }"},
           {"t.tessera", "textures { name: 't' image { file: '../x.png' } }"},
           {"s.x3d", "<X3D><Scene><Inline url='../x.obj'/></Scene></X3D>"},
           {"t.x3d",
            "<X3D><Scene><Shape><Appearance><ImageTexture url='../x.png'/></Appearance><Box/>"
            "</Shape></Scene></X3D>"},
           {"s.obj", std::string("mtllib ../x.mtl\n") + kTriangle},
           {"t.obj", std::string("mtllib t.mtl\nusemtl t\n") + kTriangle},
           {"s.ply",
            "ply\nformat ascii 1.0\ncomment TextureFile ../x.png\nelement vertex 3\nproperty float "
            "x\nproperty float y\nproperty float z\nproperty float u\nproperty float v\nelement "
            "face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n"
            "0 1 0 0 1\n3 0 1 2\n"},
           {"s.gltf",
            R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)"
            R"("attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"count":1,)"
            R"("componentType":5126,"type":"VEC3"}],"bufferViews":[{"buffer":0,)"
            R"("byteLength":12}],"buffers":[{"byteLength":12,"uri":"../x.bin"}]})"},
           {"s.crt",
            "cam = Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> 60 }\n"
            "Settings { camera -> cam }\nScene { Mesh { file -> \"../x.obj\" } }\n"}}) {
    write("../assets/" + name, text);
    write("../assets/t.mtl", "newmtl t\nmap_Kd ../x.png\n");
    const std::string path = (outside_ / "assets" / name).string();
    std::string said;
    const std::string error = error_of([&] {
      const LoadedScene loaded = read_scene(path, options);
      for (const std::string& warning : loaded.warnings) said += warning + "\n";
    });
    said += error;
    EXPECT_NE(said.find(root), std::string::npos) << name << ": " << said;
    EXPECT_EQ(said.find("scene's folder"), std::string::npos) << name << ": " << said;
  }
}

TEST_F(ReadScene, SaysThatTheCurrentFolderWasRemoved) {
  const std::string scene = write("a.x3d", "<X3D><Scene/></X3D>");
  const fs::path before = fs::current_path();
  fs::create_directory(outside_ / "gone");
  fs::current_path(outside_ / "gone");
  fs::remove(outside_ / "gone");
  ReadOptions options;
  options.assets = ".";
  const std::string relative = error_of([] { read_scene("a.x3d"); });
  const std::string assets = error_of([&] { read_scene(scene, options); });
  const size_t cameras = read_scene(scene).scene.cameras_size();
  fs::current_path(before);
  for (const std::string& message : {relative, assets})
    EXPECT_EQ(message,
              "the current folder is not there any more; expected another, or paths that begin "
              "with '/'");
  EXPECT_EQ(cameras, 1u) << "where it is not needed it is not missed";
}

TEST_F(ReadScene, FollowsNoLinkOfABlobOutOfTheAssets) {
  const std::string bytes(36, '\0');
  const std::string digest = Digest::of(std::as_bytes(std::span(bytes))).hex();
  const std::string scene = "nodes { shape { mesh { positions { size: 36 digest: '" + digest +
                            "' } inline_triangles: [0, 1, 2] } } }";
  ReadOptions options;
  options.assets = (outside_ / "assets").string();
  write("../assets/s/a.tessera", scene);
  write("../assets/pool", bytes);
  write("../elsewhere", bytes);
  fs::create_directory(outside_ / "assets/s/a.tessera.blobs");
  const fs::path path = outside_ / "assets/s/a.tessera";
  const fs::path blob = path.string() + ".blobs/" + digest;
  fs::create_symlink("../../pool", blob);
  EXPECT_EQ(read_scene(path.string(), options).blobs.size(), 1u);
  EXPECT_NE(error_of([&] { read_scene(path.string()); }).find("a blob that is not inside"),
            std::string::npos)
      << "without assets the scene's own folder is all there is";
  fs::remove(blob);
  fs::create_symlink("../../../elsewhere", blob);
  EXPECT_NE(error_of([&] {
              read_scene(path.string(), options);
            }).find("a blob that is not inside '" + fs::canonical(options.assets).string()),
            std::string::npos);
  // Beside a scene that is not in the assets itself its blobs are its own.
  write("b.tessera", scene);
  write("b.tessera.blobs/" + digest, bytes);
  EXPECT_EQ(read_scene((folder_ / "b.tessera").string(), options).blobs.size(), 1u);
}

TEST_F(ReadScene, ReadsPicturesOfMaterialsInsideTheFolderOnly) {
  write("a.obj", std::string("mtllib m/a.mtl\nusemtl a\n") + kTriangle);
  write("m/a.mtl",
        "newmtl a\nmap_Kd there.png\nmap_Ks ../../out.png\nmap_Ke none.png\nnewmtl idle\n");
  write("m/there.png", "x");
  std::ofstream(outside_ / "out.png") << "x";
  const LoadedScene loaded = read_scene((folder_ / "a.obj").string());
  ASSERT_EQ(loaded.scene.textures_size(), 1);
  EXPECT_EQ(loaded.scene.textures(0).image().file(), "m/there.png");
  EXPECT_EQ(loaded.unused, std::vector<std::string>{"material 'idle'"});
  EXPECT_EQ(loaded.warnings.size(), 2u);
}

}  // namespace
}  // namespace tessera
