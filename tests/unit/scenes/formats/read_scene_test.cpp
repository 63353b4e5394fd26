#include "scenes/formats/read_scene.h"

#include <fmt/format.h>

#include "scenes/formats/scene_summary.h"
#include "scenes/import/standard_view.h"
#include "scenes/import/to_affine.h"
#include "tests/unit/scenes/formats/read_scene_fixture.h"

namespace tessera {
namespace {

using testing::ReadScene;
namespace fs = std::filesystem;

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
  EXPECT_EQ(error(write("a.pov", "camera { }")),
            "a.pov: files of type .pov are not read; expected " + known);
  EXPECT_EQ(error(write("a.xyz", "0 0 0")), "a.xyz: unknown ending '.xyz'; expected " + known +
                                                ", or a format that is asked for, as by --format");
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

TEST_F(ReadScene, NamesTheSourceOfWhatItImportsAlone) {
  const std::string file = write("a.tessera", "nodes { shape { sphere {} } }");
  EXPECT_FALSE(read_scene(file).scene.has_metadata());
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
  EXPECT_EQ(loaded.warnings.size(), 2u) << ::testing::PrintToString(loaded.warnings);
}

TEST_F(ReadScene, GivesABareModelAView) {
  const LoadedScene loaded =
      read_scene(write("t.obj", "v 99 0 0\nv 101 0 0\nv 100 3 0\nf 1 2 3\n"));
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  EXPECT_TRUE(loaded.scene.cameras(0).frame_all());
  EXPECT_FALSE(loaded.scene.cameras(0).has_headlight());
  EXPECT_EQ(loaded.scene.settings().sampling().samples_per_pixel(), 4u);
  EXPECT_EQ(summarize(loaded.scene, loaded.blobs).undefined.size(), 0u);
}

TEST_F(ReadScene, TurnsTheViewOfAModelWhoseZAxisPointsUpAndNotTheModel) {
  const std::string obj = write("t.obj", kTriangle);
  const std::string stl = write("t.stl",
                                "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                                "0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n");
  const auto read = [](const std::string& path, ReadOptions::Up up) {
    ReadOptions options;
    options.up = up;
    return read_scene(path, options);
  };
  using Up = ReadOptions::Up;
  const LoadedScene y = read(obj, Up::by_format), z = read(obj, Up::z);
  EXPECT_EQ(read(obj, Up::y).scene.SerializeAsString(), y.scene.SerializeAsString());
  EXPECT_EQ(read(stl, Up::by_format).scene.SerializeAsString(),
            read(stl, Up::z).scene.SerializeAsString());
  EXPECT_TRUE(z.warnings.empty());

  // What was in front, at +z, is at -y, and what was above is at +z.
  const auto expect_turned = [](const v1::Vec3& before, const v1::Vec3& after) {
    EXPECT_NEAR(after.x(), before.x(), 1e-12);
    EXPECT_NEAR(after.y(), -before.z(), 1e-12);
    EXPECT_NEAR(after.z(), before.y(), 1e-12);
  };
  for (const auto& [plain, turned] :
       {std::pair{y, z}, std::pair{read(stl, Up::y), read(stl, Up::z)}}) {
    const v1::LookAt& before = plain.scene.cameras(0).world_from_camera().steps(0).look_at();
    const v1::LookAt& after = turned.scene.cameras(0).world_from_camera().steps(0).look_at();
    EXPECT_FALSE(before.has_up());
    EXPECT_EQ(after.up().z(), 1);
    expect_turned(before.eye(), after.eye());
    ASSERT_EQ(plain.scene.nodes_size(), 4);
    ASSERT_EQ(turned.scene.nodes_size(), 4);
    EXPECT_EQ(plain.scene.nodes(0).SerializeAsString(), turned.scene.nodes(0).SerializeAsString());
    for (int i = 1; i < 4; ++i)
      expect_turned(plain.scene.nodes(i).light().directional().direction(),
                    turned.scene.nodes(i).light().directional().direction());
    const Affine sky = to_affine(plain.scene.background().orientation());
    const Affine turned_sky = to_affine(turned.scene.background().orientation());
    const Vec3 zenith = sky(Vec3{0, 1, 0}), turned_zenith = turned_sky(Vec3{0, 1, 0});
    EXPECT_NEAR(length(turned_zenith - stood_up(zenith, true)), 0, 1e-12);
  }
}

TEST_F(ReadScene, TellsWhereUpTurnsNothing) {
  const std::string path = write("a.x3d", "<X3D><Scene><Viewpoint/></Scene></X3D>");
  ReadOptions options;
  EXPECT_TRUE(read_scene(path, options).warnings.empty());
  options.up = ReadOptions::Up::z;
  EXPECT_EQ(read_scene(path, options).warnings,
            std::vector<std::string>{path + ": --up: turns nothing; expected a model by itself, "
                                            "--view, --turntable or --environment"});
  options.brings_camera = true;
  EXPECT_TRUE(read_scene(path, options).warnings.empty());
}

TEST_F(ReadScene, ShowsBackFacesOfAnyFileWhereItIsToldSo) {
  const std::string one_sided =
      "materials { name: 'm' sides: FRONT_ONLY } materials { name: 'b' "
      "sides: BACK_MATERIAL back: 'm' }";
  write("a.tessera", one_sided);
  const std::string outer = write("b.tessera", "includes { file: 'a.tessera' }");
  ReadOptions options;
  EXPECT_EQ(read_scene(outer, options).scene.materials(0).sides(), v1::Material::FRONT_ONLY);
  options.two_sided = true;
  const auto check = [](const v1::Scene& scene) {
    ASSERT_EQ(scene.materials_size(), 2);
    EXPECT_EQ(scene.materials(0).sides(), v1::Material::TWO_SIDED);
    EXPECT_EQ(scene.materials(1).sides(), v1::Material::BACK_MATERIAL) << "which shows its own";
  };
  check(read_scene(outer, options).scene);
  LoadedScene made = read_scene((folder_ / "a.tessera").string());
  add_files(made, outer, options);
  check(made.scene);
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
  ASSERT_EQ(s.cameras_size(), 1);
  EXPECT_TRUE(s.cameras(0).frame_all()) << "both placements are in view";
}

TEST_F(ReadScene, GivesACameraWithinAModelALightOfItsOwn) {
  // Two triangles, one on either side of the first camera and both behind the second.
  std::string head =
      "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],"
      "\"nodes\":[{\"mesh\":0,\"translation\":[-2,-2,-2],\"scale\":[4,4,4]},"
      "{\"mesh\":0,\"translation\":[0,0,3]},{\"camera\":0},"
      "{\"camera\":0,\"translation\":[0,0,9]}],"
      "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}],"
      "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
      "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
      "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
      "\"buffers\":[{\"byteLength\":36,\"uri\":\"t.bin\"}]}";
  const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  write("t.bin", std::string(reinterpret_cast<const char*>(corners), sizeof corners));
  const v1::Scene s = read_scene(write("within.gltf", head)).scene;
  ASSERT_EQ(s.cameras_size(), 2);
  EXPECT_TRUE(s.cameras(0).headlight().has_point());
  EXPECT_FALSE(s.cameras(1).has_headlight());
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

// A file is read by pieces of 1 MiB, which end wherever a line does.
TEST_F(ReadScene, PiecesOfAnObjEndAtAnyLineEnd) {
  for (const std::string end : {"\n", "\r", "\r\n", " \\\r\n0\r", " \\\n0\n"}) {
    std::string text;
    int lines = 0;
    while (text.size() < 2'500'000) {
      text += fmt::format("v {} {} 0{}", lines % 100, lines % 77, end);
      lines += end.size() > 2 ? 2 : 1;
    }
    text += "f 1 2 3" + end.substr(end.size() - 1) + "f 1 2 x";
    const std::string path = write("large.obj", text);
    EXPECT_EQ(read_scene(path).warnings,
              std::vector<std::string>{fmt::format(
                  "{}:{}:7: 'x'; expected a vertex index; the face is left out", path, lines + 2)});
  }
}

}  // namespace
}  // namespace tessera
