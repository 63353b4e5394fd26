#include "scenes/generate/octree_scenes.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "scenes/generate/random.h"

namespace tessera {
namespace {

using portable::kPi;

/// 9 x 9 x 9 places less the middle one, where the light is: each of the first three splits of a
/// uniform octree runs through a plane of diamonds.
OctreeScene uniform_diamonds() {
  constexpr double kSpacing = 100, kRadius = 25;
  OctreeScene scene;
  for (int x = -4; x <= 4; ++x)
    for (int y = -4; y <= 4; ++y)
      for (int z = -4; z <= 4; ++z)
        if (x != 0 || y != 0 || z != 0)
          scene.diamonds.push_back({{x * kSpacing, y * kSpacing, z * kSpacing}, kRadius});
  return scene;
}

OctreeScene random_diamonds() {
  Random random(1);
  OctreeScene scene;
  for (int i = 0; i < 1000; ++i) scene.diamonds.push_back({Point3{} + random.in_cube() * 500, 25});
  return scene;
}

/// 1,197 on each shell, along a spiral of even density.
OctreeScene concentric_spheres() {
  constexpr int kOnEach = 1197;
  const double golden = kPi * (3 - std::sqrt(5.0));
  OctreeScene scene;
  for (int shell = 1; shell <= 5; ++shell) {
    for (int i = 0; i < kOnEach; ++i) {
      const double y = 1 - (2 * i + 1) / double{kOnEach}, ring = std::sqrt(1 - y * y);
      const double turn = golden * i + shell;
      const Vec3 out{ring * portable::cos(turn), y, ring * portable::sin(turn)};
      scene.spheres.push_back({Point3{} + out * (100.0 * shell), 8});
    }
  }
  return scene;
}

/// One clump somewhere inside each cell of a grid of 4 x 4 x 4.
OctreeScene clumped_diamonds() {
  constexpr double kCell = 250, kClump = 60, kRadius = 10;
  Random random(2);
  OctreeScene scene;
  for (int cell = 0; cell < 64; ++cell) {
    const int x = cell % 4, y = cell / 4 % 4, z = cell / 16;
    const Vec3 corner = Vec3{x - 1.5, y - 1.5, z - 1.5} * kCell;
    const Point3 middle = Point3{} + corner + random.in_cube() * (kCell / 2 - kClump);
    for (int i = 0; i < 50; ++i)
      scene.diamonds.push_back({middle + random.in_cube() * (kClump - kRadius), kRadius});
  }
  return scene;
}

OctreeScene teapot() {
  OctreeScene scene;
  scene.mesh = pot_mesh();
  return scene;
}

/// Adds rows of points as a surface; each row closes on itself. Points run counter-clockwise seen
/// against the direction in which the rows advance.
void add_rows(const std::vector<std::vector<Point3>>& rows, MeshData& mesh) {
  for (size_t r = 0; r + 1 < rows.size(); ++r) {
    const auto base = static_cast<uint32_t>(mesh.vertex_count());
    const auto n = static_cast<uint32_t>(rows[r].size());
    for (const auto* row : {&rows[r], &rows[r + 1]}) {
      for (const Point3& p : *row) {
        for (int a = 0; a < 3; ++a) mesh.positions.push_back(static_cast<float>(p[a]));
      }
    }
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t j = (i + 1) % n;
      const std::array<uint32_t, 6> quad{base + i,     base + j, base + n + i,
                                         base + n + i, base + j, base + n + j};
      mesh.triangles.insert(mesh.triangles.end(), quad.begin(), quad.end());
    }
  }
}

struct Profile {
  double radius, height;
};

/// Turns a profile about the y axis; `steps` rows between neighbouring points, on a smooth curve.
void revolve(const std::vector<Profile>& points, int steps, int segments, MeshData& mesh) {
  std::vector<std::vector<Point3>> rows;
  const auto at = [&points](long i) {
    return points[static_cast<size_t>(
        std::max(0L, std::min(i, static_cast<long>(points.size()) - 1)))];
  };
  // Catmull and Rom's interpolating spline.
  const auto spline = [](double a, double b, double c, double d, double t) {
    return b + t * ((c - a) / 2 +
                    t * (a - 2.5 * b + 2 * c - d / 2 + t * ((d - a) / 2 + (b - c) * 1.5)));
  };
  for (long k = 0; k + 1 < static_cast<long>(points.size()); ++k) {
    for (int s = k == 0 ? 0 : 1; s <= steps; ++s) {
      const double t = double(s) / steps;
      const Profile a = at(k - 1), b = at(k), c = at(k + 1), d = at(k + 2);
      const double radius = std::max(0.0, spline(a.radius, b.radius, c.radius, d.radius, t));
      const double height = spline(a.height, b.height, c.height, d.height, t);
      auto& row = rows.emplace_back();
      for (int i = 0; i < segments; ++i) {
        const double turn = -2 * kPi * i / segments;
        row.push_back({radius * portable::cos(turn), height, radius * portable::sin(turn)});
      }
    }
  }
  add_rows(rows, mesh);
}

/// A tube in the plane z = 0 along `curve`, which gives centre (x, y) and radius for t in [0, 1].
template <typename Curve>
void sweep(const Curve& curve, int rows_count, int segments, MeshData& mesh) {
  std::vector<std::vector<Point3>> rows;
  for (int r = 0; r <= rows_count; ++r) {
    const double t = double(r) / rows_count, h = 1e-3;
    const std::array<double, 3> here = curve(t), before = curve(t - h), after = curve(t + h);
    const Vec3 along = normalize(Vec3{after[0] - before[0], after[1] - before[1], 0});
    const Vec3 side{-along.y, along.x, 0};
    auto& row = rows.emplace_back();
    for (int i = 0; i < segments; ++i) {
      const double turn = 2 * kPi * i / segments;
      const Vec3 out = side * portable::cos(turn) + Vec3{0, 0, 1} * portable::sin(turn);
      row.push_back(Point3{here[0], here[1], 0} + out * here[2]);
    }
  }
  add_rows(rows, mesh);
}

}  // namespace

MeshData pot_mesh() {
  MeshData mesh;
  revolve({{0, 0}, {.6, .01}, {.75, .08}, {.95, .4}, {1, .75}, {.9, 1.1}, {.72, 1.35}, {.68, 1.4}},
          8, 128, mesh);
  revolve({{.7, 1.36}, {.55, 1.47}, {.2, 1.55}, {.09, 1.62}, {.16, 1.74}, {.1, 1.83}, {0, 1.85}}, 4,
          72, mesh);
  sweep(
      [](double t) -> std::array<double, 3> {
        const double turn = kPi * (t * 1.2 - .1);
        return {-.85 - .62 * portable::sin(turn), .8 + .42 * portable::cos(turn), .08};
      },
      64, 24, mesh);
  sweep(
      [](double t) -> std::array<double, 3> {
        return {.8 + .85 * t, .45 + .95 * t * t * (3 - 2 * t), .26 - .17 * t};
      },
      64, 32, mesh);
  return mesh;
}

void look_at_box(const Bounds3& box, OctreeScene& scene) {
  scene.target = box.center();
  const double radius = length(box.diagonal()) / 2;
  // Near enough for a cube to reach the picture's upper and lower edge.
  const double reach = 0.6 * radius / portable::sin(portable::radians(scene.field_of_view / 2));
  scene.eye = scene.target + normalize(Vec3{.45, .35, 1}) * reach;
}

const std::vector<std::string>& octree_scene_names() {
  static const std::vector<std::string> names{"uniform-diamonds", "random-diamonds",
                                              "concentric-spheres", "clumped-diamonds", "teapot"};
  return names;
}

OctreeScene make_octree_scene(std::string_view name) {
  using Maker = OctreeScene (*)();
  constexpr std::array<Maker, 5> kMakers{uniform_diamonds, random_diamonds, concentric_spheres,
                                         clumped_diamonds, teapot};
  const auto& names = octree_scene_names();
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] != name) continue;
    OctreeScene scene = kMakers[i]();
    scene.name = name;
    Bounds3 box;
    for (const auto* placed : {&scene.spheres, &scene.diamonds}) {
      for (const auto& [center, radius] : *placed) {
        box.extend(center - Vec3{radius, radius, radius});
        box.extend(center + Vec3{radius, radius, radius});
      }
    }
    const auto& p = scene.mesh.positions;
    for (size_t v = 0; v < p.size(); v += 3) box.extend(Point3{p[v], p[v + 1], p[v + 2]});
    look_at_box(box, scene);
    if (scene.mesh.triangles.empty()) scene.point_light = box.center();
    return scene;
  }
  throw usage_error(fmt::format("'{}' is no scene of the octree study; expected one of {}{}", name,
                                fmt::join(names, ", "), suggestion(name, names)));
}

}  // namespace tessera
