// Files beside a scene: which may be read, and what becomes of those that cannot be.
#include <fmt/format.h>

#include "scenes/import/warnings.h"
#include "tests/unit/scenes/formats/read_scene_fixture.h"

namespace tessera {
namespace {

using testing::ReadScene;
namespace fs = std::filesystem;

TEST_F(ReadScene, ManyMissingLibrariesAreAListOfLimitedLength) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += fmt::format("mtllib m{}.mtl\n", i);
  const LoadedScene loaded = read_scene(write("many.obj", text + kTriangle));
  EXPECT_EQ(loaded.warnings.size(), Warnings::kMostEntries + 1);
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
  EXPECT_NE(loaded.warnings[0].find("a.x3d:2:2: Inline of 'bad.gltf' is left out: "),
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
  write("broken.x3d", "<X3D><Scene><Shape>");
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
        {"broken.x3d", "broken.x3d:1:"}}) {
    const LoadedScene loaded = inline_of("includes { file: '" + file + "' }");
    EXPECT_EQ(loaded.scene.objects_size(), 2) << "good.obj and what the Inlines refer to";
    EXPECT_EQ(loaded.scene.nodes(0).instance_of(), loaded.scene.nodes(2).instance_of());
    EXPECT_EQ(loaded.scene.nodes(1).instance_of(), "");
    ASSERT_EQ(loaded.warnings.size(), 1u) << file;
    EXPECT_NE(loaded.warnings[0].find("a.x3d:2:2: Inline of 'outer.tessera' is left out: "),
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
      << ::testing::PrintToString(decoded);
  ASSERT_EQ(inlines.warnings.size(), 1u) << ::testing::PrintToString(inlines.warnings);
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

/// Paths of another machine, by every format that names pictures.
TEST_F(ReadScene, FindsPicturesByTheLastPartsOfAPathThatLeadsNowhere) {
  std::vector<std::string> decoded;
  ReadOptions options;
  options.decode_texture = [&](const std::string& path, bool) -> DecodedTexture {
    decoded.push_back(fs::path(path).lexically_relative(fs::canonical(folder_)).string());
    return {.width = 1, .height = 1, .channels = 1, .bits = 8, .texels = make_blob({std::byte{7}})};
  };
  write("wood.png", "x");
  write("textures/wood.png", "x");
  write("textures/stone.png", "x");
  const auto check = [&](const std::string& name, const std::string& text, const std::string& file,
                         const std::string& note) {
    decoded.clear();
    const LoadedScene loaded = read_scene(write(name, text), options);
    ASSERT_FALSE(decoded.empty()) << text;
    EXPECT_EQ(decoded.back(), file) << text;
    ASSERT_EQ(loaded.warnings.size(), note.empty() ? 0u : 1u)
        << ::testing::PrintToString(loaded.warnings);
    EXPECT_EQ(loaded.warning_diagnostics.size(), loaded.warnings.size());
    if (!note.empty()) {
      EXPECT_NE(loaded.warnings[0].find(note), std::string::npos) << loaded.warnings[0];
    }
  };
  const std::string inside = (fs::canonical(folder_) / "wood.png").string();
  for (const auto& [path, file] : std::vector<std::pair<std::string, std::string>>{
           {inside, "wood.png"},
           {"textures/wood.png", "textures/wood.png"},
           {"/home/ann/chair/wood.png", "wood.png"},
           {"/home/ann/chair/textures/wood.png", "textures/wood.png"},
           {"../wood.png", "wood.png"},
           {"maps/stone/textures/stone.png", "textures/stone.png"},
           {"C:\\\\chair\\\\textures\\\\stone.png", "textures/stone.png"},
           {"Textures/Wood.PNG", "textures/wood.png"},
           {"C:\\\\Maps\\\\TEXTURES\\\\Stone.png", "textures/stone.png"},
           {"Maps/WOOD.png", "wood.png"}}) {
    const bool is_there = path == inside || path == "textures/wood.png";
    std::string plain = path;
    while (plain.find("\\\\") != std::string::npos) plain.replace(plain.find("\\\\"), 2, "\\");
    const bool is_outside = !is_there && (path.starts_with("/") || path.starts_with(".."));
    const std::string note = is_there ? ""
                                      : std::string("is not ") +
                                            (is_outside ? "inside the scene's folder" : "there") +
                                            "; '" + file + "' is taken for it";
    write("a.mtl", "newmtl a\nmap_Kd " + plain + "\n");
    check("a.obj", std::string("mtllib a.mtl\nusemtl a\n") + kTriangle, file, note);
    check("a.tessera", "textures { name: 't' image { file: '" + path + "' } }", file, note);
  }
  // Of several addresses one that is right comes first.
  check(
      "a.x3d",
      "<X3D><Scene><Shape><Appearance><ImageTexture url='\"/x/wood.png\" \"textures/stone.png\"'/>"
      "</Appearance><Sphere/></Shape></Scene></X3D>",
      "textures/stone.png", "");
  check("b.x3d",
        "<X3D><Scene><Shape><Appearance><ImageTexture url='\"/x/wood.png\"'/>"
        "</Appearance><Sphere/></Shape></Scene></X3D>",
        "wood.png",
        "b.x3d:1:33: the picture '/x/wood.png' is not inside the scene's folder; 'wood.png'");
}

TEST_F(ReadScene, TellsWhereAModelNamesWhatIsNotThere) {
  write("a.mtl", "newmtl a\nKd 0 1 0\nmap_Kd wood.png\n");
  const std::string path =
      write("a.obj",
            "mtllib none.mtl\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"
            "usemtl b\nf 1 3 2\nusemtl a\nusemtl b\nf 1 2 3\n");
  const std::string folder = folder_.string() + "/";
  EXPECT_EQ(
      read_scene(path).warnings,
      (std::vector<std::string>{folder + "a.mtl:3:8: picture 'wood.png' is not there",
                                folder + "a.obj:1:8: material library 'none.mtl' is not there",
                                folder + "a.obj:8:8: material 'b' is not defined; grey is taken"}));
}

TEST_F(ReadScene, StrictlyReadWhatIsMendedAnywhereIsWrong) {
  ReadOptions strict;
  strict.strict = true;
  write("a.mtl", "newmtl a\nKd 0 1 0\nNs -1\nmap_Kd wood.png\nrefl x.png\n");
  write("odd.obj",
        std::string("mtllib none.mtl\nmtllib a.mtl\nusemtl a\nvn 0 0 nan\n") + kTriangle);
  const std::string scene = write("a.tessera", "includes { file: 'odd.obj' }");
  const LoadedScene lax = read_scene(scene);
  EXPECT_EQ(lax.warnings.size(), 6u) << "one of what is not read";
  const std::string folder = folder_.string() + "/";
  EXPECT_EQ(error_of([&] { read_scene(scene, strict); }),
            folder + "a.mtl:3:4: Ns: '-1'; expected an exponent of 0 or more\n" + folder +
                "a.mtl:4:8: picture 'wood.png' is not there\n" + folder +
                "odd.obj:4:8: 'nan'; expected a component of the normal that is finite\n" + folder +
                "odd.obj:4:8: a normal of no length; expected a direction\n" + folder +
                "odd.obj:1:8: material library 'none.mtl' is not there");
  write("a.mtl", "newmtl a\nrefl x.png\n");
  const std::string good = write("good.obj", std::string("mtllib a.mtl\nusemtl a\n") + kTriangle);
  EXPECT_EQ(read_scene(good, strict).warnings.size(), 1u);
  EXPECT_NE(error_of([&] {
              read_scene(write("a.x3d", "<X3D><Scene><Inline url='none.x3d'/></Scene></X3D>"),
                         strict);
            }).find("a.x3d:1:14: Inline of 'none.x3d'"),
            std::string::npos);
}

TEST_F(ReadScene, FindsMaterialLibrariesByName) {
  write("a.mtl", "newmtl a\nKd 0 1 0\n");
  const LoadedScene loaded = read_scene(
      write("a.obj", std::string("mtllib /home/ann/chair/a.mtl\nusemtl a\n") + kTriangle));
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().g(), 1);
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(
      loaded.warnings[0].find("a.obj:1:8: material library '/home/ann/chair/a.mtl' is not inside "
                              "the scene's folder; 'a.mtl' is taken for it"),
      std::string::npos)
      << loaded.warnings[0];
}

TEST_F(ReadScene, FindsPartsOfScenesByTheLastPartsOfAPathThatLeadsNowhere) {
  write("chair.obj", kTriangle);
  write("parts/chair.x3d", "<X3D><Scene><Shape><Sphere/></Shape></Scene></X3D>");
  write("a.bin", std::string("\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\0"
                             "\0\0\0\0\0\0\x80\x3f\0\0\0\0",
                             36));
  struct Case {
    std::string name, text, warning;
  };
  for (const Case& c : std::vector<Case>{
           {"a.tessera", "includes { file: 'C:\\\\ann\\\\chair.obj' }",
            "the included file 'C:\\ann\\chair.obj' is not there; 'chair.obj' is taken for it"},
           {"a.crt",
            "cam = Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> 60 }\n"
            "Settings { camera -> cam }\nScene { Mesh { file -> \"/home/ann/chair.obj\" } }\n",
            "the included file 'home/ann/chair.obj' is not there; 'chair.obj' is taken for it"},
           {"a.x3d", "<X3D><Scene><Inline url='\"/home/ann/parts/chair.x3d\"'/></Scene></X3D>",
            "the Inline '/home/ann/parts/chair.x3d' is not inside the scene's folder; "
            "'parts/chair.x"},
           {"a.gltf",
            R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)"
            R"("attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"count":3,)"
            R"("componentType":5126,"type":"VEC3"}],"bufferViews":[{"buffer":0,)"
            R"("byteLength":36}],"buffers":[{"byteLength":36,"uri":"../out/a.bin"}]})",
            "buffer '../out/a.bin' is not inside the scene's folder; 'a.bin' is taken for it"}}) {
    const LoadedScene loaded = read_scene(write(c.name, c.text));
    EXPECT_GT(loaded.scene.nodes_size(), 0) << c.name;
    ASSERT_EQ(loaded.warnings.size(), 1u) << ::testing::PrintToString(loaded.warnings);
    EXPECT_NE(loaded.warnings[0].find(c.warning), std::string::npos) << loaded.warnings[0];
  }
  // Of several addresses one that is right comes first, and no file is taken for a part of itself.
  EXPECT_EQ(read_scene(write("b.x3d",
                             "<X3D><Scene><Inline url='\"/x/chair.obj\" "
                             "\"parts/chair.x3d\"'/></Scene></X3D>"))
                .warnings.size(),
            0u);
  const LoadedScene self =
      read_scene(write("c.x3d", "<X3D><Scene><Inline url='\"/x/c.x3d\"'/></Scene></X3D>"));
  ASSERT_EQ(self.warnings.size(), 1u);
  EXPECT_NE(self.warnings[0].find("Inline of '/x/c.x3d' is left out"), std::string::npos)
      << self.warnings[0];
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

}  // namespace
}  // namespace tessera
