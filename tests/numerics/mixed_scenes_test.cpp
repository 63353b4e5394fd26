// N20: in scenes of every shape, all accelerators give the bits of the linear scan.
#include <functional>

#include "bench/generated_meshes.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/closed_mesh.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/csg_shape.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/half_plane.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/torus.h"
#include "tests/numerics/accelerators.h"

namespace tessera::numerics {
namespace {

Transform random_placement(Random& random) {
  Affine a;
  do {
    for (auto& row : a.m)
      for (double& entry : row) entry = random.uniform(-1, 1);
  } while (std::abs(a.determinant()) < 0.02);
  for (auto& row : a.m) row[3] *= 6;
  return Transform(a);
}

std::shared_ptr<const Shape> carved() {
  CsgTree tree;
  const auto box = tree.add(std::make_shared<Box>(Bounds3{{-1, -1, -1}, {1, 1, 1}}));
  const auto drill = tree.add(std::make_shared<Cylinder>(0.5, 2));
  const auto ball =
      tree.add(std::make_shared<ClosedMesh>(std::make_shared<const TriangleMesh>(icosphere(1))),
               Transform(translation({1, 1, 0}) * scaling({0.5, 0.5, 0.5})));
  return std::make_shared<CsgShape>(
      tree, tree.combine(CsgOperation::subtract, std::vector{box, drill, ball}));
}

TriangleMesh with_attributes(TriangleMesh mesh) {
  mesh.normals = mesh.positions;
  for (const Float3& p : mesh.positions) mesh.uvs.push_back({p.x, p.z});
  return mesh;
}

/// One of every shape; those of triangles find their hits by `kind`.
std::vector<std::shared_ptr<const Shape>> all_shapes(AcceleratorKind kind, uint32_t seed) {
  const auto mesh_shape = [kind](TriangleMesh mesh) {
    return make_mesh_shape(std::make_shared<const TriangleMesh>(std::move(mesh)), kind, 1);
  };
  return {mesh_shape(with_attributes(icosphere(1))), mesh_shape(triangle_soup(60, seed)),
          std::make_shared<Sphere>(Point3{0.3, 0, 0}, 1),
          std::make_shared<Box>(Bounds3{{-1, -1, -1}, {1, 1, 1}}),
          std::make_shared<Cylinder>(0.5, 2), std::make_shared<Cone>(1, 2),
          std::make_shared<Torus>(1, 0.5), std::make_shared<Disc>(Point3{}, Vec3{0, 1, 0}, 1, 0.25),
          std::make_shared<Rectangle>(Point3{-1, 0, -1}, Vec3{2, 0, 0}, Vec3{0, 0, 2}),
          std::make_shared<ConvexPolygon>(
              std::vector<Point3>{{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1.5, 0, 0}}),
          carved(),
          // Endless ones are rare: at the end.
          std::make_shared<HalfPlane>(Point3{0, -5, 0}, Vec3{0, 1, 0}, Vec3{1, 0, 0}),
          std::make_shared<Plane>(Vec3{0, 1, 0}, -8)};
}

std::vector<Instance> random_scene(Random random, AcceleratorKind kind) {
  const auto shapes = all_shapes(kind, random.next());
  std::vector<Instance> scene(size_t(1 + random.below(40)));
  for (Instance& added : scene) {
    added.shape = random.below(20) == 0 ? shapes[shapes.size() - 1 - size_t(random.below(2))]
                                        : shapes[random.below(shapes.size() - 2)];
    // Whole-numbered places make many exact ties.
    if (random.below(2)) {
      added.world_from_object = Transform(translation(
          {random.below(5) * 2.0 - 4, random.below(5) * 2.0 - 4, random.below(5) * 2.0 - 4}));
    } else {
      added.world_from_object = random_placement(random);
    }
    added.casts_shadow = random.below(8) != 0;
    added.cull = random.below(6) == 0   ? Cull::back
                 : random.below(6) == 0 ? Cull::front
                                        : Cull::none;
    added.flip_normals = random.below(8) == 0;
  }
  return scene;
}

Ray random_ray(Random& random) {
  static const std::vector<Vec3> axes = axis_directions();
  Ray ray{Point3{} + random.in_cube(8), random.direction()};
  if (random.below(3) == 0) {
    ray.origin = {random.below(17) * 1.0 - 8, random.below(17) * 1.0 - 8,
                  random.below(17) * 1.0 - 8};
    ray.direction = axes[random.below(axes.size())];
  }
  if (random.below(4) == 0) ray.cull = random.below(2) ? Cull::back : Cull::front;
  if (random.below(4) == 0) ray.t_max = random.uniform(0, 10);
  if (random.below(4) == 0) ray.t_min = random.uniform(0, 5);
  return ray;
}

/// A scene with an accelerator over it, and over each of its meshes.
struct Contestant {
  std::vector<Instance> instances;
  std::unique_ptr<const Accelerator> accelerator;
};

/// The linear scan first.
std::vector<Contestant> contestants(const Random& random) {
  std::vector<AcceleratorKind> kinds{AcceleratorKind::linear, AcceleratorKind::bvh,
                                     AcceleratorKind::octree, AcceleratorKind::nonuniform_octree};
  if (has_embree()) kinds.push_back(AcceleratorKind::embree);
  std::vector<Contestant> all;
  for (const AcceleratorKind kind : kinds) {
    std::vector<Instance> scene = random_scene(random, kind);
    auto accelerator = make_instance_accelerator(scene, kind, 1);
    all.push_back({std::move(scene), std::move(accelerator)});
  }
  for (auto& over_instances : Accelerators::over(all[1].instances).all)
    all.push_back({all[1].instances, std::move(over_instances)});
  return all;
}

bool same_surface(const SurfaceInteraction& a, const SurfaceInteraction& b) {
  return a.point == b.point && a.point_error == b.point_error &&
         a.geometric_normal == b.geometric_normal && a.shading_normal == b.shading_normal &&
         a.uv == b.uv && a.dpdu == b.dpdu && a.dpdv == b.dpdv && a.material == b.material;
}

bool same_answers(const Contestant& a, const Contestant& b, const Ray& ray) {
  TraversalCounters counters;
  Hit at_a, at_b;
  const bool found = a.accelerator->closest_hit(ray, at_a, counters);
  if (b.accelerator->closest_hit(ray, at_b, counters) != found || !(at_a == at_b)) return false;
  if (a.accelerator->any_hit(ray, counters) != b.accelerator->any_hit(ray, counters)) return false;
  return !found ||
         same_surface(surface_at(a.instances, ray, at_a), surface_at(b.instances, ray, at_b));
}

/// Leaves nothing but the hit itself in reach of a ray, from before it or up to it.
void cut_to_hit(const Contestant& oracle, bool from, Ray& ray) {
  TraversalCounters counters;
  Hit hit;
  if (!oracle.accelerator->closest_hit(ray, hit, counters)) return;
  if (from)
    ray.t_min = next_down(hit.t);
  else
    ray.t_max = next_up(hit.t);
}

using N20 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N20, kSeeds);

TEST_P(N20, AcceleratorsAgreeToTheLastBitOnMixedScenes) {
  constexpr int kScenes = 200 / kShards;
  for (int number = 0; number < kScenes; ++number) {
    Random random(20 + 1000 * static_cast<uint64_t>(number), seed());
    const std::vector<Contestant> all = contestants(random);
    int wrong = 0;
    std::string first;
    for (int64_t i = 0; i < long_ray_count(10'000'000 / kShards / kScenes); ++i) {
      Ray ray = random_ray(random);
      if (i % 4 == 0) cut_to_hit(all[0], i % 8 == 0, ray);
      for (size_t k = 1; k < all.size(); ++k)
        if (!same_answers(all[0], all[k], ray) && wrong++ == 0) first = describe(ray);
    }
    EXPECT_EQ(wrong, 0) << "seed " << seed() << " scene " << number << ": " << first;
  }
}

}  // namespace
}  // namespace tessera::numerics
