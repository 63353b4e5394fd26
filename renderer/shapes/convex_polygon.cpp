#include "renderer/shapes/convex_polygon.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/plural.h"
#include "renderer/shapes/planar.h"
#include "renderer/shapes/projected_edge.h"
#include "renderer/shapes/triangle_sampler.h"

namespace tessera {
namespace {

/// Twice the vector area, by a fan about the first point.
Vec3 area_vector(std::span<const Point3> points) {
  Vec3 sum;
  for (size_t i = 2; i < points.size(); ++i)
    sum = sum + accurate_cross(points[i - 1] - points[0], points[i] - points[0]);
  return sum;
}

Bounds3 box_of(std::span<const Point3> points) {
  Bounds3 box;
  for (const Point3& p : points) box.extend(p);
  return box;
}

/// Whether edges seen by the ray are all on one side of it.
struct EdgeSides {
  bool left = false, right = false;
  void add(double edge) {
    left |= edge > 0;
    right |= edge < 0;
  }
  bool inside() const { return left != right; }
};

}  // namespace

std::string ConvexPolygon::fault_of(std::span<const Point3> points) {
  if (points.size() < 3) return fmt::format("a polygon of {}", counted(points.size(), "point"));
  for (const Point3& p : points)
    if (!is_finite(p - Point3{})) return "a point of a polygon that is not finite";
  const Vec3 normal = area_vector(points);
  if (!is_finite(normal) || normal == Vec3{}) return "a polygon without an area";
  const Vec3 n = normalize(normal);
  const double extent = length(box_of(points).diagonal());
  double turned = 0, distance = 0;
  bool turns_back = false;
  for (size_t i = 0; i < points.size(); ++i) {
    const Point3& a = points[i];
    const Vec3 in = points[(i + 1) % points.size()] - a;
    const Vec3 out = points[(i + 2) % points.size()] - points[(i + 1) % points.size()];
    distance = std::max(distance, std::abs(dot(n, a - points[0])));
    // Once round, and not twice as a pentagram: every triangle of the fan turns the same way.
    const double fan = dot(n, accurate_cross(a - points[0], in));
    turns_back |= dot(n, accurate_cross(in, out)) < -1e-12 * (length(in) * length(out)) ||
                  fan < -1e-12 * (extent * extent);
    turned += fan;
  }
  if (distance > 1e-6 * extent)
    return fmt::format("a point of a polygon that is {:.3g} m off its plane", distance);
  return turns_back || !(turned > 0) ? "a polygon that is not convex" : "";
}

ConvexPolygon::ConvexPolygon(std::vector<Point3> points) : points_(std::move(points)) {
  if (const std::string fault = fault_of(points_); !fault.empty())
    throw scene_error(fault + "; expected 3 or more finite points round a flat convex area");
  normal_ = area_vector(points_);
  const Vec3 n = normalize(normal_);
  size_t second = 1;
  while (points_[second] == points_[0]) ++second;
  const Vec3 along = normalize(points_[second] - points_[0]);
  const Vec3 up = cross(n, along);
  double low = 0, high = 0, left = 0, right = 0;
  for (const Point3& p : points_) {
    left = std::min(left, dot(p - points_[0], along));
    right = std::max(right, dot(p - points_[0], along));
    low = std::min(low, dot(p - points_[0], up));
    high = std::max(high, dot(p - points_[0], up));
  }
  uv_origin_ = points_[0] + along * left + up * low;
  const double side = std::max(right - left, high - low);
  dpdu_ = along * side;
  dpdv_ = up * side;
  bounds_ = box_of(points_);
  // Hits lie on one plane, the points only nearly so.
  double off_plane = 0;
  for (const Point3& p : points_)
    off_plane = std::max(off_plane, std::abs(accurate_dot(n, p - points_[0])));
  for (int a = 0; a < 3; ++a) {
    const double slack =
        off_plane + gamma(8) * std::max(std::abs(bounds_.min[a]), std::abs(bounds_.max[a]));
    bounds_.min[a] = next_down(bounds_.min[a] - slack);
    bounds_.max[a] = next_up(bounds_.max[a] + slack);
  }
}

bool ConvexPolygon::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  const TriangleRay frame(ray);
  if (!frame.valid()) return false;
  EdgeSides sides;
  const ProjectedVertex first = project(frame, points_[0]);
  ProjectedVertex from = first;
  for (size_t i = 1; i < points_.size(); ++i) {
    const ProjectedVertex to = project(frame, points_[i]);
    sides.add(edge_function(from, to));
    from = to;
  }
  sides.add(edge_function(from, first));
  PlaneCrossing at;
  if (!sides.inside() || !cross_plane(points_[0], normal_, ray, hit, at)) return false;
  hit = {at.t, 0, 0, hit.instance, 0};
  return true;
}

LocalSurface ConvexPolygon::surface(const Ray& ray, const Hit& hit) const {
  LocalSurface s;
  project_to_plane(points_[0], normal_, ray.at(hit.t), s);
  const Vec3 from_origin = s.point - uv_origin_;
  s.uv = {dot(from_origin, dpdu_) / dot(dpdu_, dpdu_), dot(from_origin, dpdv_) / dot(dpdv_, dpdv_)};
  s.dpdu = dpdu_;
  s.dpdv = dpdv_;
  return s;
}

std::unique_ptr<const SurfaceSampler> ConvexPolygon::make_sampler(
    const Transform& world_from_object, bool flip_normals) const {
  const auto triangles = std::make_shared<TriangleSet>();
  for (size_t i = 2; i < points_.size(); ++i)
    triangles->add({points_[0], points_[i - 1], points_[i]});
  return make_triangle_sampler(triangles, world_from_object, flip_normals);
}

Rectangle::Rectangle(const Point3& corner, const Vec3& edge_u, const Vec3& edge_v)
    : corner_(corner), edge_u_(edge_u), edge_v_(edge_v), normal_(accurate_cross(edge_u, edge_v)) {
  if (!is_finite(corner - Point3{}) || !is_finite(normal_) || normal_ == Vec3{})
    throw scene_error("a rectangle's edges are parallel or not finite; expected two directions");
  unit_normal_ = normalize(normal_);
  const double area = dot(normal_, unit_normal_);
  share_u_ = cross(edge_v_, unit_normal_) / area;
  share_v_ = cross(unit_normal_, edge_u_) / area;
  for (int a = 0; a < 3; ++a)
    if (normal_[(a + 1) % 3] == 0 && normal_[(a + 2) % 3] == 0) axis_ = a;
}

Bounds3 Rectangle::bounds() const {
  const Point3 corners[4] = {corner_, corner_ + edge_u_, corner_ + edge_v_,
                             corner_ + edge_u_ + edge_v_};
  Bounds3 box = box_of(corners);
  for (int a = 0; a < 3; ++a) {
    const double slack = gamma(8) * std::max(std::abs(box.min[a]), std::abs(box.max[a]));
    box.min[a] = next_down(box.min[a] - slack);
    box.max[a] = next_up(box.max[a] + slack);
  }
  return box;
}

/// cross_plane() of its plane. Along an axis the accurate products are plain ones.
bool Rectangle::crosses(const Ray& ray, const Hit& hit, double& t) const {
  PlaneCrossing at;
  if (axis_ < 0) {
    if (!cross_plane(corner_, normal_, ray, hit, at)) return false;
  } else {
    const double height = normal_[axis_] * (ray.origin[axis_] - corner_[axis_]);
    if (!cross_plane_at(height, normal_[axis_] * ray.direction[axis_], std::abs(height), ray, hit,
                        at))
      return false;
  }
  t = at.t;
  return true;
}

Hit Rectangle::hit_at(const Ray& ray, double t, const Hit& hit) const {
  const Vec3 from_corner = ray.at(t) - corner_;
  const auto share = [&](const Vec3& by) {
    return std::min(std::max(0.0, dot(from_corner, by)), 1.0);
  };
  return {t, share(share_u_), share(share_v_), hit.instance, 0};
}

bool Rectangle::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  // First what is cheap: most that are asked lie beyond a hit, or behind.
  double t;
  if (!crosses(ray, hit, t)) return false;
  const TriangleRay frame(ray);
  if (!frame.valid()) return false;
  const ProjectedVertex p00 = project(frame, corner_);
  const ProjectedVertex p10 = project(frame, corner_ + edge_u_);
  const ProjectedVertex p11 = project(frame, corner_ + edge_u_ + edge_v_);
  const ProjectedVertex p01 = project(frame, corner_ + edge_v_);
  EdgeSides sides;
  sides.add(edge_function(p00, p10));
  sides.add(edge_function(p10, p11));
  sides.add(edge_function(p11, p01));
  sides.add(edge_function(p01, p00));
  if (!sides.inside()) return false;
  hit = hit_at(ray, t, hit);
  return true;
}

bool Rectangle::closest_hit_inside(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  double t;
  if (!crosses(ray, hit, t)) return false;
  hit = hit_at(ray, t, hit);
  return true;
}

bool Rectangle::any_hit_inside(const Ray& ray, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  double t;
  return crosses(ray, Hit{}, t);
}

LocalSurface Rectangle::surface(const Ray&, const Hit& hit) const {
  LocalSurface s;
  Vec3 point;
  place_on_rectangle(to_vec(corner_), edge_u_ * hit.u, edge_v_ * hit.v, point, s.point_error);
  s.point = to_point(point);
  s.geometric_normal = s.shading_normal = to_normal(unit_normal_);
  s.uv = {hit.u, hit.v};
  s.dpdu = edge_u_;
  s.dpdv = edge_v_;
  return s;
}

}  // namespace tessera
