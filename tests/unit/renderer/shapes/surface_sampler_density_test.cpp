// Where the samplers of surfaces choose their directions, against the densities that they tell
// (N28): chi-square over cells of equal solid angle, a false alarm in 300,000 a case.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "renderer/accel/linear_scan.h"
#include "renderer/accel/mesh_shape.h"
#include "renderer/math/frame.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"
#include "renderer/shapes/surface_sampler.h"
#include "renderer/shapes/triangle_sampler.h"
#include "tests/chi_square.h"
#include "tests/uniform_numbers.h"
#include "tests/unit/renderer/shapes/shining_meshes.h"

namespace tessera {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kNormal{0, -0.6, -0.8};  // of what is lit
constexpr int kCells = 16, kFine = 32, kCount = 60000;

struct Case {
  std::string name;
  std::shared_ptr<const Shape> shape;
  std::shared_ptr<const SurfaceSampler> sampler;
  Transform place;
};

Case placed(const std::string& name, std::shared_ptr<const Shape> shape, const Affine& to_world) {
  const Transform place(to_world);
  return {name, shape, shape->make_sampler(place, false), place};
}

Case mesh(const std::string& name, const TriangleMesh& of, const Affine& to_world) {
  const auto shared = std::make_shared<TriangleMesh>(of);
  const Transform place(to_world);
  return {
      name, std::make_shared<MeshShape>(shared, std::make_unique<MeshLinearScan>(shared)),
      make_triangle_sampler(std::make_shared<TriangleSet>(TriangleSet::of(of, 0)), place, false),
      place};
}
/// An open tent of three triangles of different size, askew.
TriangleMesh tent() {
  TriangleMesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {0.3, 0.2, 1}};
  mesh.triangles = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

std::vector<Case> cases() {
  const Affine turned = translation({0.3, 0.1, -0.2}) * rotation({1, 2, 3}, 0.7);
  const Affine skewed = turned * scaling({-1.5, 1, 0.5});
  return {
      placed("sphere", std::make_shared<Sphere>(Point3{0.2, 0.1, 0}, 0.7), turned),
      placed("disc", std::make_shared<Disc>(Point3{0, 0, 0}, Vec3{0.3, 1, 0.2}, 0.8), skewed),
      placed("ring", std::make_shared<Disc>(Point3{0, 0, 0}, Vec3{0, 0, 1}, 0.8, 0.5), turned),
      placed("rectangle",
             std::make_shared<Rectangle>(Point3{-0.5, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1.2, 0.4}),
             turned),
      placed("parallelogram",
             std::make_shared<Rectangle>(Point3{-0.5, 0, 0}, Vec3{1, 0, 0}, Vec3{0.5, 1.2, 0}),
             skewed),
      placed("polygon",
             std::make_shared<ConvexPolygon>(std::vector<Point3>{
                 {0, 0, 0}, {1, 0, 0}, {1.4, 0.7, 0}, {0.5, 1.2, 0}, {-0.2, 0.6, 0}}),
             skewed),
      placed("box", std::make_shared<Box>(Bounds3{{-0.3, -0.4, -0.5}, {0.3, 0.2, 0.6}}), skewed),
      mesh("tent", tent(), skewed),
      mesh("bumps", bumpy_sheet(8), turned),
      mesh("skewed bumps", bumpy_sheet(8), skewed)};
}

/// Cells of equal solid angle in a cone about all that is seen of a shape.
class Cone {
 public:
  Cone(const Bounds3& bounds, const Point3& from) : frame_(axis(bounds, from)) {
    const double reach = length(bounds.diagonal()) / 2, d = length(bounds.center() - from);
    lowest_ = d > reach ? std::sqrt(1 - reach * reach / (d * d)) : -1;
  }
  Vec3 direction(double row, double column) const {
    const double z = 1 - (1 - lowest_) * row / kCells, phi = 2 * kPi * column / kCells;
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return frame_.from_local({r * std::cos(phi), r * std::sin(phi), z});
  }
  /// kCells * kCells: outside of all.
  size_t cell(const Vec3& direction) const {
    const Vec3 d = frame_.to_local(direction);
    const double row = (1 - d.z) / (1 - lowest_) * kCells;
    if (row > kCells) return kCells * kCells;
    const double turn = std::atan2(d.y, d.x) / (2 * kPi);
    const auto step = [](double x) { return std::clamp(static_cast<int>(x), 0, kCells - 1); };
    return static_cast<size_t>(step(row) * kCells + step((turn < 0 ? turn + 1 : turn) * kCells));
  }
  double solid_angle() const { return 2 * kPi * (1 - lowest_); }

 private:
  static Vec3 axis(const Bounds3& bounds, const Point3& from) {
    const Vec3 way = bounds.center() - from;
    return length(way) > 0 ? normalize(way) : Vec3{0, 0, 1};
  }
  Frame frame_;
  double lowest_;
};

/// Counts that the densities promise for kCount samples, the last of what is not seen, and the
/// variance of these estimates.
struct Expected {
  std::vector<double> counts = std::vector<double>(kCells * kCells + 1), doubt = counts;
};

/// By what a ray somewhere in each of many finer cells meets first.
Expected expected_counts(const Case& c, const Cone& cone, const Point3& from) {
  Expected out;
  TraversalCounters counters;
  const double each = cone.solid_angle() / (kCells * kCells * kFine * kFine) * kCount;
  double total = 0, before = 0, all_doubt = 0;
  UniformNumbers random(1);
  for (int row = 0; row < kCells * kFine; ++row) {
    for (int column = 0; column < kCells * kFine; ++column) {
      const double down = random(), right = random();
      Ray ray;
      ray.origin = c.place.inverse_point(from);
      ray.direction =
          c.place.inverse_vector(cone.direction((row + down) / kFine, (column + right) / kFine));
      Hit hit;
      double count = 0;
      if (c.shape->closest_hit(ray, hit, counters)) {
        const SurfaceInteraction s = to_world(c.shape->surface(ray, hit), c.place, false, 0);
        count = c.sampler->density({from, kNormal}, s.point, static_cast<Vec3>(s.geometric_normal),
                                   hit.primitive) *
                each;
      }
      const auto cell = static_cast<size_t>(row / kFine * kCells + column / kFine);
      out.counts[cell] += count;
      total += count;
      // Neighbours that differ tell how far each may be off.
      if (column % 2 == 1) {
        out.doubt[cell] += (count - before) * (count - before);
        all_doubt += (count - before) * (count - before);
      }
      before = count;
    }
  }
  out.counts.back() = std::max(0.0, kCount - total);  // chosen, but hidden by what is before it
  out.doubt.back() = all_doubt;
  return out;
}

TEST(SurfaceSampler, DirectionsFollowTheDensityThatItTells) {  // N28
  for (const Case& c : cases()) {
    ASSERT_NE(c.sampler, nullptr) << c.name;
    const bool is_solid = c.name == "sphere" || c.name == "box";
    const Point3 close = is_solid ? Point3{0.35, 0.15, -0.15} : Point3{0.7, 0.4, 0.8};
    for (const Point3& from : {close, Point3{0.9, 0.7, 1.4}, Point3{9, 17, 12}}) {
      SCOPED_TRACE(c.name + " from " + std::to_string(from.x));
      const Cone cone(c.sampler->bounds(), from);
      const Expected expected = expected_counts(c, cone, from);
      std::vector<double> found(expected.counts.size());
      UniformNumbers random(28);
      TraversalCounters counters;
      for (int i = 0; i < kCount; ++i) {
        const double x = random(), y = random();
        SurfaceSample sample;
        ASSERT_GT(c.sampler->sample({from, kNormal}, {x, y}, sample), 0);
        // Is it what is seen first? To within the millionth that edges and rounding take.
        const Vec3 way = sample.point - from;
        Ray ray;
        ray.origin = c.place.inverse_point(from);
        ray.direction = c.place.inverse_vector(way);
        ray.t_max = 1 - 1e-6;
        const bool is_hidden = c.shape->any_hit(ray, counters);
        ++found[is_hidden ? found.size() - 1 : cone.cell(normalize(way))];
      }
      EXPECT_LT(chi_square_sigmas(found, expected.counts, expected.doubt), kChiSquareAlarm);
      // A density that is wrong by a factor: N28 asks for a thousandth beside what the rays doubt.
      const double hidden = found.back();
      EXPECT_NEAR(expected.counts.back() / kCount, hidden / kCount,
                  0.001 + 4.5 * std::sqrt(hidden + expected.doubt.back()) / kCount);
    }
  }
}

}  // namespace
}  // namespace tessera
