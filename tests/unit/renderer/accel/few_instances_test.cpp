#include "renderer/accel/few_instances.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "renderer/accel/linear_scan.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "tests/uniform_numbers.h"

namespace tessera {
namespace {

/// A room of rectangles, along the axes and turned, with a few other things in it.
class Room {
 public:
  explicit Room(uint32_t seed) : random_(seed) {
    const double size = std::exp2(between(-20, 20));
    for (int i = 0; i < 9; ++i) add_rectangle(size);
    instances_.push_back({std::make_shared<Sphere>(point(size), size * 0.2)});
    const Point3 low = point(size);
    Instance box{std::make_shared<Box>(Bounds3{low, low + Vec3{size, size, size}})};
    box.world_from_object = Transform(rotation({1, 2, 3}, 0.5));
    instances_.push_back(box);
    if (seed % 4 == 0) instances_.push_back({std::make_shared<Plane>(Vec3{0, 1, 0}, -size)});
    size_ = size;
  }
  const std::vector<Instance>& instances() const { return instances_; }

  /// Past rectangles' middles, edges and corners; from anywhere, or off one of them.
  Ray ray() {
    const Rectangle& to = *rectangles_[pick()];
    const double u = share(), v = share();
    const Point3 target = to.corner() + to.edge_u() * u + to.edge_v() * v;
    Point3 origin = point(3 * size_);
    const int kind = static_cast<int>(between(0, 8));
    if (kind < 4) {
      const Rectangle& from = *rectangles_[pick()];
      const Vec3 n = normalize(from.normal());
      const double side = between(0, 1) < 0.5 ? -1 : 1;
      const double off = kind == 0 ? 0 : size_ * std::exp2(between(-54, -20));
      origin = from.corner() + from.edge_u() * share() + from.edge_v() * share() + n * (side * off);
    }
    Ray ray{origin, target - origin};
    if (kind == 5) ray.direction = to.edge_u() + to.normal() * between(-1e-7, 1e-7);
    if (kind == 6) ray.direction = {0, 0, -1};
    if (between(0, 1) < 0.5) ray.t_max = 1 + between(-4, 4) * 0x1p-50;
    if (between(0, 1) < 0.1) ray.cull = between(0, 1) < 0.5 ? Cull::back : Cull::front;
    return ray;
  }

 private:
  double between(double a, double b) { return random_.between(a, b); }
  size_t pick() { return random_.below(rectangles_.size()); }
  Point3 point(double size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  /// Often an edge, or as good as.
  double share() {
    const int kind = static_cast<int>(between(0, 6));
    if (kind == 0) return 0;
    if (kind == 1) return 1;
    if (kind == 2) return between(0, 1) < 0.5 ? between(-2e-7, 2e-7) : 1 + between(-2e-7, 2e-7);
    return between(-0.1, 1.1);
  }
  void add_rectangle(double size) {
    Vec3 u{size, 0, 0}, v{0, between(0.01, 1) * size, 0};
    const int kind = static_cast<int>(between(0, 4));
    if (kind == 0) std::swap(u.x, u.z);
    if (kind == 1) std::swap(v.y, v.z);
    if (kind == 2) u = point(size) - Point3{}, v = point(size) - Point3{};
    const auto rectangle = std::make_shared<const Rectangle>(point(size), u, v);
    Instance instance{rectangle};
    instance.casts_shadow = between(0, 1) < 0.9;
    if (between(0, 1) < 0.2) instance.cull = Cull::back;
    instance.flip_normals = between(0, 1) < 0.2;
    if (between(0, 1) < 0.1) instance.world_from_object = Transform(translation({0, 0, size}));
    instances_.push_back(instance);
    rectangles_.push_back(rectangle);
    // Two in one place: of equal hits the smaller instance counts.
    if (between(0, 1) < 0.1) instances_.push_back(instance);
  }

  UniformNumbers random_;
  double size_ = 1;
  std::vector<Instance> instances_;
  std::vector<std::shared_ptr<const Rectangle>> rectangles_;
};

/// How many of the rays compared hit something, and how many are stopped.
struct Compared {
  uint64_t hits = 0, stopped = 0;
};

/// Expects the same of rows in which the ray is among others.
void expect_row_as_scan(const InstanceLinearScan& scan, const FewInstances& few, const Ray& ray) {
  RayBatch batch;
  batch.begin(ray.t_min, ray.t_max);
  for (int i = 0; i < 9; ++i) {
    const Vec3 way = i % 2 == 0 ? ray.direction : -ray.direction;
    for (int axis = 0; axis < 3; ++axis) {
      batch.origin[axis][batch.count] = ray.origin[axis];
      batch.direction[axis][batch.count] = axis == i % 3 && i > 2 ? way[axis] * 2 : way[axis];
    }
    ++batch.count;
  }
  std::vector<Hit> hits(batch.count);
  TraversalCounters counters;
  few.closest_hits(batch, hits, counters);
  const uint64_t stopped = few.any_hits(batch, counters);
  for (size_t i = 0; i < batch.count; ++i) {
    Hit expected;
    scan.closest_hit(batch.ray(i), expected, counters);
    EXPECT_EQ(hits[i], expected) << i;
    EXPECT_EQ(stopped >> i & 1, scan.any_hit(batch.ray(i), counters)) << i;
  }
}

/// Expects of FewInstances over the same, by each code, what a scan finds.
void expect_as_scan(const InstanceLinearScan& scan, const std::vector<FewInstances>& few,
                    const Ray& ray, TraversalCounters& of_scan, TraversalCounters& counters,
                    Compared& compared) {
  Hit expected;
  const bool found = scan.closest_hit(ray, expected, of_scan);
  const bool occluded = scan.any_hit(ray, of_scan);
  compared.hits += found;
  compared.stopped += occluded;
  for (const FewInstances& one : few) {
    Hit hit, again = expected;
    TraversalCounters of_again;
    EXPECT_EQ(one.closest_hit(ray, hit, counters), found);
    EXPECT_EQ(hit, expected);
    EXPECT_FALSE(one.closest_hit(ray, again, of_again));
    EXPECT_EQ(one.any_hit(ray, counters), occluded);
    if (ray.cull == Cull::none) expect_row_as_scan(scan, one, ray);
  }
}

TEST(FewInstances, HitsAreThoseOfAScan) {
  Compared compared;
  uint64_t tests = 0, scanned = 0;
  for (uint32_t seed = 0; seed < 60; ++seed) {
    Room room(seed);
    const InstanceLinearScan scan(room.instances());
    std::vector<FewInstances> few;
    for (const BvhKernels& code : all_kernels()) few.emplace_back(room.instances(), code);
    for (int i = 0; i < 1000; ++i) {
      SCOPED_TRACE(fmt::format("seed {}, ray {}", seed, i));
      TraversalCounters of_scan, counters;
      expect_as_scan(scan, few, room.ray(), of_scan, counters, compared);
      tests += counters.primitive_tests / few.size();
      scanned += of_scan.primitive_tests;
    }
  }
  EXPECT_GT(compared.hits, 20'000u);
  EXPECT_GT(compared.stopped, 15'000u);
  EXPECT_LT(tests, scanned / 3);
}

/// A room of planes with two balls in it, some planes in one place.
std::vector<Instance> planes_and_balls(UniformNumbers& random, int planes, double size) {
  const auto between = [&](double a, double b) { return random.between(a, b); };
  std::vector<Instance> instances;
  for (int i = 0; i < planes; ++i) {
    Vec3 normal{0, 0, 0};
    normal[i % 3] = between(0, 1) < 0.5 ? -1 : 1;
    if (between(0, 1) < 0.5) normal = {between(-1, 1), between(-1, 1), between(-1, 1)};
    Instance plane{std::make_shared<Plane>(normal, between(-size, size))};
    plane.casts_shadow = between(0, 1) < 0.7;
    if (between(0, 1) < 0.6) plane.cull = between(0, 1) < 0.5 ? Cull::back : Cull::front;
    plane.flip_normals = between(0, 1) < 0.3;
    if (between(0, 1) < 0.1) plane.world_from_object = Transform(translation({0, 0, size}));
    instances.push_back(plane);
    if (between(0, 1) < 0.3) instances.push_back(plane);
    if (i < 2) instances.push_back({std::make_shared<Sphere>(Point3{}, size * (0.2 + 0.1 * i))});
  }
  return instances;
}

TEST(FewInstances, PlanesAtOnceAreHitAsOneByOne) {
  Compared compared;
  uint64_t touching = 0;
  for (uint32_t seed = 0; seed < 60; ++seed) {
    UniformNumbers random(seed);
    const auto between = [&](double a, double b) { return random.between(a, b); };
    const double size = std::exp2(between(-20, 20));
    // More than fit into a PlaneSoA, too.
    const auto instances = planes_and_balls(random, 4 + static_cast<int>(seed % 20), size);
    const InstanceLinearScan scan(instances);
    std::vector<FewInstances> few;
    for (const BvhKernels& code : all_kernels()) few.emplace_back(instances, code);
    for (int i = 0; i < 500; ++i) {
      const auto place = [&] {
        return Point3{between(-size, size), between(-size, size), between(-size, size)};
      };
      Ray ray{place(), place() - place()};
      if (i % 8 == 1) ray.direction[i / 8 % 3] = 0;
      TraversalCounters counters;
      Hit before;
      // From where another ray ended, or up to there.
      if (i % 4 == 2 && scan.closest_hit(ray, before, counters)) {
        ray.origin = ray.at(before.t);
        ++touching;
      }
      if (i % 4 == 3 && scan.closest_hit(ray, before, counters)) ray.t_max = before.t;
      if (i % 16 == 5) ray.cull = i % 32 == 5 ? Cull::back : Cull::front;
      if (i % 16 == 6) ray.t_min = between(0, 2);
      SCOPED_TRACE(fmt::format("seed {}, ray {}", seed, i));
      expect_as_scan(scan, few, ray, counters, counters, compared);
    }
  }
  EXPECT_GT(compared.hits, 15'000u);
  EXPECT_GT(compared.stopped, 10'000u);
  EXPECT_GT(touching, 3'000u);
}

TEST(FewInstances, UnusualRaysHitWhatAScanFinds) {
  Room room(1);
  const InstanceLinearScan scan(room.instances());
  const FewInstances few(room.instances());
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  for (const double odd : {inf, -inf, nan, 0.0, 1e-310, 1e300, -1e120}) {
    for (int part = 0; part < 6; ++part) {
      Ray ray = room.ray();
      (part < 3 ? ray.origin[part] : ray.direction[part - 3]) = odd;
      TraversalCounters counters;
      Hit hit, expected;
      EXPECT_EQ(few.closest_hit(ray, hit, counters), scan.closest_hit(ray, expected, counters));
      EXPECT_EQ(hit, expected) << odd << " " << part;
      EXPECT_EQ(few.any_hit(ray, counters), scan.any_hit(ray, counters)) << odd << " " << part;
      ray.cull = Cull::none;
      expect_row_as_scan(scan, few, ray);
    }
  }
}

}  // namespace
}  // namespace tessera
