// The validation scenes of the octree study, every pixel held against the lighting equation worked
// out here by itself: in double precision, by brute force, without a line of the renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

struct V {
  double x = 0, y = 0, z = 0;
  V operator+(const V& o) const { return {x + o.x, y + o.y, z + o.z}; }
  V operator-(const V& o) const { return {x - o.x, y - o.y, z - o.z}; }
  V operator*(double s) const { return {x * s, y * s, z * s}; }
  V operator*(const V& o) const { return {x * o.x, y * o.y, z * o.z}; }
  auto operator<=>(const V&) const = default;
};
double dot(const V& a, const V& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
V cross(const V& a, const V& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
V unit(const V& a) { return a * (1 / std::sqrt(dot(a, a))); }

std::string text(const V& v) {
  std::ostringstream out;
  out.precision(17);
  out << v.x << ' ' << v.y << ' ' << v.z;
  return out.str();
}
std::string text(double v) { return text(V{v, 0, 0}).substr(0, text(V{v, 0, 0}).find(' ')); }

struct Look {
  V diffuse{.8, .8, .8}, specular{};
  double shininess = .2;
};
struct Ball {
  V center;
  double radius = 1;
  Look look{};
};
struct Facet {
  V corner[3], normal[3];
  Look look{};
};
struct Lamp {
  enum class Kind { directional, point, spot } kind;
  V color{1, 1, 1}, location{}, direction{0, 0, -1}, attenuation{1, 0, 0};
  double beam = .5, cut_off = 1;
};

struct Scene {
  std::vector<Ball> balls{};
  std::vector<Facet> facets{};
  std::vector<Lamp> lamps{};
  double fov = .7854;
};

struct Seen {
  double distance;
  V normal;
  const Look* look;
};

void meet(const Ball& ball, const V& from, const V& along, std::optional<Seen>& nearest) {
  const V m = from - ball.center;
  const double b = dot(m, along), c = dot(m, m) - ball.radius * ball.radius;
  if (b * b < c) return;
  const double t = -b - std::sqrt(b * b - c);
  if (t > 1e-9 && (!nearest || t < nearest->distance))
    nearest = {t, unit(from + along * t - ball.center), &ball.look};
}

void meet(const Facet& facet, const V& from, const V& along, std::optional<Seen>& nearest) {
  const V e1 = facet.corner[1] - facet.corner[0], e2 = facet.corner[2] - facet.corner[0];
  const V p = cross(along, e2), s = from - facet.corner[0], q = cross(s, e1);
  const double det = dot(e1, p);
  if (det <= 0) return;  // the back
  const double u = dot(s, p) / det, v = dot(along, q) / det, t = dot(e2, q) / det;
  if (u < 0 || v < 0 || u + v > 1 || t <= 1e-9 || (nearest && t >= nearest->distance)) return;
  nearest = {t, unit(facet.normal[0] * (1 - u - v) + facet.normal[1] * u + facet.normal[2] * v),
             &facet.look};
}

std::optional<Seen> meet(const Scene& scene, const V& from, const V& along) {
  std::optional<Seen> nearest;
  for (const Ball& ball : scene.balls) meet(ball, from, along, nearest);
  for (const Facet& facet : scene.facets) meet(facet, from, along, nearest);
  return nearest;
}

V lit(const Scene& scene, const Lamp& lamp, const V& point, const Seen& seen, const V& to_eye) {
  const bool far = lamp.kind == Lamp::Kind::directional;
  const V way = far ? lamp.direction * -1 : lamp.location - point;
  const double d = far ? 1e9 : std::sqrt(dot(way, way));
  const V l = unit(way);
  const double cosine = dot(seen.normal, l);
  if (cosine <= 0) return {};
  const auto hidden = meet(scene, point + seen.normal * 1e-6, l);
  if (hidden && hidden->distance < d) return {};
  double share = far ? 1
                     : 1 / std::max(1., lamp.attenuation.x + lamp.attenuation.y * d +
                                            lamp.attenuation.z * d * d);
  if (lamp.kind == Lamp::Kind::spot) {
    const double off = std::acos(std::clamp(-dot(l, unit(lamp.direction)), -1., 1.));
    if (lamp.beam >= lamp.cut_off)
      share *= off < lamp.cut_off;
    else
      share *= std::clamp((off - lamp.cut_off) / (lamp.beam - lamp.cut_off), 0., 1.);
  }
  const double specular =
      std::pow(std::max(0., dot(seen.normal, unit(l + to_eye))), 128 * seen.look->shininess);
  return (seen.look->diffuse * cosine + seen.look->specular * specular) * lamp.color * share;
}

V expected(const Scene& scene, int x, int y, int width, int height) {
  const double half = std::tan(scene.fov / 2) / std::min(width, height);
  const V along = unit({(2 * (x + .5) - width) * half, (height - 2 * (y + .5)) * half, -1});
  const V eye{0, 0, 10};
  const auto seen = meet(scene, eye, along);
  V sum;
  if (!seen) return sum;
  const V point = eye + along * seen->distance;
  for (const Lamp& lamp : scene.lamps) sum = sum + lit(scene, lamp, point, *seen, along * -1);
  return sum;
}

std::string appearance(const Look& look) {
  return "appearance Appearance { material Material { diffuseColor " + text(look.diffuse) +
         " specularColor " + text(look.specular) + " shininess " + text(look.shininess) + " } } ";
}

std::string x3d(const Scene& scene, const std::string& mesh) {
  std::string out = "NavigationInfo { headlight FALSE } Viewpoint { fieldOfView " +
                    text(scene.fov) + " } " + mesh;
  for (const Ball& ball : scene.balls)
    out += "Transform { translation " + text(ball.center) + " children Shape { " +
           appearance(ball.look) + "geometry Sphere { radius " + text(ball.radius) + " } } }\n";
  for (const Lamp& lamp : scene.lamps) {
    const std::string place =
        "location " + text(lamp.location) + " attenuation " + text(lamp.attenuation) + " ";
    const std::string way = "direction " + text(lamp.direction) + " ";
    switch (lamp.kind) {
      case Lamp::Kind::directional:
        out += "DirectionalLight { " + way;
        break;
      case Lamp::Kind::point:
        out += "PointLight { " + place;
        break;
      case Lamp::Kind::spot:
        out += "SpotLight { " + place + way + "beamWidth " + text(lamp.beam) + " cutOffAngle " +
               text(lamp.cut_off) + " ";
    }
    out += "color " + text(lamp.color) + " }\n";
  }
  return out;
}

/// Every pixel to within `most`; returns how many show something.
int hold(const Scene& scene, double most, const std::string& mesh = "", int width = 96,
         int height = 54) {
  const auto values = render_x3d(x3d(scene, mesh), width, height);
  int lit_pixels = 0, wrong = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const V want = expected(scene, x, y, width, height);
      const float* got = &values[3 * (static_cast<size_t>(y) * static_cast<size_t>(width) +
                                      static_cast<size_t>(x))];
      lit_pixels += want.x + want.y + want.z > 0;
      wrong += std::abs(got[0] - want.x) > most || std::abs(got[1] - want.y) > most ||
               std::abs(got[2] - want.z) > most;
    }
  }
  EXPECT_EQ(wrong, 0) << x3d(scene, "").substr(0, 600);
  return lit_pixels;
}

TEST(OctreeStudy, OneSphereUnderADirectionalLight) {
  Scene scene{.balls = {{.center = {.5, -.25, 0}, .radius = 2}}};
  scene.lamps = {{.kind = Lamp::Kind::directional, .direction = {-1, -2, -3}}};
  EXPECT_GT(hold(scene, 1e-6), 400);
}

TEST(OctreeStudy, SpotLightWithBeamWidthAndCutOff) {
  Scene scene{.balls = {{.center = {0, 0, 0}, .radius = 3}}};
  scene.lamps = {{.kind = Lamp::Kind::spot,
                  .color = {1, .9, .5},
                  .location = {1, 2, 6},
                  .direction = {-.5, -2, -6},
                  .attenuation = {0, .25, .05},
                  .beam = .1,
                  .cut_off = .4}};
  EXPECT_GT(hold(scene, 2e-6), 200);
  scene.lamps[0].beam = .5;  // wider than the cut-off: a hard edge
  EXPECT_GT(hold(scene, 2e-6), 200);
}

TEST(OctreeStudy, FourSpheresWithColouredLightsAndFourFieldsOfView) {
  const Look shiny{.diffuse = {.7, .6, .5}, .specular = {.5, .5, .5}, .shininess = .4};
  Scene scene{.balls = {{.center = {-2, 1.5, 0}, .radius = 1.2, .look = shiny},
                        {.center = {2, 1.5, -1}, .radius = 1.4, .look = shiny},
                        {.center = {-2, -1.5, -2}, .radius = 1.3, .look = shiny},
                        {.center = {2, -1.5, 1}, .radius = .9, .look = shiny}}};
  scene.lamps = {
      {.kind = Lamp::Kind::point, .color = {1, 0, 0}, .location = {0, 0, 0}},
      {.kind = Lamp::Kind::point, .color = {0, 1, 0}, .location = {0, 6, 5}},
      {.kind = Lamp::Kind::directional, .color = {.25, .25, 1}, .direction = {1, 0, -2}}};
  for (const double fov : {.7, .8, .9, 1.}) {
    scene.fov = fov;
    EXPECT_GT(hold(scene, 1e-5), 300);
  }
}

/// An icosahedron whose triangles are cut in four `levels` times, on the unit sphere.
std::vector<std::array<V, 3>> icosphere(int levels) {
  const double g = (1 + std::sqrt(5)) / 2;
  const std::vector<V> p{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                         {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  const int faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                            {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                            {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                            {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  std::vector<std::array<V, 3>> out;
  for (const auto& f : faces)
    out.push_back({unit(p[static_cast<size_t>(f[0])]), unit(p[static_cast<size_t>(f[1])]),
                   unit(p[static_cast<size_t>(f[2])])});
  for (int level = 0; level < levels; ++level) {
    std::vector<std::array<V, 3>> finer;
    for (const auto& [a, b, c] : out) {
      const V ab = unit(a + b), bc = unit(b + c), ca = unit(c + a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    out = std::move(finer);
  }
  return out;
}

/// As a file holds it, and with the normals that a crease angle of 0 or pi gives.
std::string icosphere_text(const Look& look, bool smooth, std::vector<Facet>& facets) {
  std::map<V, int> numbers;
  std::map<V, V> normals;
  std::string index, points;
  auto triangles = icosphere(2);
  for (auto& triangle : triangles) {
    for (V& p : triangle) {
      // The mesh keeps single precision.
      p = {static_cast<float>(p.x * 2), static_cast<float>(p.y * 2), static_cast<float>(p.z * 2)};
      const auto [at, is_new] = numbers.try_emplace(p, static_cast<int>(numbers.size()));
      if (is_new) points += text(p) + ", ";
      index += std::to_string(at->second) + " ";
    }
    index += "-1 ";
    const auto& [a, b, c] = triangle;
    for (const V& p : triangle) normals[p] = normals[p] + cross(b - a, c - a);
  }
  for (const auto& [a, b, c] : triangles) {
    const V flat = cross(b - a, c - a);
    facets.push_back({{a, b, c}, {flat, flat, flat}, look});
    if (smooth) {
      Facet& facet = facets.back();
      for (size_t k = 0; k < 3; ++k) facet.normal[k] = unit(normals[facet.corner[k]]);
    }
  }
  return "Shape { " + appearance(look) + "geometry IndexedFaceSet { creaseAngle " +
         (smooth ? "4" : "0") + " coordIndex [ " + index + " ] coord Coordinate { point [ " +
         points + " ] } } }\n";
}

TEST(OctreeStudy, IcospheresOfTwoShininesses) {
  for (const double shininess : {1., .1}) {
    for (const bool smooth : {false, true}) {
      const Look look{.diffuse = {.2, .3, .6}, .specular = {1, 1, .8}, .shininess = shininess};
      Scene scene;
      const std::string mesh = icosphere_text(look, smooth, scene.facets);
      // Before the ball, so that no facet is lit whose neighbours could hide the lamp.
      scene.lamps = {{.kind = Lamp::Kind::point, .location = {1, 2, 9}}};
      EXPECT_GT(hold(scene, 2e-4, mesh), 300) << shininess << smooth;
    }
  }
}

}  // namespace
}  // namespace tessera
