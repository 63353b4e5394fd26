// Texts that stand for files, and what is kept of files that have not changed.
#include "scenes/import/read_cache.h"

#include <gmock/gmock.h>

#include <map>

#include "proto/wire/scene_codec.h"
#include "tests/unit/scenes/formats/read_scene_fixture.h"

namespace tessera {
namespace {

using ::testing::HasSubstr;
using testing::ReadScene;
namespace fs = std::filesystem;

class ReadCacheTest : public ReadScene {
 protected:
  ReadCacheTest() {
    options.decode_texture = [this](const std::string& path, bool) {
      ++decoded[fs::path(path).filename().string()];
      DecodedTexture texture;
      texture.width = texture.height = 1;
      std::string text(3, '\0');
      std::ifstream(path, std::ios::binary).read(text.data(), 3);
      const auto bytes = std::as_bytes(std::span(text));
      texture.texels = make_blob({bytes.begin(), bytes.end()});
      return texture;
    };
    options.text_of = [this](const fs::path& path) {
      const auto text = texts.find(path.lexically_relative(fs::canonical(folder_)).string());
      return text == texts.end() ? nullptr : std::make_shared<const std::string>(text->second);
    };
  }

  /// Of a file as it was written long ago: of one that is new nothing is kept.
  std::string write_old(const std::string& name, const std::string& text) {
    const std::string path = write(name, text);
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(1 + written++));
    return path;
  }

  /// All that a reading gives, in bytes.
  static std::string whole(const LoadedScene& loaded) {
    std::string all = serialize_scene(loaded.scene);
    std::map<std::string, std::string> blobs;
    for (const auto& [digest, blob] : loaded.blobs.all()) {
      blobs[digest.hex()].assign(reinterpret_cast<const char*>(blob->data()), blob->size());
    }
    for (const auto& [digest, bytes] : blobs) all += digest + bytes;
    for (const std::string& warning : loaded.warnings) all += warning;
    for (const Diagnostic& warning : loaded.warning_diagnostics) {
      all += warning.place.str() + warning.found;
    }
    for (const std::string& unused : loaded.unused) all += unused;
    return all;
  }

  /// Reads with the cache, and holds it against reading without one.
  LoadedScene read(const std::string& path) {
    ReadOptions without = options;
    options.cache = &cache;
    LoadedScene loaded = read_scene(path, options);
    const auto counts = decoded;
    without.cache = nullptr;
    EXPECT_EQ(whole(loaded), whole(read_scene(path, without)));
    decoded = counts;
    return loaded;
  }

  ReadOptions options;
  ReadCache cache{1 << 20};
  std::map<std::string, int> decoded;
  std::map<std::string, std::string> texts;
  int written = 0;
};

TEST_F(ReadCacheTest, TextsStandForFiles) {
  const std::string scene = write("a.tessera", "includes { file: \"m.obj\" }");
  write("m.obj", std::string("mtllib m.mtl\nusemtl m\n") + kTriangle);
  write("m.mtl", "newmtl m\nKd 1 0 0\n");
  const auto color = [&] {
    return read_scene(scene, options).scene.materials(0).classic().diffuse().value();
  };
  EXPECT_EQ(color().r(), 1);
  texts["m.mtl"] = "newmtl m\nKd 0 1 0\n";
  EXPECT_EQ(color().g(), 1) << "of what a file that is included names";
  texts["m.obj"] = std::string("mtllib new.mtl\nusemtl m\n") + kTriangle;
  texts["new.mtl"] = "newmtl m\nKd 0 0 1\n";
  EXPECT_EQ(color().b(), 1) << "of a file that is not there at all";
  texts["a.tessera"] = "nodes { shape { sphere { radius: x } } }";
  try {
    read_scene(scene, options);
    ADD_FAILURE() << "it is no number";
  } catch (const Error& error) {
    ASSERT_EQ(error.diagnostics().size(), 1u);
    EXPECT_EQ(error.diagnostics()[0].place.str(), scene + ":1:34");
    EXPECT_EQ(error.diagnostics()[0].expected, "a number");
  }
  texts["a.tessera"] = "";
  EXPECT_THAT(error_of([&] { read_scene(scene, options); }), HasSubstr("the file is empty"));
}

TEST_F(ReadCacheTest, AKeyInALibraryReadsNeitherMeshNorPicturesAnew) {
  const std::string scene = write_old("m.obj", std::string("mtllib m.mtl\nusemtl m\n") + kTriangle);
  write_old("m.mtl", "newmtl m\nKd 1 0 0\nmap_Kd a.png\n");
  write_old("a.png", "abc");
  read(scene);
  EXPECT_EQ(decoded["a.png"], 1);
  const uint64_t made = cache.misses();
  EXPECT_EQ(read(scene).scene.textures_size(), 1);
  EXPECT_EQ(cache.misses(), made) << "nothing has changed";
  for (const char* red : {"0.5", "0.25"}) {
    texts["m.mtl"] = std::string("newmtl m\nmap_Kd a.png\nKd 0 0 ") + red + "\n";
    const uint64_t before = cache.misses();
    read(scene);
    EXPECT_EQ(cache.misses(), before + 1) << "the scene itself";
  }
  EXPECT_EQ(decoded["a.png"], 1);
  write_old("a.png", "abd");
  read(scene);
  EXPECT_EQ(decoded["a.png"], 2) << "of the same size";
  write_old("m.obj", std::string("mtllib m.mtl\nusemtl m\n") + kTriangle + "v 1 1 1\nf 1 2 4\n");
  EXPECT_EQ(read(scene).scene.nodes(0).shape().mesh().triangles().size(), 24u);
  EXPECT_EQ(decoded["a.png"], 2);
}

TEST_F(ReadCacheTest, WhatWasNotThereMayCome) {
  const std::string scene = write_old("m.obj", std::string("mtllib m.mtl\nusemtl m\n") + kTriangle);
  EXPECT_EQ(read(scene).warnings.size(), 2u);
  write_old("m.mtl", "newmtl m\nmap_Kd a.png\n");
  EXPECT_EQ(read(scene).warnings.size(), 1u) << "the picture";
  write_old("a.png", "abc");
  EXPECT_TRUE(read(scene).warnings.empty());
  fs::remove(folder_ / "a.png");
  EXPECT_EQ(read(scene).warnings.size(), 1u);
}

TEST_F(ReadCacheTest, FilesInsideOfFilesCount) {
  const std::string scene = write_old("a.x3d",
                                      "<X3D version='4.0'><Scene><Inline url='b.x3d'/>"
                                      "<Inline url='c.obj'/></Scene></X3D>");
  write_old("b.x3d", "<X3D version='4.0'><Scene><Shape><Sphere/></Shape></Scene></X3D>");
  const std::string before = whole(read(scene));
  const uint64_t made = cache.misses();
  EXPECT_EQ(whole(read(scene)), before);
  EXPECT_EQ(cache.misses(), made);
  texts["b.x3d"] = "<X3D version='4.0'><Scene><Shape><Sphere radius='2'/></Shape></Scene></X3D>";
  const std::string changed = whole(read(scene));
  EXPECT_NE(changed, before);
  write_old("c.obj", kTriangle);
  EXPECT_NE(whole(read(scene)), changed);
  texts.clear();
  read(scene);
}

TEST_F(ReadCacheTest, OptionsAndFramesAreToldApart) {
  const std::string script =
      write_old("a.crt",
                "cam = Camera { position -> vec3(t, 0, -5) pointing -> vec3(0, 0, 0) fov -> 60 }\n"
                "Settings { camera -> cam }\nScene { }\n");
  std::string frames[2];
  for (int frame : {0, 1, 0, 1}) {
    options.frame = frame;
    const std::string read_now = whole(read(script));
    if (frames[frame].empty()) frames[frame] = read_now;
    EXPECT_EQ(frames[frame], read_now);
  }
  EXPECT_NE(frames[0], frames[1]);
}

TEST_F(ReadCacheTest, KeepsNoMoreThanItMay) {
  std::string large = "mtllib m.mtl\n";
  for (int i = 0; i < 2000; ++i) large += "v " + std::to_string(i) + " 0 0\n";
  large += "v 0 1 0\n";
  for (int i = 1; i < 2000; ++i) {
    large += "f " + std::to_string(i) + " " + std::to_string(i + 1) + " 2001\n";
  }
  for (int i = 0; i < 30; ++i) {
    read(write_old("m" + std::to_string(i) + ".obj", large + "v " + std::to_string(i) + " 1 2\n"));
    EXPECT_LE(cache.bytes(), uint64_t{1} << 20);
  }
  EXPECT_GT(cache.bytes(), uint64_t{1} << 19);
}

TEST_F(ReadCacheTest, KeepsNothingOfAFileThatHasJustBeenWritten) {
  const std::string scene = write("m.obj", kTriangle);
  fs::last_write_time(scene, fs::file_time_type::clock::now());
  read(scene);
  const uint64_t made = cache.misses();
  read(scene);
  EXPECT_GT(cache.misses(), made);
}

}  // namespace
}  // namespace tessera
