// How often rays cross closed surfaces, and which points these contain.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/error.h"
#include "tests/unit/query/query_arrays.h"

namespace tessera {
namespace {

using Cell = std::array<int, 3>;

/// The surface of the cells, each one a unit cube from its coordinates up.
MeshText voxels(const std::set<Cell>& cells) {
  MeshText mesh;
  std::map<Cell, uint32_t> numbers;
  const auto vertex = [&](const Cell& c) {
    const auto [at, is_new] = numbers.try_emplace(c, uint32_t(mesh.positions.size()));
    if (is_new) mesh.positions.push_back({float(c[0]), float(c[1]), float(c[2])});
    return at->second;
  };
  for (const Cell& cell : cells) {
    for (size_t axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        Cell beside = cell;
        beside[axis] += side == 0 ? -1 : 1;
        if (cells.contains(beside)) continue;
        const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        Cell corner = cell;
        corner[axis] += side;
        Cell b = corner, c = corner, d = corner;
        ++b[u], ++c[u], ++c[v], ++d[v];
        if (side == 1)
          mesh.add_quad(vertex(corner), vertex(b), vertex(c), vertex(d));
        else
          mesh.add_quad(vertex(corner), vertex(d), vertex(c), vertex(b));
      }
    }
  }
  return mesh;
}

/// A cube of 20 x 20 x 20 cells about (10, 10, 10), without its inner cells' faces.
std::set<Cell> full_cube(int side) {
  std::set<Cell> cells;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z) cells.insert({x, y, z});
  return cells;
}

/// Vertices and middles of edges.
std::vector<Vec3> hard_targets(const MeshText& mesh) {
  std::vector<Vec3> out;
  const auto position = [&](uint32_t i) {
    const auto& p = mesh.positions[i];
    return Vec3{p[0], p[1], p[2]};
  };
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) out.push_back(position(i));
  for (const auto& t : mesh.triangles)
    for (size_t k = 0; k < 3; ++k) out.push_back((position(t[k]) + position(t[(k + 1) % 3])) * 0.5);
  return out;
}

TEST(Crossings, EveryRayFromInsideLeavesOnce) {
  const MeshText mesh = voxels(full_cube(20));
  for (const std::string accelerator : {"bvh", "octree"}) {
    const RayQueries queries = queries_of(mesh.scene(), accelerator);
    OwnedRays out, through;
    const Vec3 center{10, 10, 10};
    for (const Vec3& target : hard_targets(mesh)) {
      out.add(center, target - center);
      // From far outside through the centre, so both ways through hard places.
      through.add(target * 3 - center * 2, center - target);
      // Along the surface and its edges.
      through.add(target - Vec3{40, 0, 0}, {1, 0, 0});
      through.add(target - Vec3{0, 40, 40}, {0, 1, 1});
    }
    EXPECT_GT(out.count(), 10'000u);
    EXPECT_EQ(crossings(queries, out.batch()), std::vector<int32_t>(out.count(), -1));
    EXPECT_EQ(crossings(queries, through.batch()), std::vector<int32_t>(through.count(), 0));
    for (const double t : closest(queries, out.batch()).t) ASSERT_LT(t, 2);
  }
}

TEST(Crossings, VoxelModelsContainTheirCells) {
  std::mt19937_64 random(5);
  std::set<Cell> cells;
  const int side = 8;
  for (const Cell& cell : full_cube(side))
    if (random() % 3 != 0) cells.insert(cell);
  const RayQueries queries = queries_of(voxels(cells).scene());
  std::vector<double> centers, corners;
  std::vector<uint8_t> expected;
  for (int x = -1; x <= side; ++x) {
    for (int y = -1; y <= side; ++y) {
      for (int z = -1; z <= side; ++z) {
        centers.insert(centers.end(), {x + 0.5, y + 0.5, z + 0.5});
        expected.push_back(cells.contains({x, y, z}));
        corners.insert(corners.end(), {double(x), double(y), double(z)});
      }
    }
  }
  EXPECT_EQ(contained(queries, centers), expected);
  // A whole place is known where all eight cells about it are alike.
  const std::vector<uint8_t> found = contained(queries, corners);
  EXPECT_EQ(found, contained(queries, corners));
  int known = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    int full = 0;
    for (int k = 0; k < 8; ++k)
      full += cells.contains({int(corners[3 * i]) - (k & 1), int(corners[3 * i + 1]) - (k >> 1 & 1),
                              int(corners[3 * i + 2]) - (k >> 2)});
    if (full % 8 != 0) continue;
    ++known;
    EXPECT_EQ(found[i], full == 8) << i;
  }
  EXPECT_GT(known, 100);
}

TEST(Crossings, TurnedMeshesStayClosed) {
  v1::Scene scene = voxels(full_cube(6)).scene();
  v1::Node& node = *scene.mutable_nodes(0);
  v1::AxisAngle& turn = *node.mutable_transform()->add_steps()->mutable_rotate();
  turn.mutable_axis()->set_x(1), turn.mutable_axis()->set_y(2), turn.set_angle(33);
  for (const bool flip : {false, true}) {
    node.mutable_shape()->set_flip_normals(flip);
    const RayQueries queries = queries_of(scene);
    const Transform& place = queries.scene().instances[0].world_from_object;
    OwnedRays out;
    const Vec3 center = place.point({3, 3, 3}) - Point3{};
    for (const Vec3& target : hard_targets(voxels(full_cube(6))))
      out.add(center, place.point(Point3{} + target) - Point3{} - center);
    EXPECT_EQ(crossings(queries, out.batch()), std::vector<int32_t>(out.count(), flip ? 1 : -1));
  }
}

TEST(Crossings, SolidsContainWhatTheirFormulaSays) {
  const RayQueries queries = queries_of(
      "nodes { shape { sphere { center { x: 3 } radius: 1 } } } "
      "nodes { shape { torus { major_radius: 1 minor_radius: .25 } } } "
      "nodes { shape { plane { normal { y: 1 } offset: -2 } } } "
      "nodes { shape { disc { radius: 1 center { z: 9 } normal { z: 1 } } } }");
  std::mt19937_64 random(6);
  std::vector<double> points;
  std::vector<uint8_t> sphere, torus, any;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 p = random_vector(random, 4);
    points.insert(points.end(), {p.x, p.y, p.z});
    sphere.push_back(length_squared(p - Vec3{3, 0, 0}) < 1);
    const double ring = std::hypot(p.x, p.z) - 1;
    torus.push_back(ring * ring + p.y * p.y < 0.0625);
    any.push_back(sphere.back() || torus.back() || p.y < -2);
  }
  EXPECT_EQ(contained(queries, points, 0), sphere);
  EXPECT_EQ(contained(queries, points, 1), torus);
  EXPECT_EQ(contained(queries, points), any);
  EXPECT_THROW(contained(queries, points, 3), Error);
  EXPECT_THROW(contained(queries, points, 4), Error);
}

TEST(Crossings, OpenSurfacesCountBySide) {
  const RayQueries queries = queries_of("nodes { shape { disc { radius: 1 normal { z: 1 } } } }");
  OwnedRays rays;
  rays.add({0, 0, 1}, {0, 0, -1});
  rays.add({0, 0, -1}, {0, 0, 1});
  rays.add({2, 0, -1}, {0, 0, 1});
  EXPECT_EQ(crossings(queries, rays.batch()), (std::vector<int32_t>{1, -1, 0}));
}

}  // namespace
}  // namespace tessera
