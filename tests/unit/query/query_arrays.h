#pragma once

#include <fmt/format.h>

#include <array>
#include <random>
#include <string>
#include <vector>

#include "query/ray_queries.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {

/// Rays that own their numbers.
struct OwnedRays {
  std::vector<double> origins, directions;

  void add(const Vec3& o, const Vec3& d) {
    origins.insert(origins.end(), {o.x, o.y, o.z});
    directions.insert(directions.end(), {d.x, d.y, d.z});
  }
  size_t count() const { return origins.size() / 3; }
  RayArrays batch() const { return {count(), {origins.data()}, {directions.data()}}; }
};

/// Hits that own their arrays.
struct OwnedHits {
  std::vector<double> t, uv;
  std::vector<uint32_t> instance, primitive;

  explicit OwnedHits(size_t n) : t(n), uv(2 * n), instance(n), primitive(n) {}
  HitArrays arrays() { return {t.data(), instance.data(), primitive.data(), uv.data()}; }
  ConstHitArrays found() const { return {t.data(), instance.data(), primitive.data(), uv.data()}; }
  friend bool operator==(const OwnedHits&, const OwnedHits&) = default;
};

inline OwnedHits closest(const RayQueries& queries, const RayArrays& rays, int threads = 1) {
  OwnedHits hits(rays.count);
  EXPECT_TRUE(queries.closest_hits(rays, hits.arrays(), {.threads = threads}));
  return hits;
}
inline std::vector<int32_t> crossings(const RayQueries& queries, const RayArrays& rays) {
  std::vector<int32_t> numbers(rays.count);
  EXPECT_TRUE(queries.crossings(rays, numbers.data()));
  return numbers;
}
inline std::vector<uint8_t> contained(const RayQueries& queries, const std::vector<double>& points,
                                      std::optional<uint32_t> instance = {},
                                      RayQueries::OpenInside open = {}) {
  std::vector<uint8_t> inside(points.size() / 3);
  std::optional<std::vector<uint32_t>> among;
  if (instance) among = {*instance};
  EXPECT_TRUE(queries.contains(inside.size(), {points.data()}, among, open, inside.data()));
  return inside;
}

inline RayQueries queries_of(const v1::Scene& scene, const std::string& accelerator = "bvh") {
  v1::FrameSettings frame = frame_of(8, 6);
  frame.set_accelerator(accelerator);
  return {scene, {}, frame, 1};
}
inline RayQueries queries_of(const std::string& text, const std::string& accelerator = "bvh") {
  return queries_of(parse_scene(text), accelerator);
}

/// A mesh as a description has it.
struct MeshText {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<uint32_t, 3>> triangles;

  void add_quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }
  v1::Scene scene() const {
    v1::Scene out;
    v1::TriangleMesh& mesh = *out.add_nodes()->mutable_shape()->mutable_mesh();
    for (const auto& p : positions)
      for (const float x : p) mesh.add_inline_positions(x);
    for (const auto& t : triangles)
      for (const uint32_t i : t) mesh.add_inline_triangles(i);
    return out;
  }
};

inline Vec3 random_vector(std::mt19937_64& random, double size = 1) {
  std::uniform_real_distribution<> unit(-size, size);
  const double x = unit(random), y = unit(random), z = unit(random);
  return {x, y, z};
}

}  // namespace tessera
