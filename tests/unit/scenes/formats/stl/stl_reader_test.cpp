#include "scenes/formats/stl/stl_reader.h"

#include <gtest/gtest.h>

#include <cctype>
#include <limits>

#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

using Floats = std::vector<float>;
using Indices = std::vector<uint32_t>;

struct Mesh {
  Floats positions;
  Indices triangles;
  std::vector<std::string> warnings;
};

Mesh read(const std::string& bytes) {
  const LoadedScene loaded = parse_stl(bytes, "t.stl");
  Mesh mesh{.positions = {}, .triangles = {}, .warnings = loaded.warnings};
  if (loaded.scene.nodes_size() == 0) return mesh;
  const v1::TriangleMesh& in = loaded.scene.nodes(0).shape().mesh();
  mesh.positions = blob_values<float>(in.positions(), loaded.blobs);
  mesh.triangles = blob_values<uint32_t>(in.triangles(), loaded.blobs);
  return mesh;
}

std::string error(const std::string& bytes) {
  return error_of([&] { parse_stl(bytes, "t.stl"); });
}

std::string facet(const std::string& a, const std::string& b, const std::string& c) {
  return " facet normal 0 0 -nan(ind)\n  outer loop\n   vertex " + a + "\n   vertex " + b +
         "\n   vertex " + c + "\n  endloop\n endfacet\n";
}

std::string binary(const std::string& head, const std::vector<Floats>& triangles) {
  std::string bytes = head;
  bytes.resize(80, ' ');
  const auto count = static_cast<uint32_t>(triangles.size());
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const Floats& corners : triangles) {
    bytes.append(12, '\0');
    bytes.append(reinterpret_cast<const char*>(corners.data()), 36);
    bytes.append(2, '\0');
  }
  return bytes;
}

const std::vector<Floats> kSquare{{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, -0.f, 1, 1, 0, 0, 1, 0}};
const Floats kSquarePoints{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

TEST(Stl, ReadsTextAndBinaryAlike) {
  const Mesh text = read("solid a square\n" + facet("0 0 0", "1 0 0", "1 1 0") +
                         "endsolid a square\nsolid\nendsolid\nsolid two\n" +
                         facet("0 0 -0", "1e0 1 0", "0 1 +0") + "end solid\n");
  const Mesh bytes = read(binary("made by a program", kSquare));
  for (const Mesh& mesh : {text, bytes}) {
    EXPECT_EQ(mesh.positions, kSquarePoints) << "equal corners share a vertex";
    EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2, 0, 2, 3}));
    EXPECT_TRUE(mesh.warnings.empty());
  }
}

TEST(Stl, IsNotFooledByABinaryHeaderThatSaysSolid) {
  EXPECT_EQ(read(binary("solid made by a program", kSquare)).positions, kSquarePoints);
  EXPECT_EQ(read(binary("\xEF\xBB\xBFsolid", kSquare)).positions, kSquarePoints);
  EXPECT_EQ(read(binary("solid", kSquare) + "more").positions, kSquarePoints);
  EXPECT_EQ(read(binary("solid", kSquare) + "more").warnings.size(), 1u);
}

TEST(Stl, ReadsKeywordsInCapitalsAndAfterAByteOrderMark) {
  std::string capitals = "Solid Part\n" + facet("0 0 0", "1 0 0", "1 1 0") + "endsolid Part\n";
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  EXPECT_EQ(read(capitals).triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(read("\xEF\xBB\xBF" + capitals).triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(error("\xEF\xBB\xBFsolid x\nfacet NORMAL 0 0 1\nOUTER lop\n"),
            "t.stl:3:7: 'lop'; expected 'loop'");
}

TEST(Stl, ReadsTextThatIsOneLine) {
  std::string line = "solid the facet plate\n" + facet("0 0 0", "1 0 0", "1 1 0") +
                     "endsolid the facet plate\nsolid two\n" + facet("0 0 0", "1 1 0", "0 1 0") +
                     "endsolid two";
  EXPECT_EQ(read(line).positions, kSquarePoints);
  for (char& c : line)
    if (c == '\n') c = ' ';
  const Mesh mesh = read(line);
  EXPECT_EQ(mesh.positions, kSquarePoints);
  EXPECT_TRUE(mesh.warnings.empty());
  // In time that grows with the square of their number these would outlast the test's time limit.
  std::string many;
  constexpr int kSolids = 300'000;
  for (int i = 0; i < kSolids; ++i) many += "solid a endsolid a ";
  EXPECT_EQ(read(many + line).positions, kSquarePoints);
}

TEST(Stl, SaysWhatIsWrongWithAHeaderThatSaysSolid) {
  std::string damaged = binary("solid made by a program", kSquare);
  damaged.replace(80, 4, "\1\1\1\1");
  EXPECT_EQ(read(damaged).positions, kSquarePoints);
  EXPECT_EQ(read(damaged).warnings,
            std::vector<std::string>{
                "t.stl: 'solid', but zeros behind it as in binary files, and 16843009 triangles in "
                "the header; expected 2, which the file can hold; those are read"});
  std::string wide;
  for (const char c : "solid x\n" + facet("0 0 0", "1 0 0", "1 1 0")) wide += {c, '\0'};
  for (const std::string& bytes : {wide, "\xFF\xFE" + wide})
    EXPECT_EQ(error(bytes).substr(0, 25), "t.stl:1:1: text in UTF-16");
}

TEST(Stl, LeavesOutWhatHasNoExtent) {
  const Mesh mesh = read(binary("", {kSquare[0], {0, 0, 0, 0, 0, 0, 1, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(mesh.warnings.size(), 1u);
  EXPECT_TRUE(read("solid empty\nendsolid empty\n").triangles.empty());
}

TEST(Stl, FindsManyPointsAgain) {
  std::vector<Floats> triangles;
  for (int i = 0; i < 3000; ++i) {
    const auto x = static_cast<float>(i);
    triangles.push_back({x, 0, 0, x + 1, 0, 0, x, 1, 0});
  }
  const Mesh mesh = read(binary("", triangles));
  EXPECT_EQ(mesh.triangles.size(), 9000u);
  EXPECT_EQ(mesh.positions.size() / 3, 6001u);
}

TEST(Stl, OneOddTriangleDoesNotCostTheFile) {
  auto triangles = kSquare;
  triangles.insert(triangles.begin(),
                   {0, 0, 0, 1, 0, std::numeric_limits<float>::infinity(), 0, 1, 0});
  const Mesh by_bytes = read(binary("", triangles));
  EXPECT_EQ(by_bytes.positions, kSquarePoints);
  EXPECT_EQ(by_bytes.warnings,
            std::vector<std::string>{"t.stl: triangle 1 of 3: coordinate inf; expected finite "
                                     "numbers; the triangle is left out"});
  const Mesh text =
      read("solid x\n" + facet("0 0 0", "nan nan 0", "0 1 0") + facet("0 0 0", "1 0 0", "1 1 0"));
  EXPECT_EQ(text.triangles.size(), 3u);
  EXPECT_EQ(text.warnings, std::vector<std::string>{
                               "t.stl:5:11: 'nan'; expected a coordinate that single precision "
                               "can hold; the triangle is left out"});
}

TEST(Stl, TheNumberOfTrianglesMayBeWrong) {
  const auto announcing = [](uint32_t count, const std::vector<Floats>& triangles) {
    std::string bytes = binary("", triangles);
    bytes.replace(80, 4, reinterpret_cast<const char*>(&count), sizeof count);
    return bytes;
  };
  for (const uint32_t count : {0u, 1u, 3u, 0xFFFFFFFFu}) {
    const Mesh mesh = read(announcing(count, kSquare));
    EXPECT_EQ(mesh.positions, kSquarePoints) << count;
    EXPECT_EQ(mesh.warnings,
              std::vector<std::string>{"t.stl: " + std::to_string(count) +
                                       " triangles in the header; expected 2, which the file "
                                       "can hold; those are read"});
  }
  const std::string whole = binary("", kSquare);
  const Mesh cut = read(whole.substr(0, whole.size() - 1));
  EXPECT_EQ(cut.triangles, (Indices{0, 1, 2}));
  EXPECT_EQ(cut.warnings,
            std::vector<std::string>{"t.stl: 2 triangles in the header; expected 1, which the "
                                     "file can hold; those are read"});
  const std::string text = "as long as one more triangle, but no numbers at all";
  EXPECT_EQ(read(whole + text.substr(0, 50)).positions, kSquarePoints);
  EXPECT_EQ(read(whole + text.substr(0, 50)).warnings,
            std::vector<std::string>{"t.stl: what follows the last triangle is not read"});
  std::string other = "\x89PNG";
  for (int i = 0; i < 1000; ++i) other += static_cast<char>(i * i % 251);
  EXPECT_NE(error(other).find("triangles in the header; expected 18"), std::string::npos);
}

TEST(Stl, OneFacetThatCannotBeReadDoesNotCostTheFile) {
  const std::string good = facet("0 0 0", "1 0 0", "1 1 0");
  struct Case {
    std::string text, warning;
  };
  const std::vector<Case> cases{
      {facet("0 0 0", "1 0 x", "0 1 0") + good,
       "5:15: 'x'; expected a coordinate that single precision can hold"},
      {"facet normal 0 0 1\nouter lop\n" + good, "3:7: 'lop'; expected 'loop'"},
      {"facet\n" + good, "3:2: 'facet'; expected 'normal'"},
      {"facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 endloop endfacet\n" + good,
       "2:57: 'endloop'; expected 'vertex'"},
      {"color 1 0 0\n" + good, "2:1: 'color'; expected facet, solid or endsolid"},
      {good + good.substr(0, good.find("1 0 0")),
       "12:11: the file ends here; expected a coordinate that single precision can hold"},
      {good + std::string(30, '\0'), "9:1: "},
  };
  for (const Case& c : cases) {
    const Mesh mesh = read("solid x\n" + c.text);
    EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2})) << c.text;
    ASSERT_EQ(mesh.warnings.size(), 1u) << c.text;
    EXPECT_EQ(mesh.warnings[0].substr(0, 6 + c.warning.size()), "t.stl:" + c.warning);
    EXPECT_TRUE(mesh.warnings[0].ends_with("; the triangle is left out")) << mesh.warnings[0];
  }
}

TEST(Stl, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(error("hello"),
            "t.stl: neither 'solid' nor the 84 bytes that binary files begin with; expected an STL "
            "file");
  EXPECT_EQ(error(binary("", {{0, 0, 0, 1, 0, std::numeric_limits<float>::quiet_NaN(), 0, 1, 0}})),
            "t.stl: triangle 1 of 1: coordinate nan; expected finite numbers");
  EXPECT_EQ(error("solid x\n" + facet("0 0 0", "1 0 x", "0 1 0")),
            "t.stl:5:15: 'x'; expected a coordinate that single precision can hold");
  EXPECT_EQ(error("solid x\nfacet normal 0 0 1\nouter lop\n"), "t.stl:3:7: 'lop'; expected 'loop'");
  EXPECT_EQ(error("solid x\nfacet normal 0 0"),
            "t.stl:2:17: the file ends here; expected a component of the normal");
}

}  // namespace
}  // namespace tessera
