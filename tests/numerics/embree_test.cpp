// N21: with Embree to find candidates, our own test still decides every hit.
#include "bench/generated_meshes.h"
#include "tests/numerics/accelerators.h"

namespace tessera::numerics {
namespace {

// A module that was built and cannot be loaded is a failure.
#ifdef TESSERA_WITH_EMBREE
constexpr bool kWithEmbree = true;
#else
constexpr bool kWithEmbree = false;
#endif
constexpr char kNoEmbree[] = "there was no Embree when this was built (deploy/packages.txt has it)";

using N21 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N21, kSeeds);

Ray aimed(const TriangleMesh& mesh, Random& random) {
  static const std::vector<Vec3> axes = axis_directions();
  const Point3 origin = Point3{} + random.in_cube(random.below(2) ? 0.25 : 4);
  if (random.below(4) == 0) return {origin, random.direction()};
  const auto c = mesh.corners(random.below(mesh.triangles.size()));
  if (random.below(4) == 0) {
    const Vec3 d = axes[random.below(axes.size())];
    return {c[0] - d * random.uniform(0, 4), d};
  }
  return {origin, c[0] + (c[1] - c[0]) * (0.25 * random.below(5)) - origin};
}

TEST_P(N21, EmbreeGivesTheBitsOfTheBvhAndLeaksNowhere) {
  if (!kWithEmbree) GTEST_SKIP() << kNoEmbree;
  ASSERT_TRUE(has_embree());
  Random random(21, seed());
  const TriangleMesh meshes[] = {icosphere(2), icosphere(5), bumpy_sphere(16, random),
                                 triangle_soup(20000, seed())};
  for (const TriangleMesh& made : meshes) {
    const bool closed = &made != &meshes[3];
    const auto mesh = std::make_shared<const TriangleMesh>(moved(made, 1, {}));
    const auto embree = EmbreeMesh::make(mesh, 1);
    const MeshBvh bvh(*mesh, 1);
    for (int64_t i = 0; i < ray_count(10'000'000 / kShards / 4); ++i) {
      const Ray ray = aimed(*mesh, random);
      Hit expected, hit;
      TraversalCounters counters;
      const bool found = bvh.closest_hit(ray, expected, counters);
      ASSERT_EQ(embree->closest_hit(ray, hit, counters), found) << describe(ray);
      ASSERT_EQ(hit, expected) << describe(ray);
      ASSERT_EQ(embree->any_hit(ray, counters), found) << describe(ray);
      if (closed && max_component(abs(ray.origin - Point3{})) < 0.25) {
        ASSERT_TRUE(found) << describe(ray);
      }
    }
  }
}

/// The smallest weight of the triangle's corners where the ray meets its plane: negative outside.
double least_weight(const Ray& ray, const std::array<Point3, 3>& c) {
  const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0], to = ray.origin - c[0];
  const Vec3 p = cross(ray.direction, e2), q = cross(to, e1);
  const double u = dot(to, p) / dot(e1, p), v = dot(ray.direction, q) / dot(e1, p);
  return std::min({u, v, 1 - u - v});
}

TEST_P(N21, EmbreesOwnTrianglesAreOursAwayFromEdges) {
  Random random(121, seed());
  const auto mesh = std::make_shared<const TriangleMesh>(triangle_soup(20000, seed()));
  const auto embree =
      make_embree_scene({&mesh->positions.data()->x, mesh->positions.size() * 3},
                        {mesh->triangles.data()->data(), mesh->triangles.size() * 3}, 1);
  if (!kWithEmbree) GTEST_SKIP() << kNoEmbree;
  ASSERT_TRUE(embree);
  const MeshBvh bvh(*mesh, 1);
  const int64_t rays = ray_count(10'000'000 / kShards);
  int64_t different = 0, in_band = 0;
  for (int64_t i = 0; i < rays; ++i) {
    Ray ray{Point3{} + random.in_cube(2), random.direction()};
    EmbreeRay single{};
    for (int a = 0; a < 3; ++a) {
      single.origin[a] = static_cast<float>(ray.origin[a]);
      single.direction[a] = static_cast<float>(ray.direction[a]);
      ray.origin[a] = single.origin[a], ray.direction[a] = single.direction[a];
    }
    single.t_max = HUGE_VALF;
    embree->closest_hits({&single, 1});
    Hit hit;
    TraversalCounters counters;
    const bool found = bvh.closest_hit(ray, hit, counters);
    if (single.primitive == (found ? hit.primitive : EmbreeScene::kNothing)) continue;
    // Near an edge of either candidate, or at depths that single precision cannot tell apart.
    bool doubtful = found && std::abs(single.t - hit.t) < 1e-5;
    if (found) doubtful |= std::abs(least_weight(ray, mesh->corners(hit.primitive))) < 1e-4;
    if (single.primitive != EmbreeScene::kNothing)
      doubtful |= std::abs(least_weight(ray, mesh->corners(single.primitive))) < 1e-4;
    (doubtful ? in_band : different)++;
  }
  EXPECT_LE(different, rays / 1'000'000) << "of " << rays << ", seed " << seed();
  EXPECT_LT(in_band, std::max<int64_t>(rays / 1000, 10));
}

}  // namespace
}  // namespace tessera::numerics
