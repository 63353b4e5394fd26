// Files that name other files.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/file.h"
#include "scenes/formats/read_scene.h"
#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// A folder with a scene and what it names, and a file beside the folder that it must not see.
class X3dFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    outside_ =
        fs::temp_directory_path() / ("tessera_x3d_" + std::to_string(::getpid()) + "_" +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
    folder_ = outside_ / "scene";
    fs::create_directories(folder_ / "parts");
  }
  void TearDown() override { fs::remove_all(outside_); }

  std::string write(const std::string& name, const std::string& text) const {
    const fs::path path = folder_ / name;
    std::ofstream(path) << "#X3D V3.3 utf8\n" << text;
    return path.string();
  }
  std::string error_reading(const std::string& path) const {
    const std::string all = error_of([&] { read_x3d(path, {}); });
    return all.substr(all.rfind('/') + 1);
  }

  fs::path outside_, folder_;
};

TEST_F(X3dFilesTest, InlinesAreObjectsWithNamesOfTheirOwn) {
  write("parts/inner.x3dv",
        "DEF Same Viewpoint { position 0 0 3 } Background { skyColor 0 1 0 } "
        "NavigationInfo { headlight FALSE } DirectionalLight { } "
        "Shape { geometry Sphere { } } Inline { url \"innermost.x3dv\" }");
  write("parts/innermost.x3dv", "UNIT length inch 0.0254 Shape { geometry Box { } }");
  const std::string main = write(
      "main.x3dv",
      "Transform { translation 1 0 0 children [ DEF Same Inline { url [ \"none.x3d\" "
      "\"parts/inner.x3dv\" ] } ] } Group { children Inline { url \"parts/inner.x3dv#Same\" } }");
  const LoadedScene loaded = read_x3d(main, {});
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  ASSERT_EQ(loaded.scene.objects_size(), 2);
  EXPECT_EQ(loaded.scene.objects(0).name(), "innermost");
  const v1::Node& scaled = loaded.scene.objects(0).nodes(0);
  EXPECT_EQ(scaled.transform().steps(0).scale().x(), .0254);
  EXPECT_EQ(loaded.scene.objects(1).name(), "inner");
  EXPECT_EQ(loaded.scene.nodes(0).children(0).instance_of(), "inner");
  EXPECT_EQ(loaded.scene.nodes(1).children(0).instance_of(), "inner");
  // What it can bind is bound, since the first file binds nothing.
  EXPECT_EQ(loaded.scene.background().solid().g(), 1);
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  EXPECT_FALSE(loaded.scene.cameras(0).has_headlight());
  EXPECT_EQ(loaded.scene.cameras(0).world_from_camera().steps(0).translate().x(), 1);
}

TEST_F(X3dFilesTest, UrlsMayNameFilesOfThisMachine) {
  write("parts/ball.x3dv", "Shape { geometry Sphere { } }");
  const std::string whole = (folder_ / "parts/ball.x3dv").string();
  for (const std::string& url :
       {std::string("file:parts/ball.x3dv"), "file://" + whole, "FILE://LocalHost" + whole,
        "file:" + whole, std::string("file:///home/ann/scene/parts/ball.x3dv")}) {
    const LoadedScene loaded = read_x3d(write("main.x3dv", "Inline { url \"" + url + "\" }"), {});
    EXPECT_EQ(loaded.scene.objects_size(), 1) << url;
  }
  const LoadedScene loaded =
      read_x3d(write("main.x3dv", "Inline { url \"file://server/parts/ball.x3dv\" }"), {});
  EXPECT_EQ(loaded.scene.objects_size(), 0);
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(loaded.warnings[0].find("nothing from the network"), std::string::npos);
}

TEST_F(X3dFilesTest, WhatCannotBeInlinedIsLeftOutWithAReason) {
  std::ofstream(outside_ / "secret.x3dv") << "#X3D V3.3 utf8\nShape { geometry Box { } }";
  fs::create_symlink(outside_ / "secret.x3dv", folder_ / "link.x3dv");
  const std::string main = write(
      "main.x3dv",
      "Inline { url \"../secret.x3dv\" }\nInline { url \"link.x3dv\" }\nInline { url "
      "\"https://example.org/a.x3d\" }\nInline { url \"" +
          (outside_ / "secret.x3dv").string() +
          "\" }\nInline { url \"no.x3d\" }\nInline { load FALSE url \"no.x3d\" }\nInline { }");
  const LoadedScene loaded = read_x3d(main, {});
  EXPECT_EQ(loaded.scene.objects_size(), 0);
  std::string all;
  for (const std::string& warning : loaded.warnings)
    all += warning.substr(warning.find("main.x3dv:")) + "\n";
  const std::string inside = " is left out: it is not inside the scene's folder\n";
  EXPECT_EQ(
      all,
      "main.x3dv:2:1: Inline of '../secret.x3dv' is left out: it is not inside the scene's folder "
      "(--assets '" +
          fs::canonical(outside_).string() + "' would hold it)\n" +
          "main.x3dv:3:1: Inline of 'link.x3dv'" + inside +
          "main.x3dv:4:1: Inline of 'https://example.org/a.x3d' is left out: only files are "
          "read, and nothing from the network\nmain.x3dv:5:1: Inline of '" +
          (outside_ / "secret.x3dv").string() +
          "' is left out: it is not inside the scene's folder (--assets '" +
          fs::canonical(outside_).string() + "' would hold it)\n" +
          "main.x3dv:6:1: Inline of 'no.x3d' is left out: there is no such file\n");
}

TEST_F(X3dFilesTest, WhatCannotBeReadIsLeftOutAsWhatIsMissing) {
  std::ofstream(folder_ / "old.wrl") << "#VRML V1.0 ascii\nCube { }";
  std::ofstream(folder_ / "broken.x3dv") << "#X3D V3.3 utf8\nShape { geometry Box {";
  const std::string main = write("main.x3dv",
                                 "Inline { url \"old.wrl\" }\nInline { url \"broken.x3dv\" }\n"
                                 "Shape { geometry Sphere { } }");
  const LoadedScene loaded = read_x3d(main, {});
  ASSERT_EQ(loaded.warnings.size(), 2u);
  const auto tells = [&](size_t warning, const char* what) {
    return loaded.warnings[warning].find(what) != std::string::npos;
  };
  EXPECT_TRUE(tells(0, "main.x3dv:2:1: Inline of 'old.wrl' is left out: ")) << loaded.warnings[0];
  EXPECT_TRUE(tells(0, "old.wrl:1:1: VRML 1.0")) << loaded.warnings[0];
  EXPECT_TRUE(tells(1, "broken.x3dv:")) << loaded.warnings[1];
  EXPECT_EQ(loaded.scene.objects_size(), 0);
  ReadOptions strict;
  strict.x3d_strict = true;
  EXPECT_THROW(read_x3d(main, strict), Error);
}

TEST_F(X3dFilesTest, FilesAreNoPartOfThemselves) {
  const std::string self = write("self.x3dv", "Inline { url \"self.x3dv\" }");
  EXPECT_EQ(error_reading(self),
            "self.x3dv:2:1: Inline of 'self.x3dv', of which it is a part; expected files that are "
            "not a part of themselves");
  write("b.x3dv", "Inline { url \"a.x3dv\" }");
  const std::string a = write("a.x3dv", "Inline { url \"b.x3dv\" }");
  EXPECT_EQ(error_reading(a).substr(0, 26), "b.x3dv:2:1: Inline of 'a.x");
  for (int i = 0; i < 20; ++i)
    write("d" + std::to_string(i) + ".x3dv",
          "Inline { url \"d" + std::to_string(i + 1) + ".x3dv\" }");
  EXPECT_NE(error_reading((folder_ / "d0.x3dv").string()).find("too many Inlines"),
            std::string::npos);
}

/// All of a file is read, or nothing of it: what its first nodes put into the scene goes too.
TEST_F(X3dFilesTest, OfAFileThatIsWrongNothingIsLeft) {
  write("good.x3dv", "Shape { geometry Box { } }");
  write("broken.x3dv",
        "DEF V Viewpoint { } Background { } Fog { visibilityRange 9 } NavigationInfo { headlight "
        "FALSE } DEF S Shape { appearance Appearance { material Material { } texture ImageTexture "
        "{ url \"none.png\" } } geometry Box { } } USE S Inline { url \"good.x3dv\" }\n"
        "Shape { geometry Sphere { radius 1 ] }");
  write("outer.x3dv", "Inline { url \"broken.x3dv\" } Inline { url \"good.x3dv\" }");
  const std::string urls = "Inline { url [ \"broken.x3dv\" \"outer.x3dv\" ] }";
  const LoadedScene loaded = read_x3d(write("main.x3dv", urls + urls), {});
  EXPECT_EQ(loaded.scene.textures_size(), 0);
  EXPECT_EQ(loaded.scene.materials_size(), 1) << "of good.x3dv";
  EXPECT_EQ(loaded.scene.background().kind_case(), v1::Background::KIND_NOT_SET);
  EXPECT_FALSE(loaded.scene.has_fog());
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  EXPECT_EQ(loaded.scene.cameras(0).name(), "default") << "none of the file's";
  EXPECT_TRUE(loaded.scene.cameras(0).has_headlight());
  ASSERT_EQ(loaded.scene.objects_size(), 2);
  EXPECT_EQ(loaded.scene.objects(1).name(), "outer");
  for (const v1::Node& node : loaded.scene.nodes()) EXPECT_EQ(node.instance_of(), "outer");
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(loaded.warnings[0].find("outer.x3dv:2:1: Inline of 'broken.x3dv' is left out: "),
            std::string::npos)
      << loaded.warnings[0];
  EXPECT_NE(loaded.warnings[0].find("broken.x3dv:3:36: ']'; expected a field, or '}'"),
            std::string::npos)
      << loaded.warnings[0];
}

TEST_F(X3dFilesTest, OtherFormatsBecomeObjectsToo) {
  std::ofstream(folder_ / "parts/card.obj") << "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n";
  const std::string main = write(
      "main.x3dv",
      "Transform { translation 3 0 0 children DEF I Inline { url \"parts/card.obj\" } } USE I");
  const LoadedScene loaded = read_scene(main);
  const std::string inlined = loaded.scene.objects(0).nodes(0).instance_of();
  EXPECT_EQ(loaded.scene.includes_size(), 0);
  size_t triangles = 0;
  for (const v1::Object& object : loaded.scene.objects())
    for (const v1::Node& node : object.nodes()) triangles += node.shape().has_mesh() ? 1 : 0;
  EXPECT_EQ(triangles, 1u);
  EXPECT_FALSE(inlined.empty());
  const std::vector<float> seen = render_loaded(loaded, 16, 16);
  EXPECT_GT(*std::max_element(seen.begin(), seen.end()), 0);
}

TEST_F(X3dFilesTest, MissingPicturesHaveAPlaceholder) {
  const std::string main =
      write("main.x3dv",
            "Shape { geometry Box { } appearance DEF A Appearance { texture ImageTexture { url "
            "\"none.png\" } } } Shape { geometry Sphere { } appearance USE A }");
  const LoadedScene loaded = read_x3d(main, {});
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(
      loaded.warnings[0].find("main.x3dv:2:64: a placeholder stands for the picture 'none.png': "
                              "there is no such file"),
      std::string::npos);
  ASSERT_EQ(loaded.scene.textures_size(), 1);
  EXPECT_EQ(loaded.scene.textures(0).image().width(), 2u);
}

TEST_F(X3dFilesTest, StrictReadingTakesNothingForMissingFiles) {
  ReadOptions strict;
  strict.x3d_strict = true;
  for (const char* missing : {"Shape { appearance Appearance { texture ImageTexture { url "
                              "\"none.png\" } } geometry Box { } }",
                              "Inline { url \"none.png\" }"}) {
    const std::string main = write("main.x3dv", missing);
    EXPECT_NO_THROW(read_x3d(main, {}));
    try {
      read_x3d(main, strict);
      ADD_FAILURE() << missing;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("main.x3dv:2:"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("'none.png'"), std::string::npos) << error.what();
    }
  }
}

/// Decoders that take what begins with "good" for a white picture.
ReadOptions picky_decoders() {
  const auto decode = [](const std::string& text, const std::string& name) {
    if (!text.starts_with("good")) throw scene_error(SourcePlace{name}, "no picture", "one");
    return DecodedTexture{
        .width = 1, .height = 1, .channels = 1, .bits = 8, .texels = make_blob({std::byte{255}})};
  };
  ReadOptions options;
  options.decode_texture = [=](const std::string& path, bool) {
    return decode(read_input_file(path, 1000), path);
  };
  options.decode_texture_bytes = [=](std::string_view bytes, const std::string& name) {
    return decode(std::string(bytes), name);
  };
  return options;
}

TEST_F(X3dFilesTest, TheFirstPictureThatCanBeDecodedIsTaken) {
  std::ofstream(folder_ / "bad.png") << "bad";
  std::ofstream(folder_ / "good.png") << "good";
  const auto read = [&](const std::string& urls, bool strict = false) {
    ReadOptions options = picky_decoders();
    options.x3d_strict = strict;
    return read_scene(write("main.x3dv",
                            "Shape { geometry Box { } appearance Appearance { texture "
                            "ImageTexture { url [ " +
                                urls + " ] } } }"),
                      options);
  };
  const auto warning = [&](const LoadedScene& loaded) {
    return loaded.warnings.size() == 1
               ? loaded.warnings[0].substr(loaded.warnings[0].find("main.x3dv:"))
               : std::to_string(loaded.warnings.size()) + " warnings";
  };
  const LoadedScene second = read("\"bad.png\" \"good.png\"");
  EXPECT_EQ(second.scene.textures(0).image().file(), "good.png");
  EXPECT_EQ(second.scene.textures(0).image().width(), 1u);
  EXPECT_EQ(warning(second),
            "main.x3dv:2:58: the picture is 'good.png', not 'bad.png': no picture; expected one");
  const LoadedScene none = read("\"none.png\" \"bad.png\"");
  EXPECT_EQ(none.scene.textures(0).image().width(), 2u) << "the placeholder";
  EXPECT_EQ(
      warning(none),
      "main.x3dv:2:58: a placeholder stands for the picture 'none.png': there is no such file; "
      "'bad.png': no picture; expected one");
  EXPECT_THROW(read("\"none.png\" \"bad.png\"", true), Error);
  EXPECT_EQ(read("\"none.png\" \"good.png\"", true).warnings.size(), 0u);
}

/// A ball of one's own colour, with a picture beside its file, and something that is not asked for.
constexpr const char* kBallFile =
    "PROTO Other [ ] { Group { } }\n"
    "PROTO Ball [ inputOutput SFColor color 1 0 0 inputOutput SFNode look Appearance { texture "
    "ImageTexture { url \"good.png\" } } ] { Group { children [ Shape { appearance Appearance { "
    "material Material { diffuseColor IS color } } geometry DEF S Sphere { radius 1x } } Shape { "
    "appearance IS look geometry USE S } ] } } Shape { geometry Box { } }";

TEST_F(X3dFilesTest, PrototypesOfOtherFilesAreReadFromThem) {
  std::ofstream(folder_ / "parts/good.png") << "good";
  write("parts/ball.x3dv", kBallFile);
  const LoadedScene loaded = read_scene(
      write("main.x3dv",
            "EXTERNPROTO Ball [ inputOutput SFColor color ] [ \"none.x3dv#Ball\" "
            "\"parts/ball.x3dv#Ball\" ]\n"
            "Ball { color 0 0 1 }\nDEF B Ball { } EXTERNPROTO First [ ] \"parts/ball.x3dv\" "
            "First { }"),
      picky_decoders());
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(loaded.warnings[0].find("main.x3dv:3:1: radius of Sphere: '1x'; expected a number"),
            std::string::npos)
      << loaded.warnings[0];
  ASSERT_EQ(loaded.scene.nodes_size(), 3);
  EXPECT_EQ(loaded.scene.nodes(1).name(), "B");
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().b(), 1);
  ASSERT_EQ(loaded.scene.nodes(1).children_size(), 2);
  EXPECT_TRUE(loaded.scene.nodes(1).children(0).shape().has_sphere());
  ASSERT_GE(loaded.scene.textures_size(), 1);
  EXPECT_EQ(loaded.scene.textures(0).image().width(), 1u) << "from the folder of the prototype";
  EXPECT_EQ(loaded.scene.nodes(2).children_size(), 0) << "of no name: the first one";
}

TEST_F(X3dFilesTest, PrototypesOfOtherFilesAreTheSameInXml) {
  std::ofstream(folder_ / "ball.x3d")
      << "<X3D version='3.3'><Scene><ProtoDeclare name='Ball'><ProtoInterface><field name='size' "
         "accessType='inputOutput' type='SFFloat' value='2'/></ProtoInterface><ProtoBody><Shape>"
         "<Sphere><IS><connect nodeField='radius' protoField='size'/></IS></Sphere></Shape>"
         "</ProtoBody></ProtoDeclare></Scene></X3D>";
  std::ofstream(folder_ / "main.x3d")
      << "<X3D version='3.3'><Scene><ExternProtoDeclare name='B' url='\"none.x3d\" "
         "\"ball.x3d#Ball\"'/><ProtoInstance name='B'/><ProtoInstance name='B'><fieldValue "
         "name='size' value='4'/></ProtoInstance></Scene></X3D>";
  const LoadedScene loaded = read_x3d((folder_ / "main.x3d").string(), {});
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  ASSERT_EQ(loaded.scene.nodes_size(), 2);
  EXPECT_EQ(loaded.scene.nodes(0).shape().sphere().radius(), 2);
  EXPECT_EQ(loaded.scene.nodes(1).shape().sphere().radius(), 4);
}

TEST_F(X3dFilesTest, PrototypesThatCannotBeReadAreTold) {
  fs::create_directories(outside_ / "library");
  std::ofstream(outside_ / "library/globe.x3dv") << "#X3D V3.3 utf8\n" << kBallFile;
  write("ball.x3dv", kBallFile);
  write("loop.x3dv", "EXTERNPROTO P [ ] \"loop.x3dv#P\" PROTO Q [ ] { P { } }");
  write("broken.x3dv", "PROTO Q [ ] { Group { children [ ");
  std::ofstream(folder_ / "ball.x3d") << "<X3D><Scene/></X3D>";
  const auto told = [&](const std::string& url) {
    const LoadedScene loaded = read_x3d(
        write("main.x3dv", "EXTERNPROTO P [ ] \"" + url + "\" P { } Shape { geometry Box { } }"),
        {});
    EXPECT_EQ(loaded.scene.nodes_size(), 1) << url;
    std::string all;
    for (const std::string& warning : loaded.warnings) all += warning + "\n";
    return all;
  };
  const auto expect_told = [&](const std::string& url, const std::string& part) {
    const std::string all = told(url);
    EXPECT_NE(all.find(part), std::string::npos) << all;
  };
  const std::string start = "main.x3dv:2:1: the prototype 'P' is left out: '";
  expect_told("none.x3dv#P", start + "none.x3dv#P': there is no such file");
  expect_told("ball.x3dv#Bll", "the file has no prototype 'Bll'");
  expect_told("main.x3dv#P", "it is a part of that file");
  expect_told("loop.x3dv#P", "loop.x3dv#P': it is a part of that file");
  expect_told("broken.x3dv#Q", "broken.x3dv:2:");
  expect_told("ball.x3d", "strings are written otherwise there");
  expect_told("http://example.org/a.x3dv#P", "nothing from the network");
  expect_told("../library/globe.x3dv#Ball",
              "--assets '" + fs::canonical(outside_).string() + "' would hold it");
  ReadOptions wider;
  wider.assets = outside_.string();
  const LoadedScene read =
      read_x3d(write("main.x3dv", "EXTERNPROTO P [ ] \"../library/globe.x3dv#Ball\" P { }"), wider);
  ASSERT_EQ(read.scene.nodes_size(), 1);
  EXPECT_EQ(read.scene.nodes(0).children_size(), 2);
}

TEST_F(X3dFilesTest, PicturesMayStandInTheUrl) {
  const auto read = [&](const std::string& url) {
    return read_scene(write("main.x3dv",
                            "Shape { geometry Box { } appearance Appearance { texture "
                            "ImageTexture { url \"" +
                                url + "\" } } }"),
                      picky_decoders());
  };
  const LoadedScene good = read("data:image/png;base64,Z29v\n ZA==");
  EXPECT_EQ(good.warnings.size(), 0u);
  EXPECT_EQ(good.scene.textures(0).image().width(), 1u);
  EXPECT_EQ(good.scene.textures(0).image().file(), "main.x3dv#picture 1");
  for (const std::string wrong :
       {"data:image/png;base64,", "data:image/png;base64,?", "data:text,"}) {
    const LoadedScene bad = read(wrong + std::string(1000, 'A'));
    ASSERT_EQ(bad.warnings.size(), 1u);
    EXPECT_EQ(bad.scene.textures(0).image().width(), 2u) << "the placeholder";
    EXPECT_NE(bad.warnings[0].find("AAAA...': "), std::string::npos) << bad.warnings[0];
    EXPECT_LT(bad.warnings[0].size(), folder_.string().size() + 250) << bad.warnings[0];
  }
}

TEST_F(X3dFilesTest, TheFirstInlineThatCanBeReadIsTaken) {
  std::ofstream(folder_ / "broken.x3dv") << "#X3D V3.3 utf8\nShape { geometry Box {";
  write("good.x3dv", "Shape { geometry Box { } }");
  const LoadedScene loaded =
      read_x3d(write("main.x3dv", "Inline { url [ \"broken.x3dv\" \"good.x3dv\" ] }"), {});
  EXPECT_EQ(loaded.scene.nodes(0).instance_of(), "good");
  const LoadedScene none =
      read_x3d(write("main.x3dv", "Inline { url [ \"broken.x3dv\" \"none.x3dv\" ] }"), {});
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_NE(none.warnings[0].find("Inline of 'broken.x3dv' is left out: "), std::string::npos);
  EXPECT_NE(none.warnings[0].find("; 'none.x3dv': there is no such file"), std::string::npos);
}

}  // namespace
}  // namespace tessera
