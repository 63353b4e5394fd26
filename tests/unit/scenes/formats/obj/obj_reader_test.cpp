#include "scenes/formats/obj/obj_reader.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
constexpr const char* kSquareUvNormal =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 2\n";

struct Mesh {
  std::vector<float> positions, normals, uvs, colors;
  std::vector<uint32_t> triangles, face_materials;
  std::vector<std::string> materials, warnings;
};

Mesh read(const std::string& text) {
  const LoadedScene loaded = parse_obj(text, "t.obj");
  Mesh mesh;
  mesh.warnings = loaded.warnings;
  if (loaded.scene.nodes_size() == 0) return mesh;
  const v1::Shape& shape = loaded.scene.nodes(0).shape();
  const v1::TriangleMesh& in = shape.mesh();
  mesh.positions = blob_values<float>(in.positions(), loaded.blobs);
  mesh.normals = blob_values<float>(in.normals(), loaded.blobs);
  mesh.uvs = blob_values<float>(in.uvs(), loaded.blobs);
  mesh.colors = blob_values<float>(in.colors(), loaded.blobs);
  mesh.triangles = blob_values<uint32_t>(in.triangles(), loaded.blobs);
  mesh.face_materials = blob_values<uint32_t>(in.face_materials(), loaded.blobs);
  mesh.materials.assign(shape.materials().begin(), shape.materials().end());
  return mesh;
}

std::string error(const std::string& text) {
  return error_of([&] { parse_obj(text, "t.obj"); });
}

using Floats = std::vector<float>;
using Indices = std::vector<uint32_t>;

TEST(Obj, ReadsEveryFormOfAFaceCorner) {
  const std::string v = kSquareUvNormal;
  EXPECT_EQ(read(v + "f 1 2 3").normals, Floats{});
  EXPECT_EQ(read(v + "f 1/1 2/2 3/3").uvs, (Floats{0, 0, 1, 0, 1, 1}));
  EXPECT_EQ(read(v + "f 1/1 2/2 3/3").normals, Floats{});
  EXPECT_EQ(read(v + "f 1//1 2//1 3//1").normals, (Floats{0, 0, 1, 0, 0, 1, 0, 0, 1}));
  EXPECT_EQ(read(v + "f 1//1 2//1 3//1").uvs, Floats{});
  const Mesh full = read(v + "f 1/3/1 2/2/1 3/1/1");
  EXPECT_EQ(full.uvs, (Floats{1, 1, 1, 0, 0, 0}));
  EXPECT_EQ(full.positions, (Floats{0, 0, 0, 1, 0, 0, 1, 1, 0}));
  EXPECT_EQ(full.triangles, (Indices{0, 1, 2}));
}

TEST(Obj, AnIndexMayBeginWithZeros) {
  EXPECT_EQ(read(std::string(kSquare) + "f 01 0000000000000000000002 3").triangles,
            (Indices{0, 1, 2}));
}

TEST(Obj, AByteOrderMarkIsNoPartOfTheFirstWord) {
  const Mesh mesh = read("\xEF\xBB\xBFv 5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3");
  EXPECT_EQ(mesh.positions, (Floats{5, 0, 0, 1, 0, 0, 0, 1, 0}));
  EXPECT_TRUE(mesh.warnings.empty());
  EXPECT_EQ(error("\xEF\xBB\xBFv 0 x 0\n"), "t.obj:1:5: 'x'; expected a coordinate")
      << "nor of its column";
}

TEST(Obj, CountsNegativeIndicesFromTheEnd) {
  const Mesh mesh = read(std::string(kSquareUvNormal) + "f -3/-1/-1 -2/-2/-1 -1/-3/-1\nv 9 9 9\n");
  EXPECT_EQ(mesh.positions, (Floats{0, 0, 0, 1, 0, 0, 1, 1, 0}));
  EXPECT_EQ(mesh.uvs, (Floats{1, 1, 1, 0, 0, 0}));
}

TEST(Obj, SharesVerticesWhoseIndicesAreEqual) {
  EXPECT_EQ(read(std::string(kSquare) + "f 1 2 3\nf 1 3 4\n").positions.size(), 12u);
  const Mesh seam = read(std::string(kSquare) + "vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 3/1 4/1\n");
  EXPECT_EQ(seam.positions.size(), 15u);
  EXPECT_EQ(seam.triangles, (Indices{0, 1, 2, 3, 2, 4}));
}

TEST(Obj, CutsPolygons) {
  EXPECT_EQ(read(std::string(kSquare) + "f 1 2 3 4").triangles, (Indices{0, 1, 2, 0, 2, 3}));
  const Mesh notch = read("v 0 0 0\nv 2 -1 0\nv .5 0 0\nv 2 1 0\nf 2 3 4 1\n");
  ASSERT_EQ(notch.triangles.size(), 6u);
  // Both triangles hold the notch and the tip opposite to it.
  for (const uint32_t corner : {1u, 3u}) {
    const auto position = [&](uint32_t i) { return notch.positions[3 * notch.triangles[i]]; };
    int found = 0;
    for (uint32_t i = 0; i < 6; ++i) found += position(i) == (corner == 1 ? .5f : 0.f);
    EXPECT_EQ(found, 2);
  }
}

TEST(Obj, IsFlatUnlessTheFileSaysOtherwise) {
  const std::string roof = "v 0 0 0\nv 2 0 0\nv 0 0 -2\nv 0 -2 0\n";
  EXPECT_EQ(read(roof + "f 1 2 3\nf 1 4 2\n").normals, Floats{});
  EXPECT_EQ(read(roof + "s off\nf 1 2 3\nf 1 4 2\n").normals, Floats{});
}

TEST(Obj, SmoothsInsideAGroupAndNotAcrossGroups) {
  // Two squares of equal area at a right angle, along the x axis.
  const std::string roof = "v 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nv 0 -1 0\nv 1 -1 0\n";
  const float half = std::sqrt(.5f);
  const Mesh smooth = read(roof + "s 1\nf 1 2 3 4\nf 1 5 6 2\n");
  ASSERT_EQ(smooth.positions.size(), 18u);
  EXPECT_NEAR(smooth.normals[1], half, 1e-6);
  EXPECT_NEAR(smooth.normals[2], half, 1e-6);
  EXPECT_EQ(Floats(smooth.normals.begin() + 6, smooth.normals.begin() + 9), (Floats{0, 1, 0}));
  const Mesh apart = read(roof + "s 1\nf 1 2 3 4\ns 2\nf 1 5 6 2\n");
  ASSERT_EQ(apart.positions.size(), 24u);
  EXPECT_EQ(Floats(apart.normals.begin(), apart.normals.begin() + 3), (Floats{0, 1, 0}));
  const Mesh half_flat = read(roof + "s 1\nf 1 2 3 4\ns off\nf 1 5 6 2\n");
  EXPECT_EQ(half_flat.normals.size(), half_flat.positions.size());
  EXPECT_EQ(Floats(half_flat.normals.end() - 3, half_flat.normals.end()), (Floats{0, 0, 1}));
}

TEST(Obj, SmoothNormalsDoNotSplitAtTextureSeams) {
  const std::string roof =
      "v 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nv 0 -1 0\nv 1 -1 0\nvt 0 0\nvt 1 1\ns 1\n";
  const Mesh mesh = read(roof + "f 1/1 2/1 3/1 4/1\nf 1/2 5/2 6/2 2/2\n");
  ASSERT_EQ(mesh.positions.size(), 24u);
  EXPECT_EQ(Floats(mesh.normals.begin(), mesh.normals.begin() + 3),
            Floats(mesh.normals.begin() + 12, mesh.normals.begin() + 15));
}

TEST(Obj, KeepsOneMeshForSeveralMaterials) {
  const Mesh mesh = read(std::string(kSquare) + "f 1 2 3\nusemtl a b\nf 1 3 4\nusemtl c\n" +
                         "usemtl a b\nf 1 2 4\n");
  EXPECT_EQ(mesh.materials, (std::vector<std::string>{"default", "a b", "c"}));
  EXPECT_EQ(mesh.face_materials, (Indices{0, 1, 1}));
  EXPECT_EQ(mesh.positions.size(), 12u);
  EXPECT_EQ(read(std::string(kSquare) + "usemtl a\nf 1 2 3\n").face_materials, Indices{});
}

TEST(Obj, ReadsColoursAndWeightsOfVertices) {
  const Mesh mesh = read("v 0 0 0 1\nv 1 0 0 .5 .25 0\nv 1 1 0 1 1 0 1\nf 1 2 3\n");
  ASSERT_EQ(mesh.colors.size(), 12u);
  const Floats expected{1, 1, 1, 1, .21404114f, .05087609f, 0, 1, 1, 0, 1, 1};
  for (size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(mesh.colors[i], expected[i], 1e-7) << i << ": sRGB codes, as for a PLY file's";
}

TEST(Obj, OneOddValueDoesNotCostTheFile) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 1 1 nan\nv 0 1 0\nv 2 0 1e39\n";
  const Mesh mesh =
      read(v + "vt nan 0\nvn 0 0 0\nvn 0 inf 0\nvn 0 1 0\nf 1 2 3\nf 1 5 2\nf 1/1/1 2/1/2 4/1/3\n" +
           "f 1 2\ns x\ns 4000000000\nf 1 2 4\n");
  EXPECT_EQ(mesh.triangles.size(), 6u) << "those at finite positions";
  EXPECT_EQ(Floats(mesh.uvs.begin(), mesh.uvs.begin() + 2), (Floats{0, 0}));
  EXPECT_EQ(Floats(mesh.normals.begin(), mesh.normals.begin() + 3), (Floats{0, 0, 1}))
      << "the face's own for one of no length";
  EXPECT_EQ(
      mesh.warnings,
      (std::vector<std::string>{
          "t.obj:3:7: 'nan'; expected a coordinate that is finite; the faces there are left out",
          "t.obj:5:7: '1e39'; expected a coordinate that single precision can hold; the faces "
          "there are left out",
          "t.obj:6:4: 'nan'; expected a texture coordinate that is finite; 0 is taken",
          "t.obj:7:8: a normal of no length; expected a direction; the faces there are as if "
          "it were not given (2 times)",
          "t.obj:8:6: 'inf'; expected a component of the normal that is finite; 0 is taken",
          "t.obj:13:6: a face with 2 corners; expected at least 3; it is left out",
          "t.obj:14:3: 'x'; expected a smoothing group's number, 'on' or 'off'; 'off' is taken",
          "t.obj:15:3: '4000000000'; expected a smoothing group up to 2147483646; that one is "
          "taken"}));
}

TEST(Obj, OnePartThatCannotBeReadDoesNotCostTheFile) {
  struct Case {
    const char *part, *warning;
  };
  const std::vector<Case> cases{
      {"f 1 2 9\n",
       "8:7: a vertex in '9', of 3 so far; expected a vertex before it; the face is left "
       "out"},
      {"f 1 2 0\n",
       "8:7: vertex 0 in '0'; expected a count from 1, or a negative one from the end; the face is "
       "left out"},
      {"f 1 2 -4\n",
       "8:7: a vertex in '-4', of 3 so far; expected a vertex before it; the face is left "
       "out"},
      {"f 1 2 x\n", "8:7: 'x'; expected a vertex index; the face is left out"},
      {"f 1 2 3/1/1/1\n", "8:7: '3/1/1/1'; expected v, v/t, v//n or v/t/n; the face is left out"},
      {"f 1 2 9\nf 9 2 3\nf 1 2 8\n",
       "8:7: a vertex in '9', of 3 so far; expected a vertex before it; the face is left "
       "out (3 times)"},
      {"v 1 x 0\nf 1 2 4\n", "8:5: 'x'; expected a coordinate; the faces there are left out"},
      {"v 1 2\nf 1 2 4\n",
       "8:6: the line ends here; expected a coordinate; the faces there are left out"},
      {"v 1 2 3 x\n", "8:9: 'x'; expected a number; 1 is taken"},
      {"v 1 2 3 .5 255 .5\n",
       "8:18: 255 in a vertex's colour; expected a share of 0 to 1; 1 is taken"},
      {"vt x\n", "8:4: 'x'; expected a texture coordinate; 0 is taken"},
      {"vn 1 0\n", "8:7: the line ends here; expected a component of the normal; 0 is taken"},
      {"usemtl\n", "8:7: usemtl without a name; expected a material's name; grey is taken"},
      {"\x1a\n", "8:1: binary data; expected the text of an OBJ file; the line is left out"},
  };
  for (const Case& c : cases) {
    const Mesh mesh = read(kSquareUvNormal + std::string(c.part) + "f 1/1/1 2/2/1 3/3/1\n");
    EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2})) << c.part;
    EXPECT_EQ(mesh.uvs, (Floats{0, 0, 1, 0, 1, 1})) << c.part;
    EXPECT_EQ(mesh.warnings, std::vector<std::string>{std::string("t.obj:") + c.warning});
  }
}

TEST(Obj, AFaceMayLackWhatItRefersTo) {
  const Mesh mesh = read(std::string(kSquare) + "f 1/1/1 2/2/1 3/3/1\n");
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(mesh.uvs, Floats{});
  EXPECT_EQ(mesh.warnings,
            (std::vector<std::string>{
                "t.obj:5:3: a texture coordinate in '1/1/1', of 0 so far; expected a texture "
                "coordinate before it; the face is without it (3 times)",
                "t.obj:5:3: a normal in '1/1/1', of 0 so far; expected a normal before it; the "
                "face is without it (3 times)"}));
}

TEST(Obj, OddValuesAreListedForAStrictReading) {
  const LoadedScene loaded =
      parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2\nf 1 2 3\n", "t.obj");
  EXPECT_EQ(loaded.warnings.size(), 2u) << "lines break no rule";
  ASSERT_EQ(loaded.repairs.size(), 1u);
  EXPECT_EQ(loaded.repairs[0].place.str(), "t.obj:5:6");
  EXPECT_EQ(loaded.repairs[0].found, "a face with 2 corners");
  EXPECT_EQ(loaded.repairs[0].expected, "at least 3");
}

TEST(Obj, TakesAnyLineEndJointTabAndComment) {
  for (const char* text :
       {"v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf 1 2 3\r\n", "v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3",
        "v\t0\t0 0 \nv 1 0 0 # x\nv 1 1 0\n  f 1 2 3 # f 1 2 9",
        "v 0 \\\n 0 0\nv 1 0 0\n"
        "v 1 1 0\nf 1 \\\r\n 2 3\\\n",
        "v 0 0 0\nv +1 .0 -0e5\nv 1. 1e0 0\nf 1 2 3\n\\"}) {
    const Mesh mesh = read(text);
    EXPECT_EQ(mesh.positions, (Floats{0, 0, 0, 1, 0, 0, 1, 1, 0})) << text;
  }
}

TEST(Obj, CountsWhatItLeavesOut) {
  const Mesh mesh =
      read(std::string(kSquare) + "l 1 2\nl 2 3\np 1\nf 1 2 3\nf 1 1 2\nfrob 1\nvp 1 2\n");
  EXPECT_EQ(mesh.warnings, (std::vector<std::string>{
                               "t.obj: lines (l) have no surface and are left out (2 times)",
                               "t.obj: points (p) have no surface and are left out",
                               "t.obj: triangles that name a vertex twice are left out",
                               "t.obj: unknown statement 'frob' is left out",
                               "t.obj: statement 'vp' describes no polygon and is left out"}));
}

TEST(Obj, SaysWhereAndWhatIsWrong) {
  const std::string v = kSquare;
  EXPECT_EQ(error(v + "f 1 2 5\n"),
            "t.obj:5:7: a vertex in '5', of 4 so far; expected a vertex before it");
  EXPECT_EQ(error(v + "f 1 2 0\n"),
            "t.obj:5:7: vertex 0 in '0'; expected a count from 1, or a negative one from the end");
  EXPECT_EQ(error(v + "f 1 2 -5\n"),
            "t.obj:5:7: a vertex in '-5', of 4 so far; expected a vertex before it");
  EXPECT_EQ(error(v + "f 1 2 x\n"), "t.obj:5:7: 'x'; expected a vertex index");
  EXPECT_EQ(error(v + "f 1 2 3/4/5/6\n").substr(0, 10), "t.obj:5:7:");
  EXPECT_EQ(error(v + "f 1 2 99999999999999999999\n"),
            "t.obj:5:7: a vertex in '99999999999999999999', of 4 so far; expected a vertex "
            "before it");
  EXPECT_EQ(error("v 0 0 0\r\nv 1 0\r\n"), "t.obj:2:6: the line ends here; expected a coordinate");
  EXPECT_EQ(error("v 0 \\\n 0 zero\n"), "t.obj:2:4: 'zero'; expected a coordinate");
  EXPECT_EQ(error("v 0 0 nan\n"), "t.obj:1:7: 'nan'; expected a coordinate that is finite");
  EXPECT_EQ(error("v 0 -inf 0\n"), "t.obj:1:5: '-inf'; expected a coordinate that is finite");
  EXPECT_EQ(error("v 0 0 1e39\n"),
            "t.obj:1:7: '1e39'; expected a coordinate that single precision can hold");
  EXPECT_EQ(error("v 1.0f 0 0\n"), "t.obj:1:3: '1.0f'; expected a coordinate");
  EXPECT_EQ(error("\n# text\n  hello you\n"),
            "t.obj:3:3: no vertex (v) in the whole file, but 'hello'; expected the text of an OBJ "
            "file");
  EXPECT_EQ(error("o rock\nhello\n").substr(0, 9), "t.obj:2:1");
  EXPECT_EQ(error(std::string("\x7f\0ELF\1", 6)).substr(0, 22), "t.obj:1:1: binary data");
}

TEST(Obj, TakesNumbersTooSmallForSinglePrecisionAsZero) {
  EXPECT_EQ(read("v 1e-60 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").positions[0], 0.f);
}

RC_GTEST_PROP(Obj, GivesBackTheMeshThatWasWritten, ()) {
  const auto points = *rc::gen::container<std::vector<std::array<int16_t, 3>>>(
      rc::gen::container<std::array<int16_t, 3>>(rc::gen::arbitrary<int16_t>()));
  RC_PRE(points.size() >= 3);
  const auto n = static_cast<int>(points.size());
  const auto faces = *rc::gen::nonEmpty(rc::gen::container<std::vector<std::array<int, 3>>>(
      rc::gen::container<std::array<int, 3>>(rc::gen::inRange(0, n))));
  const bool relative = *rc::gen::arbitrary<bool>();
  std::string text;
  for (const auto& p : points)
    text += "v " + std::to_string(p[0] / 8.0) + " " + std::to_string(p[1] / 8.0) + " " +
            std::to_string(p[2] / 8.0) + "\n";
  std::vector<std::array<int, 3>> kept;
  for (const auto& f : faces) {
    text += "f";
    for (const int i : f) text += " " + std::to_string(relative ? i - n : i + 1);
    text += "\n";
    if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) kept.push_back(f);
  }
  const Mesh mesh = read(text);
  RC_ASSERT(mesh.triangles.size() == 3 * kept.size());
  for (size_t t = 0; t < kept.size(); ++t)
    for (size_t i = 0; i < 3; ++i)
      for (size_t a = 0; a < 3; ++a)
        RC_ASSERT(mesh.positions[3 * mesh.triangles[3 * t + i] + a] ==
                  static_cast<float>(points[kept[t][i]][a]) / 8);
}

}  // namespace
}  // namespace tessera
