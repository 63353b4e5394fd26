#include "scenes/formats/ply/ply_reader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

using Floats = std::vector<float>;
using Indices = std::vector<uint32_t>;

struct Mesh {
  Floats positions, normals, uvs, colors;
  Indices triangles;
  std::vector<std::string> warnings;
};

Mesh read(const std::string& bytes) {
  const LoadedScene loaded = parse_ply(bytes, "t.ply");
  Mesh mesh;
  mesh.warnings = loaded.warnings;
  if (loaded.scene.nodes_size() == 0) return mesh;
  const v1::TriangleMesh& in = loaded.scene.nodes(0).shape().mesh();
  mesh.positions = blob_values<float>(in.positions(), loaded.blobs);
  mesh.normals = blob_values<float>(in.normals(), loaded.blobs);
  mesh.uvs = blob_values<float>(in.uvs(), loaded.blobs);
  mesh.colors = blob_values<float>(in.colors(), loaded.blobs);
  mesh.triangles = blob_values<uint32_t>(in.triangles(), loaded.blobs);
  return mesh;
}

std::string error(const std::string& bytes) {
  return error_of([&] { parse_ply(bytes, "t.ply"); });
}

std::string header(const std::string& encoding, const std::string& rest) {
  return "ply\nformat " + encoding + " 1.0\ncomment made by hand\n" + rest + "end_header\n";
}

/// Values in either order of bytes.
struct Bytes {
  bool big;
  std::string text{};

  template <typename T>
  Bytes& put(T value) {
    std::string raw(sizeof value, '\0');
    std::memcpy(raw.data(), &value, sizeof value);
    if (big) std::reverse(raw.begin(), raw.end());
    text += raw;
    return *this;
  }
};

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kFace = "property list uchar int vertex_indices\n";
const std::string kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

TEST(Ply, ReadsTextWithEveryPropertyThatAMeshHas) {
  const Mesh mesh = read(header("ascii", "element vertex 3\n" + kXyz +
                                             "property float nx\nproperty float ny\n"
                                             "property float nz\nproperty float s\n"
                                             "property float t\nproperty uchar red\n"
                                             "property uchar green\nproperty uchar blue\n"
                                             "property uchar alpha\nelement face 1\n" +
                                             kFace) +
                         "0 0 0 0 0 1 .25 .75 255 0 188 255\n1 0 0 0 0 1 1 0 0 255 0 51\n"
                         "0 1 0 0 0 1 0 1 0 0 0 0\n3 0 1 2\n");
  EXPECT_EQ(mesh.positions, (Floats{0, 0, 0, 1, 0, 0, 0, 1, 0}));
  EXPECT_EQ(mesh.normals, (Floats{0, 0, 1, 0, 0, 1, 0, 0, 1}));
  EXPECT_EQ(mesh.uvs, (Floats{.25f, .75f, 1, 0, 0, 1}));
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2}));
  ASSERT_EQ(mesh.colors.size(), 12u);
  EXPECT_EQ(mesh.colors[0], 1);
  EXPECT_NEAR(mesh.colors[2], .5029, 1e-3) << "codes of a display, not light";
  EXPECT_FLOAT_EQ(mesh.colors[7], .2f) << "alpha is a share";
  EXPECT_TRUE(mesh.warnings.empty());
}

TEST(Ply, StepsOverAByteOrderMark) {
  const std::string text =
      "\xEF\xBB\xBF" + header("ascii", "element vertex 4\n" + kXyz + "element face 1\n" + kFace);
  EXPECT_EQ(read(text + kSquare + "3 0 1 2").triangles, (Indices{0, 1, 2}));
}

TEST(Ply, ReadsBothBinaryOrdersAndSkipsWhatItDoesNotKnow) {
  for (const bool big : {false, true}) {
    Bytes data{big};
    for (const double c : {0., 0., 0., 2., 0., 0., 0., 3., 0.}) data.put(c);
    data.put(uint16_t{2}).put(7.f).put(8.f);  // of 'camera'
    data.put(uint8_t{9}).put(uint32_t{3}).put(int16_t{0}).put(int16_t{1}).put(int16_t{2});
    const Mesh mesh =
        read(header(big ? "binary_big_endian" : "binary_little_endian",
                    "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
                    "element camera 1\nproperty list ushort float lens\n"
                    "element face 1\nproperty uchar flags\n"
                    "property list uint short vertex_index\n") +
             data.text);
    EXPECT_EQ(mesh.positions, (Floats{0, 0, 0, 2, 0, 0, 0, 3, 0}));
    EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2}));
    EXPECT_EQ(mesh.warnings,
              (std::vector<std::string>{"t.ply: element 'camera' is left out",
                                        "t.ply: property 'flags' of 'face' is not read"}));
  }
}

TEST(Ply, CutsPolygonsAndStrips) {
  const std::string head = "element vertex 4\n" + kXyz;
  EXPECT_EQ(
      read(header("ascii", head + "element face 1\n" + kFace) + kSquare + "4 0 1 2 3").triangles,
      (Indices{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(
      read(header("ascii", head + "element tristrips 1\n" + kFace) + kSquare + "8 0 1 3 2 -1 1 2 3")
          .triangles,
      (Indices{0, 1, 3, 3, 1, 2, 1, 2, 3}));
  const Mesh odd = read(header("ascii", head + "element face 3\n" + kFace) + kSquare +
                        "2 0 1\n3 0 1 1\n3 0 1 2");
  EXPECT_EQ(odd.triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(odd.warnings.size(), 2u);
}

TEST(Ply, ReadsFacesThatComeBeforeTheVertices) {
  const std::string elements =
      "element face 2\n" + kFace + "element tristrips 1\n" + kFace + "element vertex 4\n" + kXyz;
  const Mesh mesh = read(header("ascii", elements) + "3 0 1 2\n3 0 2 3\n3 1 2 3\n" + kSquare);
  EXPECT_EQ(mesh.positions, (Floats{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}));
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2, 0, 2, 3, 1, 2, 3}));
  EXPECT_TRUE(mesh.warnings.empty());
  Bytes data{true};
  data.put(uint8_t{3}).put(0).put(1).put(2);
  for (int i = 0; i < 9; ++i) data.put(static_cast<float>(i * i));
  EXPECT_EQ(
      read(header("binary_big_endian", "element face 1\n" + kFace + "element vertex 3\n" + kXyz) +
           data.text)
          .triangles,
      (Indices{0, 1, 2}));
  const Mesh odd = read(header("ascii", elements) + "3 0 1 2\n3 0 4 3\n3 1 2 3\n" + kSquare);
  EXPECT_EQ(odd.triangles, (Indices{0, 1, 2, 1, 2, 3}));
  EXPECT_EQ(odd.warnings, std::vector<std::string>{"t.ply:14:5: '4'; expected an index of 0 to 3; "
                                                   "the face is left out"});
  EXPECT_EQ(error(header("ascii", "element face 1\n" + kFace) + "3 0 1 2\n"),
            "t.ply:7:3: '0'; expected a file with vertices");
}

TEST(Ply, ShowsThePictureThatACommentNames) {
  const auto text = [](const char* uv) {
    return header("ascii", std::string("comment TextureFile a b.png\nelement vertex 3\n") + kXyz +
                               uv + "element face 1\n" + kFace) +
           (*uv ? "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n" : "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  };
  const std::string mapped = text("property float u\nproperty float v\n");
  const LoadedScene shown = parse_ply(mapped, "t.ply");
  ASSERT_EQ(shown.scene.textures_size(), 1);
  EXPECT_EQ(shown.scene.textures(0).image().file(), "a b.png");
  EXPECT_EQ(shown.scene.materials(0).classic().diffuse().texture(), shown.scene.textures(0).name());
  const LoadedScene missing = parse_ply(
      mapped, "t.ply", [](const std::string&, const std::string*) { return "is not there"; });
  EXPECT_EQ(missing.scene.textures_size(), 0);
  EXPECT_EQ(missing.warnings,
            std::vector<std::string>{"t.ply:4:1: picture 'a b.png' is not there"});
  EXPECT_EQ(parse_ply(text(""), "t.ply").scene.textures_size(), 0);
}

TEST(Ply, RefusesCountsThatTheFileHasNoRoomFor) {
  EXPECT_EQ(
      parse_ply(header("ascii", "element vertex 4000000000\n" + kXyz) + kSquare, "t.ply").warnings,
      std::vector<std::string>{"t.ply:13:1: the file ends here; expected a number; the header "
                               "announces more rows than the 4 lines that follow it; what is whole "
                               "before it is read"});
  EXPECT_EQ(
      error(header("binary_little_endian", "element vertex 4000000000\n" + kXyz) + "12345678"),
      "t.ply: the file ends here (before byte 153); expected the data that its header announces");
  Bytes face{false};
  for (int i = 0; i < 9; ++i) face.put(0.f);
  face.put(uint32_t{0x7FFFFFFF});
  EXPECT_EQ(
      error(header("binary_little_endian",
                   "element vertex 3\n" + kXyz +
                       "element face 1\nproperty list uint int vertex_indices\n") +
            face.text),
      "t.ply: a list 'vertex_indices' of 2147483647 (before byte 229); expected a count of at "
      "most 0, which the file can hold");
  EXPECT_TRUE(read(header("ascii", "element nothing 18446744073709551615\n")).triangles.empty());
}

TEST(Ply, WhatIsWholeOfAFileThatIsCutShortIsRead) {
  const std::string text =
      header("ascii", "element vertex 4\n" + kXyz + "element face 9\n" + kFace) + kSquare +
      "3 0 1 2\n3 0 2 3\n3 0";
  const Mesh by_text = read(text);
  EXPECT_EQ(by_text.triangles, (Indices{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(by_text.warnings,
            std::vector<std::string>{"t.ply:17:1: '3'; expected a count of at most 1, which the "
                                     "file can hold; what is whole before it is read"});
  Bytes data{false};
  for (int i = 0; i < 9; ++i) data.put(static_cast<float>(i * i));
  data.put(uint8_t{3}).put(0).put(1).put(2);
  const std::string whole =
      header("binary_little_endian",
             "element vertex 3\n" + kXyz + "element face 2000000000\n" + kFace) +
      data.text;
  for (const char* more : {"", "\3", "\3\1\1\1", "\x7f\1\1\1\1\1\1\1\1"}) {
    const Mesh mesh = read(whole + more);
    EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2}));
    ASSERT_EQ(mesh.warnings.size(), 1u);
    EXPECT_TRUE(mesh.warnings[0].ends_with("; what is whole before it is read"))
        << mesh.warnings[0];
  }
  EXPECT_EQ(error(whole.substr(0, whole.size() - 1)).substr(0, 30),
            "t.ply: a list 'vertex_indices'");
}

TEST(Ply, OnePartThatCannotBeReadDoesNotCostTheFile) {
  struct Case {
    const char *vertex, *face, *more, *warning;
  };
  const std::vector<Case> cases{
      {"0 1 0", "3 1 2 9", "", ":16:7: '9'; expected an index of 0 to 3; the face is left out"},
      {"0 1 0", "3 1 -2 3", "", ":16:5: '-2'; expected an index of 0 to 3; the face is left out"},
      {"0 1 0", "3 1 1.5 3", "", ":16:5: '1.5'; expected an index of 0 to 3; the face is left out"},
      {"0 1 0", "3 1 x 3", "", ":16:5: 'x'; expected an index of 0 to 3; the face is left out"},
      {"0 x 0", "3 1 2 3", "",
       ":14:3: 'x'; expected a finite number that single precision can hold; the faces there are "
       "left out"},
      {"0 1 0", "3 1 1 1", "3 1 2 3",
       ": what follows the last element is not read; the header announces fewer rows than the 7 "
       "lines "
       "that follow it"},
  };
  for (const Case& c : cases) {
    const Mesh mesh =
        read(header("ascii", "element vertex 4\n" + kXyz + "element face 2\n" + kFace) +
             "0 0 0\n1 0 0\n1 1 0\n" + c.vertex + "\n3 0 1 2\n" + c.face + "\n" + c.more);
    EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2})) << c.face;
    ASSERT_FALSE(mesh.warnings.empty());
    EXPECT_EQ(mesh.warnings.back(), std::string("t.ply") + c.warning);
  }
}

TEST(Ply, OneOddLineOfAHeaderDoesNotCostTheFile) {
  const std::string head =
      "element vertex 3\n" + kXyz +
      "properti float q\nunits mm\nelement face 1\nproperty list float int vertex_index\n";
  std::string text = header("ascii", head) + "0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2\n";
  text.replace(text.find("1.0"), 3, "1.1");
  const Mesh mesh = read(text);
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(mesh.warnings,
            (std::vector<std::string>{
                "t.ply:2:14: '1.1'; expected version 1.0; it is read as that",
                "t.ply:8:1: 'properti'; expected format, element, property, comment or end_header; "
                "it is taken for 'property'",
                "t.ply:9:1: 'units'; expected format, element, property, comment or end_header; "
                "the line is left out",
                "t.ply:11:15: 'float'; expected a type of whole numbers; it is taken all the "
                "same",
                "t.ply: property 'q' of 'vertex' is not read"}));
}

TEST(Ply, OneOddValueDoesNotCostTheFile) {
  const std::string properties = kXyz +
                                 "property float nx\nproperty float ny\nproperty float nz\n"
                                 "property float u\nproperty float v\n";
  const Mesh mesh =
      read(header("ascii", "element vertex 4\n" + properties + "element face 2\n" + kFace) +
           "0 0 0 nan 0 1 0 0\n1 0 0 0 0 1 inf 0\n0 1 0 0 0 1 0 1\n1e39 0 0 0 0 1 0 0\n"
           "3 0 1 2\n3 1 2 3\n");
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(Floats(mesh.normals.begin(), mesh.normals.begin() + 6), (Floats{0, 0, 0, 0, 0, 1}));
  EXPECT_EQ(Floats(mesh.uvs.begin(), mesh.uvs.begin() + 4), (Floats{0, 0, 0, 0}));
  EXPECT_EQ(mesh.warnings,
            (std::vector<std::string>{
                "t.ply:16:7: 'nan'; expected a finite number that single precision can hold; the "
                "face's own normal is taken",
                "t.ply:17:13: 'inf'; expected a finite number that single precision can hold; 0 is "
                "taken",
                "t.ply:19:1: '1e39'; expected a finite number that single precision can hold; the "
                "faces there are left out"}));
}

TEST(Ply, PointsWithoutFacesAreDrawn) {
  const std::string colored = "element vertex 3\n" + kXyz +
                              "property float nx\nproperty float ny\nproperty float nz\n"
                              "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string points = "0 0 0 0 0 1 255 0 0\n4 0 0 0 1 0 0 255 0\n0 3 0 1 0 0 0 0 255\n";
  for (const std::string faces : {"", "element face 0\n"}) {
    const std::string list = faces.empty() ? "" : kFace;
    const Mesh mesh = read(header("ascii", colored + faces + list) + points);
    EXPECT_EQ(mesh.triangles.size(), 3u * 3 * 8);
    ASSERT_EQ(mesh.positions.size(), 3u * 18);
    EXPECT_FLOAT_EQ(mesh.positions[0], -5. / 720) << "1/360 of the whole is the width of a point";
    EXPECT_EQ(Floats(mesh.normals.begin() + 18, mesh.normals.begin() + 21), (Floats{0, 1, 0}));
    EXPECT_EQ(Floats(mesh.colors.begin() + 24, mesh.colors.begin() + 28), (Floats{0, 1, 0, 1}));
    EXPECT_TRUE(mesh.warnings.empty());
  }
  const LoadedScene loaded = parse_ply(header("ascii", colored) + points, "t.ply");
  EXPECT_TRUE(loaded.scene.nodes(0).casts_no_shadow());
}

TEST(Ply, ARangeGridIsDrawnByItsPoints) {
  const Mesh mesh = read(header("ascii", "element vertex 2\n" + kXyz +
                                             "element range_grid 3\n"
                                             "property list uchar int vertex_indices\n") +
                         "0 0 0\n1 0 0\n1 0\n0\n1 1\n");
  EXPECT_EQ(mesh.triangles.size(), 2u * 3 * 8);
  EXPECT_EQ(mesh.warnings,
            (std::vector<std::string>{"t.ply: element 'range_grid' is left out (3 times)"}));
}

TEST(Ply, APointThatIsNowhereIsLeftOut) {
  const Mesh mesh =
      read(header("ascii", "element vertex 3\n" + kXyz) + "0 0 0\nnan nan nan\n1 0 0\n");
  EXPECT_EQ(mesh.triangles.size(), 2u * 3 * 8);
  EXPECT_FLOAT_EQ(mesh.positions[0], -1. / 720);
  EXPECT_EQ(mesh.warnings,
            (std::vector<std::string>{"t.ply:10:1: 'nan'; expected a finite number that single "
                                      "precision can hold; the point is left out (3 times)"}));
  EXPECT_EQ(error(header("ascii", "element vertex 1\n" + kXyz) + "nan 0 0\n"),
            "t.ply:9:1: 'nan'; expected a finite number that single precision can hold");
}

TEST(Ply, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(error("plx\n"), "t.ply:1:1: 'plx'; expected 'ply', as PLY files begin");
  EXPECT_EQ(error("ply\nformat binary 1.0\n"),
            "t.ply:2:8: 'binary'; expected ascii, binary_little_endian or binary_big_endian");
  EXPECT_EQ(error("ply\nformat ascii 1.0\nelement vertex 3\nproperty half x\n"),
            "t.ply:4:10: 'half'; expected a type: char, uchar, short, ushort, int, uint, float, "
            "double");
  EXPECT_EQ(error("ply\nformat ascii 1.0\n"),
            "t.ply:3:1: the file ends here; expected format, element, property, comment or "
            "end_header");
  const std::string head =
      header("ascii", "element vertex 3\n" + kXyz + "element face 1\n" + kFace);
  EXPECT_EQ(error(head + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"),
            "t.ply:12:3: 'nan'; expected a finite number that single precision can hold");
  EXPECT_EQ(error(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "t.ply:14:7: '3'; expected an index of 0 to 2");
  EXPECT_EQ(error(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n"),
            "t.ply:14:5: '1.5'; expected an index of 0 to 2");
  EXPECT_EQ(error(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1"),
            "t.ply:14:1: '3'; expected the number of values that follow in the line");
  EXPECT_EQ(error(head + "0 0 0 1 0 0\n0 1 0 3\n0 1"),
            "t.ply:12:7: '3'; expected a count of at most 2, which the file can hold")
      << "fewer lines than rows";
}

TEST(Ply, AValueTooManyOrTooFewCostsItsLineAlone) {
  const std::string head =
      header("ascii", "element vertex 5\n" + kXyz + "element edge 1\nproperty int v\n" +
                          "element face 2\nproperty int id\n" + kFace);
  const auto warning = [](const std::vector<std::string>& warnings, size_t i) {
    return i < warnings.size() ? warnings[i] : "none";
  };
  struct Case {
    const char *vertex, *face, *warning;
  };
  const std::vector<Case> cases{
      {"7 7", "9 3 0 1 2",
       ":19:4: the line ends here; expected a finite number that single "
       "precision can hold; the faces there are left out"},
      {"7 7 7 7 7", "9 3 0 1 2",
       ":19:7: '7'; expected the end of a row of 'vertex'; what is left of the line is not read"},
      {"7 7 7", "9 3 0 1 2 3 4",
       ":21:11: '3'; expected the end of a row of 'face'; what is left of the line is not read"},
      {"7 7 7", "9 3 0 1\n",
       ":21:3: '3'; expected the number of values that follow in the line; the line is left out"},
      {"7 7 7", "9",
       ":21:2: the line ends here; expected the number of values that follow in the line; the line "
       "is left out"},
      {"7 7 7", "9 -3 0 1 2",
       ":21:3: '-3'; expected the number of values that follow in the line; the line is left out"},
  };
  for (const Case& c : cases) {
    const Mesh mesh = read(head + "0 0 0\n1 0 0\r\n\n1 1 0 \n0 1 0\n" + c.vertex + "\n5 6 7\n" +
                           c.face + "\n9 3 0 2 3\n");
    ASSERT_GE(mesh.triangles.size(), 3u) << c.vertex << ", " << c.face;
    EXPECT_EQ(Indices(mesh.triangles.end() - 3, mesh.triangles.end()), (Indices{0, 2, 3}));
    EXPECT_EQ(
        std::count(mesh.warnings.begin(), mesh.warnings.end(), std::string("t.ply") + c.warning), 1)
        << c.warning << "\n"
        << warning(mesh.warnings, 0) << "\n"
        << warning(mesh.warnings, 3);
  }
  // Lines that are not rows: values follow one another.
  const Mesh mesh = read(header("ascii", "element vertex 4\n" + kXyz + "element face 1\n" + kFace) +
                         "0 0 0 1 0 0 1 1 0\n0 1 0 4 0\n1 2 3\n");
  EXPECT_EQ(mesh.triangles.size(), 6u);
  EXPECT_TRUE(mesh.warnings.empty());
}

TEST(Ply, ColoursOutsideTheirRangeAreTold) {
  for (const auto& [type, values, expected, taken] :
       std::vector<std::array<std::string, 4>>{{"float", "0 -.5 1", "-.5", "1"},
                                               {"float", "0 1.5 1", "1.5", "1"},
                                               {"int", "0 -7 1", "-7", "255"},
                                               {"short", "0 300 1", "300", "255"},
                                               {"uchar", "0 256 1", "256", "255"}}) {
    const Mesh mesh = read(header("ascii", "element vertex 3\n" + kXyz + "property " + type +
                                               " red\nproperty " + type + " green\nproperty " +
                                               type + " blue\nelement face 1\n" + kFace) +
                           "0 0 0 0 0 0\n1 0 0 0 0 0\n0 1 0 " + values + "\n3 0 1 2\n");
    const float one = type == "float" ? 1 : 1.f / 255 / 12.92f;
    EXPECT_FLOAT_EQ(mesh.colors.at(10), one) << "codes of 8 bits, whatever integer holds them";
    const bool is_below = expected[0] == '-';
    EXPECT_EQ(mesh.colors.at(9), is_below ? 0 : 1);
    EXPECT_EQ(mesh.warnings, std::vector<std::string>{fmt::format(
                                 "t.ply:16:9: '{}'; expected a colour of 0 to {}; {} is taken",
                                 expected, taken, is_below ? "0" : taken)});
  }
}

}  // namespace
}  // namespace tessera
