// Grids, extrusions, text, lines and what texture coordinates they get.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "scenes/import/to_affine.h"
#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

struct Mesh {
  std::vector<float> positions, normals, uvs, colors;
  std::vector<uint32_t> triangles;
};

Mesh mesh_of(const std::string& geometry, const std::string& appearance = "") {
  const auto loaded = parse_classic("Shape { geometry " + geometry + " appearance Appearance { " +
                                    appearance + " } }");
  const v1::TriangleMesh& mesh = loaded.scene.nodes(0).shape().mesh();
  return {blob_values<float>(mesh.positions(), loaded.blobs),
          blob_values<float>(mesh.normals(), loaded.blobs),
          blob_values<float>(mesh.uvs(), loaded.blobs),
          blob_values<float>(mesh.colors(), loaded.blobs),
          blob_values<uint32_t>(mesh.triangles(), loaded.blobs)};
}

/// Six times the volume that the mesh's faces enclose, positive where they face outward.
double volume6(const Mesh& mesh) {
  double sum = 0;
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
    double p[3][3];
    for (size_t k = 0; k < 3; ++k)
      for (size_t a = 0; a < 3; ++a) p[k][a] = mesh.positions[3 * mesh.triangles[t + k] + a];
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
           p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum;
}

constexpr const char* kTexture = "texture PixelTexture { image 1 1 1 255 }";
const std::string kGrid =
    "ElevationGrid { xDimension 3 zDimension 2 xSpacing 2 zSpacing 3 height [ 0 1 2 0 1 2 ] ";

TEST(X3dGeometry, GridsFaceUpRowByRow) {
  const Mesh grid = mesh_of(kGrid + "}", kTexture);
  EXPECT_EQ(grid.triangles.size(), 12u);
  EXPECT_TRUE(grid.normals.empty());  // flat without a crease angle
  const auto highest = std::max_element(grid.positions.begin(), grid.positions.end());
  EXPECT_EQ(*highest, 4);
  for (size_t t = 0; t < grid.triangles.size(); t += 3) {
    const float* a = &grid.positions[3 * grid.triangles[t]];
    const float* b = &grid.positions[3 * grid.triangles[t + 1]];
    const float* c = &grid.positions[3 * grid.triangles[t + 2]];
    const float up = (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]);
    EXPECT_GT(up, 0);
  }
  // s along x, t along z.
  for (size_t v = 0; v < grid.positions.size() / 3; ++v) {
    EXPECT_EQ(grid.uvs[2 * v], grid.positions[3 * v] / 4);
    EXPECT_EQ(grid.uvs[2 * v + 1], grid.positions[3 * v + 2] / 3);
  }
  // A tilted plane is smooth with its one normal.
  const Mesh smooth = mesh_of(kGrid + "creaseAngle 4 }");
  for (size_t v = 0; v < smooth.normals.size(); v += 3) {
    EXPECT_NEAR(smooth.normals[v], -1 / std::sqrt(5), 1e-6);
    EXPECT_NEAR(smooth.normals[v + 1], 2 / std::sqrt(5), 1e-6);
  }
  const Mesh faces =
      mesh_of(kGrid + "colorPerVertex FALSE color Color { color [ 1 0 0 0 1 0 ] } }");
  EXPECT_EQ(std::count(faces.colors.begin(), faces.colors.end(), 1.f), 8 + 8);
}

TEST(X3dGeometry, ExtrusionsEncloseWhatTheySweep) {
  // The default one: a square of side 2, one high.
  const Mesh box = mesh_of("Extrusion { }", kTexture);
  EXPECT_EQ(box.triangles.size(), 3u * (8 + 4));
  EXPECT_NEAR(volume6(box), 6 * 4, 1e-5);
  EXPECT_NEAR(volume6(mesh_of("Extrusion { ccw FALSE }")), -6 * 4, 1e-5);
  EXPECT_EQ(mesh_of("Extrusion { beginCap FALSE endCap FALSE }").triangles.size(), 24u);
  EXPECT_EQ(*std::max_element(box.uvs.begin(), box.uvs.end()), 1);
  EXPECT_EQ(*std::min_element(box.uvs.begin(), box.uvs.end()), 0);
  // A frustum of a pyramid, wherever its spine leads: h/3 (a^2 + ab + b^2).
  for (const char* spine : {"0 0 0, 0 3 0", "1 1 1, 1 -2 1", "0 0 0, 3 0 0", "0 0 0, 0 0 -3"})
    EXPECT_NEAR(
        volume6(mesh_of("Extrusion { scale [ 1 1, .5 .5 ] spine [ " + std::string(spine) + " ] }")),
        6 * (4 + 2 + 1), 1e-4)
        << spine;
  // A bend of 90 degrees: two arms mitred where they meet.
  EXPECT_NEAR(
      volume6(mesh_of("Extrusion { crossSection [ .1 .1 .1 -.1 -.1 -.1 -.1 .1 .1 .1 ] spine "
                      "[ 0 0 0, 0 4 0, 4 4 0 ] }")),
      6 * .04 * 8 * std::sqrt(.5), .7);
  // Turned by its orientation, the square's corner is at sqrt(2).
  const Mesh turned = mesh_of("Extrusion { orientation 0 1 0 .7853981633974483 }");
  EXPECT_NEAR(*std::max_element(turned.positions.begin(), turned.positions.end()), std::sqrt(2),
              1e-6);
  // A concave section is cut as such.
  EXPECT_NEAR(
      volume6(mesh_of("Extrusion { convex FALSE crossSection [ 2 0 2 -2 0 -2 0 0 1 -1 2 0 ] "
                      "}")),
      6 * 3, 1e-5);
  EXPECT_EQ(parse_classic("Shape { geometry Extrusion { spine [ 0 0 0 ] } }").warnings.size(), 1u);
}

TEST(X3dGeometry, AClosedExtrusionIsSmoothAllAround) {
  std::ostringstream circle;
  circle.precision(17);
  // The sine of a whole turn is 0 but for rounding.
  for (int i = 0; i <= 32; ++i) {
    const double a = -2 * std::numbers::pi * i / 32;
    circle << std::cos(a) << " " << std::sin(a) << ", ";
  }
  const Mesh tube =
      mesh_of("Extrusion { creaseAngle 1 beginCap FALSE endCap FALSE crossSection [ " +
              circle.str() + "] }");
  ASSERT_FALSE(tube.normals.empty());
  for (size_t v = 0; v < tube.normals.size(); v += 3) {
    EXPECT_NEAR(tube.normals[v], tube.positions[v], 1e-3);
    EXPECT_NEAR(tube.normals[v + 2], tube.positions[v + 2], 1e-3);
  }
}

TEST(X3dGeometry, TextureCoordinatesOfTheBoundingBox) {
  // Longest along z (4), then x (2): s and t by one scale.
  const std::string quad =
      "IndexedFaceSet { coordIndex [ 0 1 2 3 ] coord Coordinate { point [ 0 0 0 2 0 0 2 0 4 0 0 4 "
      "] } }";
  const Mesh mesh = mesh_of(quad, kTexture);
  ASSERT_EQ(mesh.uvs.size(), 8u);
  for (size_t v = 0; v < 4; ++v) {
    EXPECT_EQ(mesh.uvs[2 * v], mesh.positions[3 * v + 2] / 4);
    EXPECT_EQ(mesh.uvs[2 * v + 1], mesh.positions[3 * v] / 4);
  }
  EXPECT_TRUE(mesh_of(quad).uvs.empty());  // none where no texture wants them
  const auto spherical = parse_classic(
      "Shape { geometry IndexedFaceSet { coordIndex [ 0 1 2 ] coord Coordinate { point [ 0 0 0 1 0 "
      "0 0 1 0 ] } texCoord TextureCoordinateGenerator { mode \"SPHERE\" } } appearance Appearance "
      "{ " +
      std::string(kTexture) + " } }");
  EXPECT_EQ(spherical.scene.textures(0).mapping(), v1::Texture::VIEW_NORMAL);
}

TEST(X3dGeometry, CornersWrittenTwiceDoNotFillAConcaveFace) {
  const Mesh mesh = mesh_of(
      "IndexedFaceSet { convex FALSE coord Coordinate { point [ 0 .5 0 2.5 .5 0 2.5 .5 0 2.5 .5 0 "
      "2.5 1.85 0 2.85 1.85 0 2.85 .15 0 0 .15 0 0 .15 0 ] } coordIndex [ 0 1 2 3 4 5 6 7 8 ] }");
  double area = 0;
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const float* a = &mesh.positions[3 * mesh.triangles[t]];
    const float* b = &mesh.positions[3 * mesh.triangles[t + 1]];
    const float* c = &mesh.positions[3 * mesh.triangles[t + 2]];
    area += std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
  }
  EXPECT_NEAR(area, 2.85 * .35 + .35 * 1.35, 1e-5);
}

TEST(X3dGeometry, LinesAndPointsAreThinUnlitAndCastNoShadow) {
  const auto loaded = parse_classic(
      "Shape { appearance Appearance { material Material { emissiveColor 0 1 0 } } geometry "
      "IndexedLineSet { coordIndex [ 0 1 -1 1 2 ] coord DEF C Coordinate { point [ 0 0 0, 3 0 0, 3 "
      "4 0 ] } } } Shape { geometry PointSet { coord USE C color Color { color [ 1 0 0 0 1 0 0 0 1 "
      "] "
      "} } } Shape { geometry LineSet { vertexCount [ 2 ] coord USE C } }");
  ASSERT_EQ(loaded.scene.nodes_size(), 3);
  for (const v1::Node& node : loaded.scene.nodes()) EXPECT_TRUE(node.casts_no_shadow());
  EXPECT_EQ(loaded.scene.materials(0).unlit().color().value().g(), 1);
  EXPECT_EQ(loaded.scene.materials(0).unlit().color().value().r(), 0);
  const auto points =
      blob_values<float>(loaded.scene.nodes(0).shape().mesh().positions(), loaded.blobs);
  EXPECT_EQ(points.size(), 3u * 12) << "two prisms";
  const auto colors =
      blob_values<float>(loaded.scene.nodes(1).shape().mesh().colors(), loaded.blobs);
  EXPECT_EQ(colors.size(), 4u * 18);
  EXPECT_EQ(loaded.scene.nodes(2).shape().mesh().triangles().size(), 4u * 3 * 8);
}

TEST(X3dGeometry, OneOddPartDoesNotCostTheShape) {
  struct Case {
    std::string geometry;
    size_t triangles;
    std::string warning;
  };
  const std::string square = "coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] } ";
  const std::string faces = "IndexedFaceSet { " + square + "coordIndex [ 0 1 2 -1 0 2 3 ] ";
  const std::vector<Case> cases{
      {"IndexedFaceSet { " + square + "coordIndex [ 0 1 2 -1 0 2 4 ] }", 1,
       "coordIndex 4 in face 1 of IndexedFaceSet, which has 4 points; expected an index of a "
       "point; "
       "the face is left out"},
      {"IndexedFaceSet { " + square + "coordIndex [ 0 1 2 -1 0 -2 3 ] }", 1, "coordIndex -2 in"},
      {"IndexedFaceSet { " + square + "coordIndex [ 0 1 2 -1 0 x 3 ] }", 1,
       "coordIndex of IndexedFaceSet: 'x'; expected a 32-bit integer; the face is left out"},
      {"IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 nan 0 ] } "
       "coordIndex [ 0 1 2 -1 0 2 3 ] }",
       1, "'nan'; expected a finite number; what is there is left out"},
      {"IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 ] } "
       "coordIndex [ 0 1 2 -1 0 2 3 ] }",
       1, "point of Coordinate: 11 numbers; expected a multiple of 3; the last ones are left out"},
      {"TriangleStripSet { " + square + "stripCount [ 5 ] }", 2,
       "stripCount 5 of TriangleStripSet, which has 4 points left; expected 3 or more, and no more "
       "than are left; the points there are taken"},
      {"TriangleFanSet { " + square + "fanCount [ -1 4 ] }", 2, "fanCount -1 of TriangleFanSet"},
      {faces + "color Color { color [ 1 0 0 ] } colorPerVertex FALSE }", 2,
       "colorIndex 1 in face 1 of IndexedFaceSet, of 1 value; expected an index of a value; the "
       "nearest one is taken"},
      {faces + "color Color { color [ ] } }", 2,
       "no values for colorIndex of IndexedFaceSet; expected a value for each corner; it is left "
       "out"},
      {faces + "normal Normal { vector [ 0 0 1 ] } normalIndex [ 0 0 0 -1 0 0 ] }", 2,
       "normalIndex of IndexedFaceSet ends before face 1; expected a value for each corner; its "
       "last one is taken"},
      {faces + "texCoord TextureCoordinate { point [ 0 0 ] } texCoordIndex [ 0 0 0 -1 0 0 9 ] }", 2,
       "texCoordIndex 9 in face 1 of IndexedFaceSet, of 1 value; expected an index of a value"},
      {"ElevationGrid { xDimension 2 zDimension 3 height [ 0 1 2 3 4 ] }", 2,
       "5 heights of ElevationGrid, 2 x 3; expected xDimension times zDimension; the rows that are "
       "whole are taken"},
      {"ElevationGrid { xDimension 2 zDimension 2 height [ 0 1 2 3 4 ] }", 2,
       "t.x3dv:2:69: height of ElevationGrid: 5 for 2 x 2; expected xDimension times zDimension; "
       "the first ones are taken"},
      {"IndexedLineSet { " + square + "coordIndex [ 0 1 9 2 3 ] }", 16,
       "coordIndex 9 of IndexedLineSet, which has 4 points; expected an index of a point; the "
       "lines "
       "there are left out"},
      {"LineSet { " + square + "vertexCount [ 2 3 ] }", 16,
       "vertexCount 3 of LineSet, which has 2 points left; expected 2 or more, and no more than "
       "are "
       "left; the points there are taken"},
      {"PointSet { coord Coordinate { point [ 0 0 0, inf 0 0 ] } }", 8,
       "'inf'; expected a finite number; what is there is left out"},
  };
  for (const Case& c : cases) {
    const LoadedScene loaded = parse_classic("Shape { geometry " + c.geometry + " }");
    ASSERT_EQ(loaded.scene.nodes_size(), 1) << c.geometry;
    EXPECT_EQ(blob_values<uint32_t>(loaded.scene.nodes(0).shape().mesh().triangles(), loaded.blobs)
                  .size(),
              3 * c.triangles)
        << c.geometry;
    ASSERT_FALSE(loaded.warnings.empty()) << c.geometry;
    EXPECT_NE(loaded.warnings[0].find(c.warning), std::string::npos) << loaded.warnings[0];
    EXPECT_GE(loaded.repairs.size(), 1u) << c.geometry;
  }
}

TEST(X3dGeometry, APixelTextureMayLackValues) {
  const auto read = [](const std::string& image) {
    return parse_classic("Shape { appearance Appearance { texture PixelTexture { image " + image +
                         " } } geometry Box { } }");
  };
  for (const auto& [image, textures, warning] :
       std::vector<std::tuple<std::string, int, std::string>>{
           {"2 2 1 1 2 3", 1,
            "image of PixelTexture: 3 pixels for 2 x 2; expected one number a pixel; the others "
            "are 0"},
           {"2 1 1 255 0x1ff", 1,
            "t.x3dv:2:72: image of PixelTexture: pixel 511; expected 0 to 255; its low 8 bits are "
            "taken"},
           {"1 1 3 -1", 1,
            "t.x3dv:2:68: image of PixelTexture: pixel -1; expected 0 to 16777215; its low 24 bits "
            "are taken"},
           {"1 1 3 1.5", 1,
            "t.x3dv:2:68: image of PixelTexture: '1.5'; expected a 32-bit integer; 0 is taken"},
           {"2 2 1 1 2 3 4 5", 1,
            "image of PixelTexture: 5 pixels for 2 x 2; expected one number a pixel; the first "
            "ones are taken"},
           {"60000 60000 1 1", 0,
            "image of PixelTexture: 1 pixel for 60000 x 60000; expected one number a pixel; it is "
            "left out"},
           {"2 2", 0,
            "image of PixelTexture: '2 2'; expected width, height and components; it is left"},
           {"2 -2 1 1 2", 0,
            "image of PixelTexture: '2 -2 1 1 2'; expected sides of 0 to 65536"}}) {
    const LoadedScene loaded = read(image);
    EXPECT_EQ(loaded.scene.textures_size(), textures) << image;
    EXPECT_TRUE(loaded.scene.nodes(0).shape().has_box());
    ASSERT_EQ(loaded.warnings.size(), 1u);
    EXPECT_NE(loaded.warnings[0].find(warning), std::string::npos) << loaded.warnings[0];
  }
}

TEST(X3dGeometry, APixelOutOfRangeHasItsLowBits) {
  const LoadedScene loaded = parse_classic(
      "Shape { appearance Appearance { texture PixelTexture { image 2 1 1 0x112 -1 } } geometry "
      "Box { } }");
  EXPECT_EQ(blob_values<uint8_t>(loaded.scene.textures(0).image().texels(), loaded.blobs)[0], 0x12);
  // Four bytes fill an integer, whose sign is none.
  EXPECT_TRUE(parse_classic("Shape { appearance Appearance { texture PixelTexture { image 2 1 4 "
                            "0xFFFFFFFF -2 } } geometry Box { } }")
                  .warnings.empty());
}

TEST(X3dGeometry, SpacingsAndScalesBelowZeroAreTakenWithAWarning) {
  const LoadedScene grid = parse_classic(
      "Shape { geometry ElevationGrid { xDimension 2 zDimension 2 xSpacing -2 zSpacing 0 height [ "
      "0 1 2 3 ] } }");
  EXPECT_EQ(grid.warnings,
            (std::vector<std::string>{
                "t.x3dv:2:69: xSpacing of ElevationGrid: '-2'; expected a length above 0; it is "
                "taken as it is",
                "t.x3dv:2:81: zSpacing of ElevationGrid: '0'; expected a length above 0; it is "
                "taken as it is"}));
  const auto points =
      blob_values<float>(grid.scene.nodes(0).shape().mesh().positions(), grid.blobs);
  EXPECT_EQ(*std::min_element(points.begin(), points.end()), -2);
  EXPECT_EQ(parse_classic("Shape { geometry Extrusion { scale -1 1 } }").warnings,
            std::vector<std::string>{"t.x3dv:2:36: scale of Extrusion: '-1 1'; expected 0 or more; "
                                     "it is taken as it is"});
  EXPECT_TRUE(parse_classic("Transform { scale -1 1 1 }").warnings.empty()) << "10.4.4: mirrored";
}

TEST(X3dGeometry, NumbersOutOfRangeCostNoMoreThanTheirFaces) {
  struct Case {
    std::string geometry;
    size_t triangles;
    std::vector<std::string> warnings;
  };
  const std::string range = "; expected a number in the range of single precision; ";
  const std::string far =
      ", which is too far; expected points in the range of single precision; it is left out";
  for (const Case& c : std::vector<Case>{
           {"ElevationGrid { xDimension 3 zDimension 2 xSpacing 1e300 height [ 0 1 2 3 4 5 ] }",
            2,
            {"2:69: xSpacing of ElevationGrid: '1e300'" + range + "3.40282e+38 is taken",
             "2:18: face 1 of ElevationGrid" + far}},
           {"ElevationGrid { xDimension 2 zDimension 3 zSpacing -1e300 height [ 0 1 2 3 4 5 ] }",
            2,
            {"2:69: zSpacing of ElevationGrid: '-1e300'" + range + "-3.40282e+38 is taken",
             "2:69: zSpacing of ElevationGrid: '-1e300'; expected a length above 0; it is taken as "
             "it is",
             "2:18: face 1 of ElevationGrid" + far}},
           {"ElevationGrid { xDimension 2 zDimension 2 height [ 0 1 2 1e999 ] creaseAngle 1e300 }",
            2,
            {"2:75: height of ElevationGrid: '1e999'" + range + "3.40282e+38 is taken",
             "2:95: creaseAngle of ElevationGrid: '1e300'" + range + "3.40282e+38 is taken"}},
           {"IndexedFaceSet { coordIndex [ 0 1 2 -1 0 1 3 ] coord Coordinate { point [ 0 0 0 1 0 0 "
            "0 1e300 0 0 1 0 ] } }",
            1,
            {"2:106: point of Coordinate: '1e300'" + range + "what is there is left out"}},
           {"Extrusion { orientation 0 1 0 1e300 }",
            12,
            {"2:48: orientation of Extrusion: '1e300'" + range + "3.40282e+38 is taken"}},
       }) {
    const LoadedScene loaded = parse_classic("Shape { geometry " + c.geometry + " }");
    ASSERT_EQ(loaded.scene.nodes_size(), 1) << c.geometry;
    const v1::TriangleMesh& mesh = loaded.scene.nodes(0).shape().mesh();
    EXPECT_EQ(blob_values<uint32_t>(mesh.triangles(), loaded.blobs).size(), 3 * c.triangles)
        << c.geometry;
    for (const float p : blob_values<float>(mesh.positions(), loaded.blobs))
      EXPECT_TRUE(std::isfinite(p)) << c.geometry;
    std::vector<std::string> expected;
    for (const std::string& warning : c.warnings) expected.push_back("t.x3dv:" + warning);
    EXPECT_EQ(loaded.warnings, expected) << c.geometry;
    EXPECT_EQ(render_loaded(loaded, 4, 4).size(), 48u);
  }
  // Nothing is left of a shape whose every point is too far.
  const LoadedScene none = parse_classic(
      "Shape { geometry Extrusion { scale [ 1e300 1e300 ] "
      "spine [ 1e38 0 0 2e38 1 0 ] crossSection [ 3 3 4 3 3 4 ] } }");
  EXPECT_FALSE(none.scene.nodes(0).has_shape());
}

/// How many pixels' worth of the 20 x 20 in the middle of a picture of 720 x 720 white lines and
/// points cover.
double coverage(const std::string& scene) {
  constexpr int kSide = 720, kBegin = 350, kEnd = 370;
  constexpr uint32_t kSamples = 64;
  LoadedScene loaded = parse_classic(scene);
  loaded.scene.mutable_settings()->mutable_sampling()->set_samples_per_pixel(kSamples);
  const auto renderer = make_tile_renderer(loaded.scene, loaded.blobs, frame_of(kSide, kSide), 1);
  const TilePixels tile = render_rect(*renderer, {kBegin, kBegin, kEnd, kEnd}, kSamples);
  double sum = 0;
  for (size_t p = 0; p < tile.values.size(); p += static_cast<size_t>(tile.channels))
    sum += double{tile.values[p]};
  return sum;
}

TEST(X3dGeometry, LinesAndPointsAreAsWideInThePictureNearAndFar) {
  for (const std::string distance : {"1", "100", "10000"}) {
    const std::string begin =
        "Viewpoint { position 0 0 0 fieldOfView 1.5707963 } Transform { scale " + distance + " " +
        distance + " " + distance + " children Shape { geometry ";
    const double line = coverage(
        begin + "LineSet { vertexCount 2 coord Coordinate { point [ -1 0 -1, 1 0 -1 ] } } } }");
    EXPECT_NEAR(line / 20, 1.6, .15) << "pixels at distance " << distance;
    const double point = coverage(begin + "PointSet { coord Coordinate { point 0 0 -1 } } } }");
    EXPECT_NEAR(point, 2, .2) << "an octahedron of 2 pixels at distance " << distance;
  }
}

TEST(X3dGeometry, APointAloneIsSeen) {
  for (const std::string at : {"0 0 0", "1e6 0 -3e5"}) {
    const double point =
        coverage("Shape { geometry PointSet { coord Coordinate { point " + at + " } } }");
    EXPECT_GT(point, 20) << at;
  }
}

TEST(X3dGeometry, LinesAndPointsAreAsWideWhereANodeIsStretched) {
  for (const std::string scale : {"1 100 1", "100 1 1"}) {
    const std::string begin =
        "Viewpoint { position 0 0 0 fieldOfView 1.5707963 } Transform { scale " + scale +
        " children Shape { geometry ";
    for (const std::string ends : {"-1 0 -1, 1 0 -1", "0 -1 -1, 0 1 -1"}) {
      const double line = coverage(begin + "LineSet { vertexCount 2 coord Coordinate { point [ " +
                                   ends + " ] } } } }");
      EXPECT_NEAR(line / 20, 1.6, .15) << ends << " stretched by " << scale;
    }
    const double point = coverage(begin + "PointSet { coord Coordinate { point 0 0 -1 } } } }");
    EXPECT_NEAR(point, 2, .2) << "stretched by " << scale;
  }
}

TEST(X3dGeometry, ALineIsAsWideAtItsFarEndAndThinBesideTheEye) {
  const auto radii = [](const std::string& view, const std::string& appearance = "") {
    const auto loaded = parse_classic(
        view +
        " Shape { geometry LineSet { vertexCount 2 coord Coordinate { point [ 1 0 -100, 1 0 "
        "50 ] } } " +
        appearance + " }");
    const auto points =
        blob_values<float>(loaded.scene.nodes().rbegin()->shape().mesh().positions(), loaded.blobs);
    std::map<int, double> out;  // by z
    for (size_t v = 0; v < points.size(); v += 3) {
      double& radius = out[static_cast<int>(std::lround(points[v + 2]))];
      radius = std::max(radius, double{std::hypot(points[v] - 1, points[v + 1])});
    }
    return out;
  };
  const double unit = 1. / 360;
  auto seen = radii("Viewpoint { position 0 0 0 fieldOfView 1.5707963 }");
  ASSERT_EQ(seen.size(), 3u) << "the prism has a waist beside the eye";
  EXPECT_NEAR(seen[-100], 100 * unit, 1e-4);
  EXPECT_NEAR(seen[0], .001 * unit, 1e-6);
  EXPECT_NEAR(seen[50], 50 * unit, 1e-4);
  seen = radii(
      "Transform { translation 0 0 -50 children Group { children Viewpoint { position 0 0 "
      "0 fieldOfView 1.5707963 } } }");
  EXPECT_NEAR(seen[-100], 50 * unit, 1e-4) << "wherever the viewpoint stands";
  seen = radii("");
  EXPECT_NEAR(seen[-100], 150. / 2 * unit, 1e-4) << "where a view of all of it is as large";
  EXPECT_NEAR(seen[50], 150. / 2 * unit, 1e-4);
  seen = radii("OrthoViewpoint { fieldOfView [ -2 -1 2 1 ] }");
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_NEAR(seen[50], unit, 1e-6);
  const auto properties = [](const std::string& fields) {
    return "appearance Appearance { lineProperties LineProperties { " + fields + " } }";
  };
  const std::string view = "OrthoViewpoint { }";
  EXPECT_NEAR(radii(view, properties("linewidthScaleFactor 3"))[50], 3 * unit, 1e-6);
  EXPECT_NEAR(radii(view, properties("linewidthScaleFactor .5"))[50], unit, 1e-6);
  EXPECT_NEAR(radii(view, properties("linewidthScaleFactor 3 applied FALSE"))[50], unit, 1e-6);
}

TEST(X3dGeometry, GeneratedCoordinatesAreThoseOfTheCamera) {
  const auto texture = [](const std::string& mode) {
    return parse_classic(
               "Viewpoint { position 3 2 10 } Shape { geometry Sphere { texCoord "
               "TextureCoordinateGenerator { mode \"" +
               mode +
               "\" } } appearance "
               "Appearance { " +
               std::string(kTexture) +
               " textureTransform TextureTransform { translation .5 0 } } }")
        .scene.textures(0);
  };
  const Affine eye = to_affine(texture("COORD-EYE").transform());
  EXPECT_EQ(texture("COORD-EYE").mapping(), v1::Texture::WORLD);
  EXPECT_EQ(eye(Point3{4, 2, 0}), (Point3{1.5, 0, -10})) << "then the TextureTransform";
  const Affine normal = to_affine(texture("CAMERASPACENORMAL").transform());
  EXPECT_EQ(texture("CAMERASPACENORMAL").mapping(), v1::Texture::VIEW_NORMAL);
  EXPECT_EQ(normal(Point3{.5, 1, 0}), (Point3{.5, 1, 0}));
  EXPECT_EQ(texture("SPHERE").mapping(), v1::Texture::VIEW_NORMAL);
  EXPECT_EQ(to_affine(texture("SPHERE").transform())(Point3{.5, 1, 0}), (Point3{1, 1, 0}));
}

TEST(X3dGeometry, TextIsWrittenAsItsStyleSays) {
  const auto extent = [](const Mesh& mesh, size_t axis) {
    float low = 1e9f, high = -1e9f;
    for (size_t v = axis; v < mesh.positions.size(); v += 3) {
      low = std::min(low, mesh.positions[v]);
      high = std::max(high, mesh.positions[v]);
    }
    return std::pair{low, high};
  };
  const auto text = [](const std::string& strings, const std::string& style) {
    return mesh_of("Text { string [ " + strings + " ] fontStyle FontStyle { " + style + " } }");
  };
  const auto plain = extent(text("\"HH\"", ""), 0);
  EXPECT_NEAR(plain.first, 0, .01);
  const double width = plain.second;
  EXPECT_NEAR(extent(text("\"HH\"", "size 3"), 0).second, 3 * width, 1e-4);
  const auto middle = extent(text("\"HH\"", "justify \"MIDDLE\""), 0);
  EXPECT_NEAR(middle.first, -middle.second, .2);
  EXPECT_LT(extent(text("\"HH\"", "justify \"END\""), 0).second, .01);
  // The second line is one size below the first.
  EXPECT_NEAR(extent(text("\"H\" \"H\"", "spacing 2"), 1).first, -2, .01);
  EXPECT_NEAR(extent(mesh_of("Text { string \"HH\" length 5 }"), 0).second, 5, .2 * 5);
  EXPECT_NEAR(extent(mesh_of("Text { string \"HHHH\" maxExtent 1 }"), 0).second, 1, .15);
  for (char c = '!'; c <= '~'; ++c) {
    if (c == '"' || c == '\\') continue;
    EXPECT_FALSE(mesh_of("Text { string \"" + std::string(1, c) + "\" }").triangles.empty());
  }
  EXPECT_EQ(parse_classic("Shape { geometry Text { string \"\xc3\xa4\" } }").warnings.size(), 1u);
}

}  // namespace
}  // namespace tessera
