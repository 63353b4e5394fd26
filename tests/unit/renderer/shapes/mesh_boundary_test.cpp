#include "renderer/shapes/mesh_boundary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "renderer/shapes/triangle.h"

namespace tessera {
namespace {

/// A sphere of radius 1 about the origin of `rings` by 2 `rings` quadrilaterals in halves.
TriangleMesh ball(uint32_t rings) {
  TriangleMesh mesh;
  const uint32_t around = 2 * rings;
  for (uint32_t i = 0; i <= rings; ++i) {
    for (uint32_t k = 0; k < around; ++k) {
      const double polar = std::numbers::pi * i / rings, turn = 2 * std::numbers::pi * k / around;
      const double r = i == 0 || i == rings ? 0 : std::sin(polar);
      mesh.positions.push_back({static_cast<float>(r * std::cos(turn)),
                                static_cast<float>(r * std::sin(turn)),
                                static_cast<float>(std::cos(polar))});
    }
  }
  for (uint32_t i = 0; i < rings; ++i) {
    for (uint32_t k = 0; k < around; ++k) {
      const uint32_t a = i * around + k, b = i * around + (k + 1) % around;
      if (i > 0) mesh.triangles.push_back({a, a + around, b});
      if (i + 1 < rings) mesh.triangles.push_back({b, a + around, b + around});
    }
  }
  return mesh;
}

/// The sum of the solid angles of all triangles.
double sum_over_triangles(const TriangleMesh& mesh, const Point3& p) {
  double sum = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto corners = mesh.corners(i);
    const Vec3 a = corners[0] - p, b = corners[1] - p, c = corners[2] - p;
    const double la = length(a), lb = length(b), lc = length(c);
    sum += 2 * std::atan2(dot(a, cross(b, c)),
                          la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

/// Held against goes_around().
double winding_number(const TriangleMesh& mesh, const MeshBoundary& boundary, const Point3& p,
                      const Vec3& direction = {0, 0, 1}) {
  // All triangles count as hit ahead that the line meets there.
  const Ray ray{p, direction};
  std::vector<Hit> hits;
  const TriangleRay frame(ray);
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    TriangleHit at;
    if (intersect_triangle(frame, a, b, c, at)) hits.push_back({at.t, at.u, at.v, 0, i});
  }
  const int crossings = mesh_crossing_number(mesh, ray, hits);
  const double number = boundary.winding_number(ray, crossings);
  EXPECT_EQ(boundary.goes_around(ray, crossings), std::abs(number) > .5) << number;
  return number;
}

TEST(MeshBoundary, OpenEdgesAreThoseThatLackANeighbour) {
  TriangleMesh mesh = ball(8);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_TRUE(open_edges(mesh).empty());
  const TriangleIndices gone = mesh.triangles.back();
  mesh.triangles.pop_back();
  EXPECT_FALSE(is_closed(mesh));
  // The others pass the edges of the one that is gone the other way.
  std::set<std::pair<uint32_t, uint32_t>> expected, found;
  for (size_t k = 0; k < 3; ++k) expected.emplace(gone[(k + 1) % 3], gone[k]);
  for (const OpenEdge& edge : open_edges(mesh)) found.emplace(edge.from, edge.to);
  EXPECT_EQ(found.size(), 3u);
  for (const auto& other : found)
    EXPECT_TRUE(std::ranges::any_of(expected, [&](const auto& edge) {
      return mesh.vertex(edge.first) == mesh.vertex(other.first) &&
             mesh.vertex(edge.second) == mesh.vertex(other.second);
    }));
  mesh.triangles.push_back({gone[0], gone[2], gone[1]});
  EXPECT_EQ(open_edges(mesh).size(), 6u) << "the wrong way round: each lacks two";
  EXPECT_FALSE(is_closed(TriangleMesh{}));
  EXPECT_TRUE(open_edges(TriangleMesh{}).empty());
}

TEST(MeshBoundary, WindingNumbersAreTheSumOverTriangles) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-1.6, 1.6);
  for (const size_t left_out : {0u, 1u, 7u, 60u, 400u}) {
    TriangleMesh mesh = ball(20);
    if (left_out == 400)
      mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 400);
    else
      for (size_t i = 0; i < left_out; ++i) {
        std::swap(mesh.triangles[random() % mesh.triangles.size()], mesh.triangles.back());
        mesh.triangles.pop_back();
      }
    const MeshBoundary boundary(mesh);
    for (int i = 0; i < 1000; ++i) {
      const Point3 p{draw(random), draw(random), draw(random)};
      const double expected = sum_over_triangles(mesh, p);
      ASSERT_NEAR(winding_number(mesh, boundary, p), expected, 0.02) << left_out << " " << i;
      ASSERT_NEAR(winding_number(mesh, boundary, p, {draw(random), draw(random), draw(random)}),
                  expected, 0.02)
          << "the direction makes no difference";
    }
  }
}

TEST(MeshBoundary, RaysThroughHolesAndTheirEdgesTellTheSame) {
  // The triangles about the pole are gone, and rays go right through what is left of it and edges.
  TriangleMesh mesh = ball(8);
  std::erase_if(mesh.triangles, [](const TriangleIndices& t) { return t[0] < 16 || t[2] < 16; });
  const MeshBoundary boundary(mesh);
  EXPECT_EQ(boundary.edges().size(), 16u);
  for (const Float3& vertex : mesh.positions) {
    for (const float depth : {-0.2f, 0.f, 0.3f}) {
      const Point3 p{0.5f * vertex.x, 0.5f * vertex.y, depth}, below{vertex.x, vertex.y, depth};
      for (const Point3& at : {p, below}) {
        if (std::abs(length(at - Point3{}) - 1) < 0.1) continue;
        EXPECT_NEAR(winding_number(mesh, boundary, at), sum_over_triangles(mesh, at), 0.02);
      }
    }
  }
}

TEST(MeshBoundary, MergingVerticesClosesSlits) {
  TriangleMesh mesh = ball(8);
  // Each triangle has its own corners, a little apart.
  TriangleMesh apart;
  std::mt19937 random(3);
  for (const TriangleIndices& t : mesh.triangles) {
    const auto first = static_cast<uint32_t>(apart.positions.size());
    for (const uint32_t v : t) {
      Float3 p = mesh.positions[v];
      p.x += 1e-4f * static_cast<float>(random() % 8);
      apart.positions.push_back(p);
    }
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_FALSE(is_closed(apart));
  merge_vertices(apart, 0.01);
  EXPECT_TRUE(is_closed(apart));
  EXPECT_EQ(apart.triangles.size(), mesh.triangles.size());
}

}  // namespace
}  // namespace tessera
