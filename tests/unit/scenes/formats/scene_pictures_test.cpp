// Pictures of textures, as read_scene() finds and keeps them.
#include "renderer/math/encodings.h"
#include "tests/unit/scenes/formats/read_scene_fixture.h"

namespace tessera {
namespace {

using testing::ReadScene;
namespace fs = std::filesystem;

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
  EXPECT_NE(loaded.warnings[0].find("a.mtl:5:8: picture 'bad.png' no picture; expected one"),
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
  EXPECT_TRUE(ply.warnings[0].ends_with("a.ply:3:1: picture 'bad.png' no picture; expected one"))
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
  EXPECT_TRUE(gltf.warnings[0].ends_with("a.gltf:3:1: picture 'a.gltf#images/1' no picture; "
                                         "expected one") ||
              gltf.warnings[1].ends_with("a.gltf:3:1: picture 'a.gltf#images/1' no picture; "
                                         "expected one"))
      << ::testing::PrintToString(gltf.warnings);
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
