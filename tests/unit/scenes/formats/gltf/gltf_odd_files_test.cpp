// Files that break the format: what is left out with a warning, and what is refused.
#include <gtest/gtest.h>

#include <limits>

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
  EXPECT_EQ(
      error(file(accessor(0, 5126, 5, "VEC3"))),
      "t.gltf: accessors/0: 5 rows in a buffer view that holds 4; expected rows that it holds");
  EXPECT_EQ(
      error(file(accessor(0, 5126, 4, "VEC3", R"(,"byteOffset":4)"))),
      "t.gltf: accessors/0: 4 rows in a buffer view that holds 3; expected rows that it holds");
  EXPECT_EQ(error(file(R"({"componentType":5126,"type":"VEC3","count":1000000000000})")),
            "t.gltf: accessors/0/count: 1000000000000 zeros; expected at most 16777216");
  EXPECT_EQ(error(file(accessor(0, 5126, 4, "MAT3"))),
            "t.gltf: accessors/0/type: 'MAT3'; expected SCALAR, VEC2, VEC3, VEC4 or MAT4");
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
  EXPECT_EQ(error("{}"), "t.gltf: asset/version: no value; expected glTF 2.0");
  EXPECT_EQ(error(R"({"asset":{"version":"1.0"}})"),
            "t.gltf:1:21: asset/version: '1.0'; expected glTF 2.0");
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

TEST(Gltf, VersionsAreReadAsTheOneThatIsKnown) {
  const auto said = [](const std::string& asset) {
    return warnings("{\"asset\":{" + asset + R"(},"nodes":[{}]})");
  };
  const std::vector<std::string> nothing;
  EXPECT_EQ(said(R"("version":"2.0","minVersion":"2.0")"), nothing);
  EXPECT_EQ(said(R"("version":"2.1","minVersion":"2.1")"),
            std::vector<std::string>{"t.gltf:1:40: asset/minVersion: '2.1'; expected glTF 2.0; the "
                                     "file is read as that"});
  EXPECT_EQ(said(R"("version":"2.0","minVersion":"10.0")").size(), 1u);
  EXPECT_EQ(said(R"("version":"word")"),
            std::vector<std::string>{
                "t.gltf:1:21: asset/version: 'word'; expected glTF 2.0; that is taken"});
  EXPECT_EQ(
      warnings(R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_materials_variants"]})"),
      std::vector<std::string>{
          "t.gltf:1:50: extensionsRequired/0: the file requires extension "
          "'KHR_materials_variants'; expected one that is read; it is shown without"});
  EXPECT_EQ(warnings(R"({"asset":{"version":"2.0"},"extensionsRequired":[5]})"),
            std::vector<std::string>{
                "t.gltf:1:50: extensionsRequired/0: 5; expected text; it is left out"});
}

TEST(Gltf, OddNodesDoNotCostTheFile) {
  EXPECT_EQ(warnings(with_node(R"("scale":[0,1,1])")),
            std::vector<std::string>{
                "t.gltf:1:50: nodes/1: a camera in a flat frame; expected a frame that can be "
                "inverted; the camera is left out (2 times)"});
  EXPECT_EQ(warnings(with_node(R"("mesh":-1)")),
            std::vector<std::string>{
                "t.gltf:1:69: nodes/1/mesh: -1; expected a mesh, or no value; it is left out"});
}

/// One mesh of a square whose vertices have all attributes, and what `part`, which is in the text,
/// becomes where `other` is written for it.
LoadedScene square(const std::string& part, const std::string& other) {
  std::string members =
      R"("nodes":[{"mesh":0,"children":[1]},{"camera":0}],"scenes":[{"nodes":[0]}],"scene":0,)"
      R"("cameras":[{"type":"perspective","perspective":{"yfov":1}}],"skins":[],)"
      R"("animations":[{"name":"turn"}],"materials":[{"pbrMetallicRoughness":)"
      R"({"baseColorTexture":{"index":0,"texCoord":0}}}],"textures":[{"source":0,"sampler":0}],)"
      R"("samplers":[{"wrapS":10497}],"images":[{"bufferView":5}],)" +
      mesh(R"({"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"COLOR_0":3},"indices":4,)"
           R"("material":0,"mode":4})") +
      R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5126, 4, "VEC3") +
      "," + accessor(2, 5126, 4, "VEC2") + "," + accessor(3, 5126, 4, "VEC4") + "," +
      accessor(4, 5121, 6, "SCALAR") + "]";
  const size_t at = members.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  members.replace(at, part.size(), other);
  return read(Binary()
                  .put(kSquare)
                  .put(Floats{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1})
                  .put(Floats(8, .5f))
                  .put(Floats(16, .25f))
                  .put(std::vector<uint8_t>{0, 1, 2, 0, 2, 3})
                  .put(Floats{1, 2, 3})
                  .glb(members));
}

struct OddPart {
  const char *part, *other, *warning;
};

TEST(Gltf, OneOddAttributeCostsThatAttribute) {
  const std::vector<OddPart> cases{
      {R"("NORMAL":1)", R"("NORMAL":9)", "NORMAL: accessor 9; expected 0 to 4; it is left out"},
      {R"("NORMAL":1)", R"("NORMAL":"x")", "NORMAL: 'x'; expected a whole number; it is left out"},
      {R"("NORMAL":1)", R"("NORMAL":2)", "NORMAL: rows of 2; expected 3 numbers a row; it is left"},
      {R"("NORMAL":1)", R"("NORMAL":4)", "accessors/4: 6 rows; expected one a vertex; it is left"},
      {R"("bufferView":1,"componentType":5126)", R"("bufferView":1,"componentType":99)",
       "accessors/1/componentType: 99; expected 5120 to 5123, 5125 or 5126; it is left out"},
      {R"("bufferView":1,)", R"("bufferView":9,)", "expected 0 to 5"},
      {R"("bufferView":1,)", R"("bufferView":2,)", "in a buffer view that holds 2; expected rows"},
      {R"("TEXCOORD_0":2)", R"("TEXCOORD_0":-3)", "TEXCOORD_0: -3; expected a whole number"},
      {R"("COLOR_0":3)", R"("COLOR_0":2)", "COLOR_0: rows of 2; expected 4 numbers a row"},
  };
  for (const OddPart& c : cases) {
    const LoadedScene loaded = square(c.part, c.other);
    const Mesh m = first_mesh(loaded);
    EXPECT_EQ(m.triangles, (Indices{0, 1, 2, 0, 2, 3})) << c.other;
    EXPECT_EQ(m.normals.empty() + m.uvs.empty() + m.colors.empty(), 1) << c.other;
    EXPECT_GE(loaded.repairs.size(), 1u);
    EXPECT_NE(testing::PrintToString(loaded.warnings).find(c.warning), std::string::npos)
        << testing::PrintToString(loaded.warnings);
  }
}

TEST(Gltf, OneOddReferenceCostsWhatItRefersTo) {
  const std::vector<OddPart> cases{
      {R"("children":[1])", R"("children":[7])", "node 7; expected 0 to 1; it is left out"},
      {R"("children":[1])", R"("children":[1,1])", "two parents, or below itself; expected a tree"},
      {R"("children":[1])", R"("children":[0,1])", "below itself; expected a tree; it is shown"},
      {R"("children":[1])", R"("children":1)", "children: 1; expected an array; it is left out"},
      {R"({"camera":0})", R"({"camera":3})", "nodes/1/camera: camera 3; expected 0 to 0; it is"},
      {R"({"camera":0})", R"({"camera":0,"mesh":3})", "nodes/1/mesh: mesh 3; expected 0 to 0; it"},
      {R"({"camera":0})", R"({"camera":0,"skin":3,"extras":[]})", "animations are not read"},
      {R"({"camera":0})", "7", "nodes/1: 7; expected an object; it is left out"},
      {R"("scene":0)", R"("scene":4)", "scene: scene 4; expected 0 to 0; it is left out"},
      {R"("material":0)", R"("material":4)", "material: material 4; expected 0 to 0; it is left"},
      {R"("mode":4)", R"("mode":-1)", "mode: -1; expected a whole number; it is left out"},
      {R"("index":0)", R"("index":4)", "index: texture 4; expected 0 to 0; it is left out"},
      {R"("texCoord":0)", R"("texCoord":1)", "no TEXCOORD_1; expected the texture coordinates"},
      {R"("texCoord":0)", R"("texCoord":-1)", "texCoord: -1; expected a whole number; it is left"},
      {R"("wrapS":10497)", R"("wrapS":3)", "expected 33071 (clamp), 33648 (mirror) or 10497"},
      {R"("wrapS":10497)", R"("wrapS":"x")", "wrapS: 'x'; expected a whole number; it is left out"},
      {R"("wrapS":10497)", R"("magFilter":3)", "magFilter: 3; expected 9728 or 9729; it is left"},
      {R"("wrapS":10497)", R"("minFilter":3)", "3; expected 9728, 9729 or 9984 to 9987; it is"},
      {R"("sampler":0)", R"("sampler":3)", "sampler: sampler 3; expected 0 to 0; it is left out"},
      {R"("source":0)", R"("source":3)", "source: image 3; expected 0 to 0; it is left out"},
      {R"([{"bufferView":5}])", R"([{"bufferView":9}])",
       "buffer view 9; expected 0 to 5; the pict"},
      {R"("skins":[])", R"("skins":{"a":1})",
       "skins: an object; expected an array; it is left out"},
      {R"([{"name":"turn"}])", R"([5,{"channels":[{"sampler":9}]}])", "animations/0: 5; expected"},
  };
  for (const OddPart& c : cases) {
    const LoadedScene loaded = square(c.part, c.other);
    const Mesh m = first_mesh(loaded);
    EXPECT_EQ(m.triangles, (Indices{0, 1, 2, 0, 2, 3})) << c.other;
    EXPECT_FALSE(m.normals.empty() || m.uvs.empty() || m.colors.empty()) << c.other;
    EXPECT_NE(testing::PrintToString(loaded.warnings).find(c.warning), std::string::npos)
        << testing::PrintToString(loaded.warnings);
  }
}

TEST(Gltf, OneOddIndexCostsItsTriangles) {
  const auto file = [](const std::vector<uint8_t>& indices, const std::string& more) {
    return Binary().put(kSquare).put(indices).glb(
        kNode + mesh(R"({"attributes":{"POSITION":0},"indices":1})" + more) + R"(,"accessors":[)" +
        accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5121, 6, "SCALAR") + "]");
  };
  const LoadedScene loaded = read(file({0, 1, 9, 0, 2, 3}, ""));
  EXPECT_EQ(first_mesh(loaded).triangles, (Indices{0, 2, 3}));
  EXPECT_EQ(loaded.warnings,
            std::vector<std::string>{
                "t.glb: meshes/0/primitives/0/indices: index 9 of 4 vertices; expected indices of "
                "vertices; the triangles there are left out"});
  for (const char* more : {R"(,{"attributes":{"POSITION":7}})", R"(,{"attributes":{"POSITION":1}})",
                           R"(,{"attributes":{"POSITION":0},"indices":0})", ",3",
                           R"(,{"attributes":{"POSITION":0},"indices":7})"}) {
    const LoadedScene beside = read(file({0, 1, 2, 0, 2, 3}, more));
    EXPECT_EQ(first_mesh(beside).triangles, (Indices{0, 1, 2, 0, 2, 3})) << more;
    EXPECT_GE(beside.repairs.size(), 1u) << more;
  }
  EXPECT_EQ(error(file({0, 1, 9, 9, 2, 3}, "")),
            "t.gltf: meshes/0/primitives/0/indices: index 9 of 4 vertices; expected indices of "
            "vertices");
}

TEST(Gltf, CornersThatMakeNoTriangleAreLeftOut) {
  const auto file = [](int mode, int count) {
    return read(Binary()
                    .put(kSquare)
                    .put(std::vector<uint8_t>{0, 1, 2, 0, 2})
                    .glb(kNode +
                         mesh(R"({"attributes":{"POSITION":0},"indices":1,"mode":)" +
                              std::to_string(mode) + "}") +
                         R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," +
                         accessor(1, 5121, count, "SCALAR") + "]"));
  };
  const std::string said = "meshes/0/primitives/0/indices: ",
                    rest = "; those left over are left out";
  EXPECT_EQ(first_mesh(file(4, 5)).triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(only_warning(file(4, 5)), said + "5 corners; expected 3 or a multiple of it" + rest);
  EXPECT_EQ(only_warning(file(4, 0)), said + "0 corners; expected 3 or a multiple of it" + rest);
  EXPECT_EQ(only_warning(file(6, 2)), said + "2 corners; expected 3 or more" + rest);
  EXPECT_EQ(file(6, 4).warnings, std::vector<std::string>{});
}

TEST(Gltf, DataThatIsNotAlignedIsReadAllTheSame) {
  std::string bytes(1, '\0');
  for (const float number : kSquare) {
    if (bytes.size() % 13 == 0) bytes += '\0';
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  const LoadedScene loaded =
      read(Binary()
               .put(std::vector<char>(bytes.begin(), bytes.end()), 13)
               .glb(kNode +
                    mesh(R"({"attributes":{"POSITION":0},"mode":6},)"
                         R"({"attributes":{"POSITION":1},"mode":6})") +
                    R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3", R"(,"byteOffset":1)") + "," +
                    accessor(0, 5126, 4, "VEC3", R"(,"byteOffset":1)") + "]"));
  EXPECT_EQ(mesh_of(loaded.scene.nodes(0).children(0).shape(), loaded.blobs).positions, kSquare);
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{
                "t.glb: accessors/0: byte 1 of the buffer; expected a multiple of 4, the size of a "
                "component; it is taken all the same (2 times)",
                "t.glb: bufferViews/0/byteStride: 13; expected a multiple of 4, the size of a "
                "component; it is taken all the same"}));
  std::string next = Binary().put(kSquare, 12).glb(kNode + kTriangle);
  next.replace(next.find(":12}"), 4, ": 0}");
  EXPECT_EQ(first_mesh(read(next)).positions, Floats(kSquare.begin(), kSquare.begin() + 9));
  EXPECT_EQ(only_warning(read(next)),
            "bufferViews/0/byteStride: 0; expected 4 to 252; the rows are next to each other");
}

TEST(Gltf, WhatIsThereOfAContainerThatIsCutShortIsRead) {
  const std::string whole = Binary().put(kSquare).put(kSquare).glb(
      kNode + mesh(R"({"attributes":{"POSITION":0}},{"attributes":{"POSITION":1}})") +
      R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5126, 4, "VEC3") +
      "]");
  const LoadedScene loaded = read(whole.substr(0, whole.size() - 4));
  EXPECT_EQ(loaded.scene.nodes_size(), 1);
  EXPECT_NE(testing::PrintToString(loaded.warnings).find("the primitive is left out"),
            std::string::npos);
  EXPECT_GE(loaded.repairs.size(), 3u) << testing::PrintToString(loaded.warnings);
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
