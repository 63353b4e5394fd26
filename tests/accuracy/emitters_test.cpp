// Light from every kind of emitter, by Lambert's formula for polygons and by cones.
#include <vector>

#include "renderer/math/transform.h"
#include "tests/accuracy/estimate.h"

namespace tessera {
namespace {

std::string vec(const std::string& name, const Vec3& v) {
  return name + " { x: " + number(v.x) + " y: " + number(v.y) + " z: " + number(v.z) + " } ";
}

/// A parallelogram, or what `rectangle` makes of one, and its corners.
struct Patch {
  Vec3 corner, u, v;
  std::vector<Vec3> corners() const { return {corner, corner + u, corner + u + v, corner + v}; }
  std::string rectangle() const {
    return "rectangle { " + vec("corner", corner) + vec("edge_u", u) + vec("edge_v", v) + "}";
  }
  std::string polygon() const {
    std::string points;
    for (const Vec3& p : corners()) points += vec("points", p);
    return "polygon { " + points + "}";
  }
};

/// Out of the camera's way, which looks down the z axis; all face the origin.
const Patch kPatches[] = {
    {{0.8, -1, -0.5}, {0, 0, 1.5}, {0, 2, 0}},         // near, cut by the horizon: by solid angle
    {{3, -0.4, -0.3}, {0, 0.2, 0.9}, {-0.3, 1, 0.2}},  // skewed, cut by the horizon: by area
    {{-5, 1, 1}, {1, 0.5, -0.6}, {0.2, 1, 1}},         // tilted, far
};

TEST(Emitters, PolygonsOfAnyPlaceAcrossTheHorizon) {
  for (const Patch& patch : kPatches) {
    const double truth = wall(2 * irradiance(patch.corners()));
    ASSERT_GT(truth, 0.001);
    // Of two sides, so that it does not matter which way round its corners go.
    const std::string lamp = material("both", 0, 2);
    expect_estimate(truth, estimate(kLampAndWall + lamp + node(patch.rectangle(), "both")));
    expect_estimate(truth, estimate(kLampAndWall + lamp + node(patch.polygon(), "both")));
  }
}

TEST(Emitters, TexturesShineWhereTheyAreBright) {
  // Two of four quarters are white; one of these lies below the horizon.
  const std::string checked =
      "textures { name: 'checks' mapping: OBJECT checker { even { value { r: 1 g: 1 b: 1 } } odd { "
      "value { } } } } materials { name: 'checked' classic { diffuse { value { } } emission { "
      "texture: 'checks' value { r: 2 g: 2 b: 2 } } } } ";
  const Patch whole{{0.8, -1, -1}, {0, 0, 2}, {0, 2, 0}};
  const Patch white{{0.8, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  const double truth = wall(2 * irradiance(white.corners()));
  for (const std::string& shape : {whole.rectangle(), whole.polygon()})
    expect_estimate(truth, estimate(kLampAndWall + checked + node(shape, "checked")));
  const std::string mesh =
      "mesh { inline_positions: [.8, -1, -1, .8, -1, 1, .8, 1, 1, .8, 1, -1] inline_triangles: [0, "
      "1, 2, 0, 2, 3] }";
  expect_estimate(truth, estimate(kLampAndWall + checked + node(mesh, "checked")));
}

TEST(Emitters, ShinesFromTheSideThatIsThereOrIsChosen) {
  // Into a ball whose near half is not there, its front being inside.
  const double r = 0.5, d = 1.2;
  expect_estimate(
      wall(2 * kPi * r * r / (d * d)),
      estimate(
          "cameras { world_from_camera { steps { look_at { eye { x: -9 y: -9 z: 1 } target { } "
          "} } } } " +
          kLampAndWall +
          "nodes { shape { materials: 'lamp' flip_normals: true sphere { center { z: 1.2 } "
          "radius: .5 } } } "));
  // A back that emits, but as no surface whose points are chosen.
  const Patch& patch = kPatches[0];
  const std::string sides =
      "materials { name: 'back' unlit { color { value { r: 2 g: 2 b: 2 } } } } materials { name: "
      "'sides' sides: BACK_MATERIAL back: 'back' classic { diffuse { value { } } emission { value "
      "{ "
      "r: 2 g: 2 b: 2 } } } } ";
  for (const bool flip : {false, true}) {
    const std::string shape = patch.rectangle() + (flip ? " flip_normals: true" : "");
    expect_estimate(wall(2 * irradiance(patch.corners())),
                    estimate(kLampAndWall + sides + node(shape, "sides")));
  }
}

TEST(Emitters, TexturesAreFoundAgainFarAway) {
  // All of a small scene far from the origin, where a point is sure to a millionth of its distance.
  const auto far = [](const std::string& material) {
    const std::string to = "translate { x: 8000000 y: 9000000 z: -8000000 } ";
    return "cameras { world_from_camera { steps { " + to +
           "} steps { look_at { eye { z: .001 } target { } up { y: 1 } } } } } " + kLampAndWall +
           "materials { name: 'textured' classic { diffuse { value { } } emission { texture: 't' "
           "value { r: 2 g: 2 b: 2 } } } } textures { name: 't' gradient { positions: 0 colors { "
           "r: "
           "1 g: 1 b: 1 } } } nodes { transform { steps { " +
           to + "} } children { shape { materials: '" + material +
           "' rectangle { corner { x: .0001 y: -.0001 } edge_u { z: .0002 } edge_v { y: .0002 } } "
           "} "
           "} children { shape { materials: 'wall' rectangle { corner { x: -.01 y: -.01 } edge_u { "
           "x: "
           ".02 } edge_v { y: .02 } } } } } ";
  };
  const Estimate even = estimate(far("both") + material("both", 0, 2));
  const Estimate textured = estimate(far("textured"));
  EXPECT_NEAR(textured.mean, even.mean, 0.01 * even.mean);
}

TEST(Emitters, BoxesAreTheirFaces) {
  // Emits from outside alone; three faces look at the origin, one of them is cut by the horizon.
  const Vec3 low{0.7, 0.5, -0.4}, size{0.8, 1.1, 1.3};
  const std::string box = "box { " + vec("min", low) + vec("max", low + size) + "}";
  const Vec3 x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
  const double e = irradiance(Patch{low, y, z}.corners()) + irradiance(Patch{low, x, z}.corners());
  expect_estimate(wall(2 * e), estimate(kLampAndWall + node(box, "lamp")));
}

TEST(Emitters, MeshesWhereverTheyStand) {
  // A square of two triangles under a transform that is no similarity and mirrors.
  const std::string mesh =
      "nodes { transform { steps { translate { x: 1.5 y: .3 z: .8 } } steps { rotate { axis { x: 1 "
      "y: 2 z: .5 } angle: 50 } } steps { scale { x: -1.5 y: .7 z: 2 } } } shape { materials: "
      "'both' mesh { inline_positions: [0, 0, 0, 1, 0, 0, 1, 1, 0.5, 0, 1, 0.5] "
      "inline_triangles: [0, 1, 2, 0, 2, 3] } } } ";
  const Affine place = translation({1.5, 0.3, 0.8}) * rotation({1, 2, 0.5}, 50 * kPi / 180) *
                       scaling({-1.5, 0.7, 2});
  std::vector<Vec3> corners;
  for (const Point3& p : {Point3{0, 0, 0}, Point3{1, 0, 0}, Point3{1, 1, 0.5}, Point3{0, 1, 0.5}})
    corners.push_back(place(p) - Point3{});
  expect_estimate(wall(2 * irradiance(corners)),
                  estimate(kLampAndWall + material("both", 0, 2) + mesh));
}

TEST(Emitters, MeshesOfManyTrianglesThatBothWaysOfSamplingFind) {
  // A wall of light of 128 triangles near by, shining from its front: what scattering finds must
  // know how seldom its triangle would have been chosen.
  const Patch patch{{0.8, -1, -0.5}, {0, 0, 1.5}, {0, 2, 0}};
  constexpr int kSide = 8;
  std::string positions, triangles;
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j)
      positions += number(static_cast<double>(i) / kSide) + ", 0, " +
                   number(static_cast<double>(j) / kSide) + ", ";
  }
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const int a = i * (kSide + 1) + j, b = a + kSide + 1;
      for (const int corner : {a, b, b + 1, a, b + 1, a + 1})
        triangles += std::to_string(corner) + ", ";
    }
  }
  positions.resize(positions.size() - 2), triangles.resize(triangles.size() - 2);
  const auto mesh_of = [&](const std::string& corners) {
    return "mesh { inline_positions: [" + positions + "] inline_triangles: [" + corners + "] } ";
  };
  const std::string mesh = mesh_of(triangles);
  const double truth = wall(2 * irradiance(patch.corners()));
  // x becomes z and z becomes y, so that its front looks down -x.
  const std::string turn =
      "steps { translate { x: .8 y: -1 z: -.5 } } steps { rotate { axis { x: 1 y: 1 z: 1 } angle: "
      "240 } } ";
  const auto lamp_of = [&](const std::string& shape, const std::string& height) {
    return estimate(kLampAndWall + "nodes { transform { " + turn +
                    "steps { scale { x: 1.5 z: 2 y: " + height +
                    " } } } shape { materials: 'lamp' " + shape + "} } ");
  };
  const auto of_lamp = [&](const std::string& height, const std::string& more) {
    return lamp_of(mesh + more, height);
  };
  expect_estimate(truth, of_lamp("1", ""));
  expect_estimate(truth, of_lamp("7", ""));
  expect_estimate(truth, of_lamp("-1", "flip_normals: true"));
  // All of it once more, and a triangle once more the other way round: hits tell the first alone.
  expect_estimate(
      truth,
      lamp_of(mesh_of(triangles + ", " + triangles + ", 1, 0, " + std::to_string(kSide + 1)), "1"));
}

TEST(Emitters, MeshesOfWhichVertexColoursLeaveSomeOutShineByWhatIsLeft) {
  const Patch patch{{0.05, -4, 0.01}, {0, 0, 4}, {0, 8, 0}};
  BlobStore blobs;
  const float colors[] = {1, 1, 1, .75F, 1, 1, 1, .75F, 1, 1, 1, .75F, 1, 1, 1, .75F};
  const auto* const begin = reinterpret_cast<const std::byte*>(colors);
  const Digest digest = blobs.put(std::vector<std::byte>(begin, begin + sizeof colors));
  const std::string mesh =
      "mesh { inline_positions: [.05, -4, .01, .05, -4, 4.01, .05, 4, 4.01, .05, 4, .01] "
      "inline_triangles: "
      "[0, 1, 2, 0, 2, 3] colors { digest: '" +
      digest.hex() + "' size: 64 } }";
  expect_estimate(wall(2 * .75 * irradiance(patch.corners())),
                  estimate(kLampAndWall + material("both", 0, 2) + node(mesh, "both"), "", blobs));
}

TEST(Emitters, RingsAreDiscsWithoutDiscs) {
  const double outer = 1.5, inner = 0.9, h = 2;
  const auto of_disc = [&](double r) { return kPi * r * r / (r * r + h * h); };
  // The camera looks through the hole.
  expect_estimate(
      wall(2 * (of_disc(outer) - of_disc(inner))),
      estimate(
          kLampAndWall +
          node("disc { center { z: 2 } normal { z: -1 } radius: 1.5 inner_radius: .9 }", "lamp")));
}

TEST(Emitters, EllipsoidsAndCylindersBySamplingAndByScatteringAlone) {
  // An oblate ball above the wall is seen as a cone with tan^2 = a^2 / (d^2 - c^2), a cylinder from
  // below as the disc that it ends in.
  const std::string from =
      "cameras { world_from_camera { steps { look_at { eye { x: -9 y: -9 z: 1 } target { } } } } "
      "} ";
  const double a = 1.5, c = 0.5, d = 2, tan2 = a * a / (d * d - c * c);
  expect_estimate(
      wall(2 * kPi * tan2 / (1 + tan2)),
      estimate(from + kLampAndWall +
               "nodes { transform { steps { translate { z: 2 } } steps { scale { x: 1.5 "
               "y: 1.5 z: .5 } } } shape { materials: 'lamp' sphere { } } } "));
  const double r = 1.2, h = 1.5;
  // Solids made of others are no lamps that are chosen.
  const std::string cylinder = "shape { materials: 'lamp' cylinder { radius: 1.2 height: 1 } } ";
  for (const std::string& shape : {cylinder, "shape { csg { operands { " + cylinder + "} } } "}) {
    expect_estimate(wall(2 * kPi * r * r / (r * r + h * h)),
                    estimate(from + kLampAndWall +
                             "nodes { transform { steps { translate { z: 2 } } steps { rotate { "
                             "axis { x: 1 } angle: 90 } } } " +
                             shape + "} "));
  }
}

TEST(Emitters, ManyLampsAddUp) {
  // Of all sizes and powers, some behind the wall: the tree of lights may choose
  // them as it likes, the sum is the same.
  std::string scene = kLampAndWall;
  double truth = 0;
  for (int i = 0; i < 40; ++i) {
    const double turn = 2.4 * i, out = 1.5 + 0.15 * i, size = 0.1 + 0.02 * (i % 7);
    const Vec3 at{out * std::cos(turn), out * std::sin(turn), 0.3 * (i % 11) - 0.4};
    const Vec3 u = Vec3{-std::sin(turn), std::cos(turn), 0} * size, v = Vec3{0.3, 0, 1} * size;
    const Patch patch{at, u, v};
    const double emitted = 1 + i % 5;
    const std::string name = "lamp" + std::to_string(i);
    scene += material(name, 0, emitted) + node(patch.rectangle(), name);
    truth += emitted * irradiance(patch.corners());
  }
  expect_estimate(wall(truth), estimate(scene));
}

TEST(Emitters, LargeLampsThatBothWaysOfSamplingFind) {
  // Four near walls of light, one of them brighter: what scattering finds must know how seldom
  // the tree would have chosen it.
  const Patch east{{0.8, -0.8, -0.5}, {0, 0, 1.5}, {0, 1.6, 0}};
  std::string scene = kLampAndWall;
  double truth = 0;
  for (int i = 0; i < 4; ++i) {
    const auto turned = [&](const Vec3& v) {
      return i == 0   ? v
             : i == 1 ? Vec3{-v.x, -v.y, v.z}
             : i == 2 ? Vec3{-v.y, v.x, v.z}
                      : Vec3{v.y, -v.x, v.z};
    };
    const Patch patch{turned(east.corner), turned(east.u), turned(east.v)};
    const double emitted = i == 0 ? 5 : 1;
    const std::string name = "large" + std::to_string(i);
    scene += material(name, 0, emitted) + node(patch.rectangle(), name);
    truth += emitted * irradiance(patch.corners());
  }
  expect_estimate(wall(truth), estimate(scene));
}

TEST(Emitters, PanoramasByTheirBrightness) {
  // All light comes from between 20 and 30 degrees off the normal, and a lamp has its share.
  BlobStore blobs;
  std::vector<std::byte> rows(18);
  rows[2] = std::byte{255};
  const std::string sky =
      "textures { name: 'sky' image { texels { digest: '" + blobs.put(std::move(rows)).hex() +
      "' } width: 1 height: 18 channels: 1 bits: 8 encoding: ENCODING_LINEAR filter: NEAREST } } "
      "background { panorama { texture: 'sky' intensity: 5 } orientation { steps { rotate { axis { "
      "x: 1 } angle: 90 } } } } ";
  const auto sine2 = [](double degrees) { return std::pow(std::sin(degrees * kPi / 180), 2); };
  const double band = 5 * kPi * (sine2(30) - sine2(20));
  expect_estimate(wall(band), estimate(sky + kLampAndWall, "", blobs));
  expect_estimate(
      wall(band + 2 * irradiance(kPatches[0].corners())),
      estimate(sky + kLampAndWall + material("both", 0, 2) + node(kPatches[0].rectangle(), "both"),
               "", blobs));
}

}  // namespace
}  // namespace tessera
