#include "bench/precision.h"

#include <algorithm>
#include <functional>
#include <random>

#include "bench/generated_meshes.h"
#include "bench/plain_tests.h"
#include "bench/thread_seconds.h"
#include "bench/wide_number.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/mesh_shape.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"
#include "renderer/shapes/torus.h"

namespace tessera {
namespace {

constexpr double kMinor = 0.25;    ///< of the torus
constexpr double kEpsilon = 1e-4;  ///< the customary offset of rays that leave a surface

class Source {
 public:
  explicit Source(uint64_t seed) : random_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
  }
  size_t below(size_t n) { return random_() % n; }
  Vec3 in_cube() {
    const double x = uniform(-1, 1), y = uniform(-1, 1);
    return {x, y, uniform(-1, 1)};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_cube();
      if (const double l = length(v); l > 0.01 && l < 1) return v / l;
    }
  }

 private:
  std::mt19937_64 random_;
};

/// Exact in single precision, so that every method is given the same.
Ray to_single(Ray ray) {
  for (int a = 0; a < 3; ++a) {
    ray.origin[a] = static_cast<float>(ray.origin[a]);
    ray.direction[a] = static_cast<float>(ray.direction[a]);
  }
  return ray;
}

/// A way to test one shape. `test` gives t, or 0; `leave` a ray that leaves the surface there.
struct Method {
  std::string name;
  std::function<void(const std::vector<Ray>&, std::vector<double>&)> test;
  std::function<Ray(const Ray&, double t, const Vec3& normal, const Vec3& direction)> leave;
};

/// Runs `one` for each ray, without a call through a pointer in the loop.
template <typename One>
auto each(One one) {
  return [one](const std::vector<Ray>& rays, std::vector<double>& t) {
    for (size_t i = 0; i < rays.size(); ++i) t[i] = one(rays[i]);
  };
}

template <typename Real>
Ray leave_by_epsilon(const Ray& ray, double t, const Vec3& normal, const Vec3& direction) {
  const plain::Vec<Real> o(ray.origin), d(ray.direction), n(normal);
  const plain::Vec<Real> p = o + d * static_cast<Real>(t);
  const plain::Vec<Real> q =
      p + n * static_cast<Real>(dot(normal, direction) < 0 ? -kEpsilon : kEpsilon);
  return {{double(q.x), double(q.y), double(q.z)}, direction};
}

template <typename One>
Method plain_method(const char* name, bool single, One one) {
  return {name, each(one), single ? leave_by_epsilon<float> : leave_by_epsilon<double>};
}

double first_hit(const Shape& shape, const Ray& ray) {
  Hit hit;
  TraversalCounters counters;
  return shape.closest_hit(ray, hit, counters) ? hit.t : 0;
}

Ray leave_surface(const Shape& shape, const Ray& ray, const Vec3& direction) {
  Hit hit;
  TraversalCounters counters;
  shape.closest_hit(ray, hit, counters);
  return spawn_ray(to_world(shape.surface(ray, hit), Transform{}, false, 0), direction);
}

Method robust_method(const Shape& shape) {
  return {"robust", each([&shape](const Ray& ray) { return first_hit(shape, ray); }),
          [&shape](const Ray& ray, double, const Vec3&, const Vec3& direction) {
            return leave_surface(shape, ray, direction);
          }};
}

/// A shape with rays at it, the truth about them, and ways to test it.
struct Experiment {
  Experiment(std::string shape_name, double at) : shape(std::move(shape_name)), distance(at) {}

  std::string shape;
  double distance = 0;
  std::vector<Ray> rays;
  std::vector<double> truth;  ///< t, or 0
  std::function<Vec3(const Ray&, double t)> normal;
  bool convex = true;  ///< a ray that leaves outward never comes back
  std::vector<Method> methods;
};

std::vector<Ray> rays_at(Source& source, double distance, int count,
                         const std::function<Point3()>& target) {
  std::vector<Ray> rays;
  while (std::ssize(rays) < count) {
    const Point3 to = target(), from = Point3{} + source.direction() * distance;
    rays.push_back(to_single({from, normalize(to - from)}));
  }
  return rays;
}

Wide wide_triangle(const std::array<Point3, 3>& c, const Ray& ray) {
  const WideVec a(c[0]), e1 = WideVec(c[1]) - a, e2 = WideVec(c[2]) - a, d(ray.direction);
  const WideVec p = cross(d, e2), to = WideVec(ray.origin) - a, q = cross(to, e1);
  const Wide det = dot(e1, p), u = dot(to, p) / det, v = dot(d, q) / det;
  if (double(u) < 0 || double(v) < 0 || double(u + v) > 1) return 0;
  return dot(e2, q) / det;
}

Wide wide_sphere(const Ray& ray) {
  const WideVec o(ray.origin), d(ray.direction);
  const Wide a = dot(d, d), b = dot(o, d), c = dot(o, o) - Wide(1);
  const Wide discriminant = b * b - a * c;
  if (double(discriminant) < 0) return 0;
  return (-b - sqrt(discriminant)) / a;
}

/// The first of many samples inside, then bisection. Steps are small against all but grazing rays.
Wide wide_torus(const Ray& ray) {
  const WideVec o(ray.origin), d(ray.direction);
  const Wide middle = -(dot(o, d) / dot(d, d));
  const auto distance = [&](const Wide& x) {
    const WideVec p = o + d * (middle + x);
    const Wide ring = sqrt(p.x * p.x + p.z * p.z) - Wide(1);
    return double(sqrt(ring * ring + p.y * p.y) - Wide(kMinor));
  };
  constexpr int kSteps = 2000;
  const double reach = 1.5 / length(ray.direction);
  double outside = -reach;
  for (int i = 1; i <= kSteps; ++i) {
    const double x = -reach + 2 * reach * i / kSteps;
    if (distance(x) >= 0) {
      outside = x;
      continue;
    }
    Wide low = outside, high = x;
    for (int k = 0; k < 90; ++k) {
      const Wide half = (low + high) * Wide(0.5);
      (distance(half) >= 0 ? low : high) = half;
    }
    return middle + low;
  }
  return 0;
}

PrecisionBenchRow measure(const Experiment& e, const Method& method,
                          const PrecisionBenchOptions& options) {
  PrecisionBenchRow row{e.shape, method.name, e.distance};
  std::vector<double> t(e.rays.size());
  const auto count = static_cast<double>(e.rays.size());
  row.nanoseconds = 1e300;
  for (int round = 0; round < options.rounds; ++round) {
    const double start = thread_seconds();
    method.test(e.rays, t);
    row.nanoseconds = std::min(row.nanoseconds, 1e9 * (thread_seconds() - start) / count);
  }
  Source source(options.seed + 1);
  double squares = 0, both = 0, wrong = 0, left = 0, again = 0;
  std::vector<Ray> leaving;
  for (size_t i = 0; i < t.size(); ++i) {
    if ((t[i] > 0) != (e.truth[i] > 0)) ++wrong;
    if (t[i] <= 0 || e.truth[i] <= 0) continue;
    const double error = std::abs(t[i] - e.truth[i]) * length(e.rays[i].direction);
    squares += error * error, ++both;
    row.max_error = std::max(row.max_error, error);
    if (!e.convex) continue;
    Vec3 n = e.normal(e.rays[i], e.truth[i]);
    if (dot(n, e.rays[i].direction) > 0) n = -n;
    Vec3 out = source.direction();
    if (dot(out, n) < 0) out = -out;
    leaving.push_back(method.leave(e.rays[i], t[i], n, out));
  }
  std::vector<double> hit(leaving.size());
  method.test(leaving, hit);
  left = static_cast<double>(leaving.size());
  for (const double x : hit) again += x > 0;
  row.rms_error = both > 0 ? std::sqrt(squares / both) : 0;
  row.wrong = 1e6 * wrong / count;
  row.self_hits = left > 0 ? 1e6 * again / left : 0;
  return row;
}

/// Rays from inside a closed mesh, far from the world's origin, at its vertices and edges: how many
/// of a million find no triangle.
template <typename Test>
double leaks(const PrecisionBenchOptions& options, double offset, const Test& test) {
  TriangleMesh mesh = icosphere(1);
  const Vec3 by = Vec3{1.48376, 0.01234, -2.23423} * offset;
  for (Float3& p : mesh.positions)
    p = {static_cast<float>(p.x + by.x), static_cast<float>(p.y + by.y),
         static_cast<float>(p.z + by.z)};
  drop_degenerate(mesh);
  Source source(options.seed + 2);
  double missed = 0;
  const int count = std::max(1, options.rays / 4);
  for (int i = 0; i < count; ++i) {
    const Point3 origin = Point3{} + by + source.in_cube() * 0.25;
    const auto c = mesh.corners(source.below(mesh.triangles.size()));
    const double share = 0.25 * static_cast<double>(source.below(5));
    Ray ray = to_single({origin, {}});
    ray.direction = c[0] + (c[1] - c[0]) * share - ray.origin;
    ray = to_single(ray);
    bool found = false;
    for (size_t k = 0; k < mesh.triangles.size() && !found; ++k)
      found = test(mesh.corners(k), ray) > 0;
    missed += !found;
  }
  return 1e6 * missed / count;
}

double robust_triangle(const std::array<Point3, 3>& c, const Ray& ray) {
  TriangleHit hit;
  return intersect_triangle(TriangleRay(ray), c[0], c[1], c[2], hit) ? hit.t : 0;
}

void bench_triangle(const PrecisionBenchOptions& options, double distance,
                    std::vector<PrecisionBenchRow>& rows) {
  Source source(options.seed);
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->positions = {{-0.9f, -0.7f, 0.2f}, {0.8f, -0.3f, -0.4f}, {0.1f, 0.9f, 0.3f}};
  mesh->triangles = {{0, 1, 2}};
  const MeshShape shape(mesh, std::make_unique<MeshLinearScan>(mesh));
  const std::array<Point3, 3> c = mesh->corners(0);
  Experiment e("triangle", distance);
  e.rays = rays_at(source, distance, options.rays, [&] {
    return c[0] + (c[1] - c[0]) * source.uniform(-0.2, 1.2) +
           (c[2] - c[0]) * source.uniform(-0.2, 1.2);
  });
  for (const Ray& ray : e.rays) e.truth.push_back(double(wide_triangle(c, ray)));
  e.normal = [n = normalize(cross(c[1] - c[0], c[2] - c[0]))](const Ray&, double) { return n; };
  const auto add = [&](const char* name, bool single, auto test) {
    e.methods.push_back(
        plain_method(name, single, [c, test](const Ray& ray) { return test(c, ray); }));
    rows.push_back(measure(e, e.methods.back(), options));
    rows.back().leaks = leaks(options, distance, test);
  };
  using namespace plain;
  add("float-moller-trumbore", true, moller_trumbore<float>);
  add("float-woop", true, woop<float>);
  add("double-moller-trumbore", false, moller_trumbore<double>);
  add("double-woop", false, woop<double>);
  Method robust = robust_method(shape);
  robust.test = each([c](const Ray& ray) { return robust_triangle(c, ray); });
  rows.push_back(measure(e, robust, options));
  rows.back().leaks = leaks(options, distance, robust_triangle);
}

void bench_sphere(const PrecisionBenchOptions& options, double distance,
                  std::vector<PrecisionBenchRow>& rows) {
  Source source(options.seed);
  const Sphere sphere({0, 0, 0}, 1);
  Experiment e("sphere", distance);
  e.rays = rays_at(source, distance, options.rays,
                   [&] { return Point3{} + source.direction() * source.uniform(0, 1.2); });
  for (const Ray& ray : e.rays) e.truth.push_back(double(wide_sphere(ray)));
  e.normal = [](const Ray& ray, double t) { return normalize(ray.at(t) - Point3{}); };
  e.methods = {plain_method("float-textbook", true, plain::textbook_sphere<float>),
               plain_method("float-gems", true, plain::gems_sphere<float>),
               plain_method("double-textbook", false, plain::textbook_sphere<double>),
               plain_method("double-gems", false, plain::gems_sphere<double>),
               robust_method(sphere)};
  for (const Method& method : e.methods) rows.push_back(measure(e, method, options));
}

void bench_torus(const PrecisionBenchOptions& options, double distance,
                 std::vector<PrecisionBenchRow>& rows) {
  Source source(options.seed);
  const Torus torus(1, kMinor);
  Experiment e("torus", distance);
  e.convex = false;
  // The oracle is slow.
  e.rays = rays_at(source, distance, std::max(1, options.rays / 50),
                   [&] { return Point3{} + source.direction() * source.uniform(0, 1.3); });
  for (const Ray& ray : e.rays) e.truth.push_back(double(wide_torus(ray)));
  e.methods = {plain_method("double-quartic", false,
                            [](const Ray& r) { return plain::quartic_torus(kMinor, r, false); }),
               plain_method("double-quartic-moved", false,
                            [](const Ray& r) { return plain::quartic_torus(kMinor, r, true); }),
               robust_method(torus)};
  for (const Method& method : e.methods) rows.push_back(measure(e, method, options));
}

}  // namespace

std::vector<PrecisionBenchRow> bench_precision(const PrecisionBenchOptions& options) {
  std::vector<PrecisionBenchRow> rows;
  for (const double distance : {2.0, 1e2, 1e4, 1e6}) bench_triangle(options, distance, rows);
  for (const double distance : {2.0, 1e2, 1e4, 1e6}) bench_sphere(options, distance, rows);
  for (const double distance : {2.0, 1e2, 1e4}) bench_torus(options, distance, rows);
  return rows;
}

}  // namespace tessera
