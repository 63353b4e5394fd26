#include "studio/files/templates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace tessera {
namespace {

constexpr const char* kEmpty = R"(metadata { title: "Untitled" }
settings {
    width: 960
    height: 540
}
cameras {
    name: "camera"
    world_from_camera {
        steps { look_at { eye { x: 0 y: 2 z: 8 } target { x: 0 y: 0 z: 0 } } }
    }
    perspective { field_of_view: 45 axis: VERTICAL }
}
background { solid { r: 0.2 g: 0.2 b: 0.2 } }
)";

constexpr const char* kLux = R"(# Project LUX: its defaults, and its one model.
metadata { title: "LUX" }
settings {
    width: 1600
    height: 900
    integrator { kind: "whitted" shadows: SHADOWS_OFF }
    output { tone_map: REINHARD }
}
cameras {
    name: "camera"
    # Along +z, with y down.
    world_from_camera {
        steps {
            look_at {
                eye { x: 0 y: 0 z: -10 }
                target { x: 0 y: 0 z: 0 }
                up { x: 0 y: -1 z: 0 }
            }
        }
    }
    perspective { field_of_view: 25 axis: VERTICAL }
}
background { solid { r: 0.02 g: 0.02 b: 0.04 } }
materials {
    name: "white"
    classic {
        diffuse { value { r: 1 g: 1 b: 1 } }
        diffuse_model: HALF_LAMBERT
        diffuse_exponent: 3
        flat: true
    }
    sides: FRONT_ONLY
}
nodes {
    # Surfaces that face +x are brightest.
    light { directional { direction { x: -1 y: 0 z: 0 } } }
}
includes {
    file: "sphere.obj"
    transform {
        steps { translate { x: 0 y: 0 z: 0 } }
        steps { rotate { axis { x: 1 } angle: 0 } }
        steps { rotate { axis { y: 1 } angle: 0 } }
        steps { rotate { axis { z: 1 } angle: 0 } }
        steps { scale { x: 1 y: 1 z: 1 } }
    }
    material: "white"
}
)";

constexpr const char* kCrt =
    R"(-- Lengths are metres, angles degrees; x is right, y up, z away from the camera.

red = Material { color -> rgb(0.8, 0.2, 0.1) reflectivity -> 0.2 }
grey = Material { color -> rgb(0.6, 0.6, 0.6) }

cam = Camera {
    position -> vec3(0, 1.5, -5)
    pointing -> vec3(0, 0.8, 0)
    fov      -> 45
}

lamp = PointLight {
    origin  -> vec3(3, 4, -3)
    color   -> rgb(1, 1, 1)
    ambient -> 0.1
}

Settings {
    title  -> "Untitled"
    camera -> cam
    lights -> [lamp]
}

Scene {
    Plane { normal -> vec3(0, 1, 0) position -> vec3(0, 0, 0) material -> grey }
    Sphere { center -> vec3(0, 1, 0) radius -> 1 material -> red }
}
)";

using Point = std::array<double, 3>;
using Triangle = std::array<size_t, 3>;

Point middle(const Point& a, const Point& b) {
  const Point sum{a[0] + b[0], a[1] + b[1], a[2] + b[2]};
  const double length = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
  return {sum[0] / length, sum[1] / length, sum[2] / length};
}

/// An icosahedron whose 20 faces are cut into four each: a ball of radius 1 and 80 triangles.
std::string sphere() {
  constexpr double kShort = 0.52573111211913360603, kLong = 0.85065080835203993218;
  std::vector<Point> points{{-kShort, kLong, 0},  {kShort, kLong, 0},   {-kShort, -kLong, 0},
                            {kShort, -kLong, 0},  {0, -kShort, kLong},  {0, kShort, kLong},
                            {0, -kShort, -kLong}, {0, kShort, -kLong},  {kLong, 0, -kShort},
                            {kLong, 0, kShort},   {-kLong, 0, -kShort}, {-kLong, 0, kShort}};
  constexpr std::array<Triangle, 20> kFaces{
      {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
       {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  std::map<std::pair<size_t, size_t>, size_t> middles;
  const auto between = [&](size_t a, size_t b) {
    const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), points.size());
    if (is_new) points.push_back(middle(points[a], points[b]));
    return found->second;
  };
  std::vector<Triangle> triangles;
  for (const auto& [a, b, c] : kFaces) {
    const size_t ab = between(a, b), bc = between(b, c), ca = between(c, a);
    for (const Triangle& part :
         {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{ca, bc, c}, Triangle{ab, bc, ca}})
      triangles.push_back(part);
  }
  std::string text = "# A ball of radius 1: an icosahedron whose faces are cut into four each.\n";
  for (const auto& [x, y, z] : points) text += fmt::format("v {:.6f} {:.6f} {:.6f}\n", x, y, z);
  for (const auto& [a, b, c] : triangles) {
    text += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
  }
  return text;
}

}  // namespace

const std::vector<SceneTemplate>& scene_templates() {
  static const std::vector<SceneTemplate> templates{
      {"empty", "Empty scene", {{"scene.tessera", kEmpty}}},
      {"lux", "LUX", {{"lux.tessera", kLux}, {"sphere.obj", sphere()}}},
      {"crt", "CRT script", {{"scene.crt", kCrt}}}};
  return templates;
}

}  // namespace tessera
