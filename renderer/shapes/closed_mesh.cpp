#include "renderer/shapes/closed_mesh.h"

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "renderer/shapes/line_box.h"
#include "renderer/shapes/projected_edge.h"

namespace tessera {
namespace {

/// Six times the enclosed volume, positive where triangles wind counter-clockwise from outside.
double signed_volume(const TriangleMesh& mesh, const Point3& center) {
  double sum = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    sum += dot(a - center, cross(b - center, c - center));
  }
  return sum;
}

ShearedTriangle sheared(const ProjectedVertex& a, const ProjectedVertex& b,
                        const ProjectedVertex& c) {
  return {a.x,
          a.y,
          a.z,
          b.x,
          b.y,
          b.z,
          c.x,
          c.y,
          c.z,
          edge_function(b, c),
          edge_function(c, a),
          edge_function(a, b)};
}

/// Where the line crosses the triangle that it is known to cross.
SolidEvent crossing_of(const TriangleRay& ray, const ShearedTriangle& s) {
  const double near = std::min(s.az, std::min(s.bz, s.cz));
  const double far = std::max(s.az, std::max(s.bz, s.cz));
  const double rounding = gamma(6) * std::max(std::abs(near), std::abs(far));
  const double det = s.u + s.v + s.w;
  SolidEvent e{0.5 * (near + far), 0.5 * (far - near) + rounding};
  if (det == 0) return e;  // seen edge-on
  const double inverse = 1 / det;
  const double t = (s.u * s.az + s.v * s.bz + s.w * s.cz) * inverse;
  const double error = t_error(ray, s, inverse);
  e.u = s.v * inverse;
  e.v = s.w * inverse;
  if (!std::isfinite(t)) return e;
  e.t = std::min(std::max(t, near), far);
  // Whatever the error, the crossing is between the triangle's vertices.
  e.error = std::min(error, far - near + rounding);
  return e;
}

}  // namespace

ClosedMesh::ClosedMesh(std::shared_ptr<const TriangleMesh> mesh)
    : mesh_(std::move(mesh)), bounds_(mesh_->bounds()) {
  if (!is_closed(*mesh_))
    throw scene_error(
        "a mesh in a CSG operation is not closed; expected each edge between two triangles that "
        "wind the same way");
  const double volume = signed_volume(*mesh_, bounds_.center());
  if (!(volume != 0) || !std::isfinite(volume))
    throw scene_error("a mesh in a CSG operation encloses no volume; expected a solid");
  inside_out_ = volume < 0;
  order_.resize(mesh_->triangles.size());
  std::iota(order_.begin(), order_.end(), 0u);
  build(0, static_cast<uint32_t>(order_.size()));
}

void ClosedMesh::build(uint32_t first, uint32_t last) {
  const auto self = static_cast<uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Bounds3 box, centers;
  for (uint32_t i = first; i < last; ++i) {
    Bounds3 one;
    for (const Point3& p : mesh_->corners(order_[i])) one.extend(p);
    box.extend(one);
    centers.extend(one.center());
  }
  nodes_[self].bounds = box;
  nodes_[self].first = first;
  constexpr uint32_t kLeafSize = 4;
  if (last - first <= kLeafSize) {
    nodes_[self].count = last - first;
  } else {
    const Vec3 d = centers.diagonal();
    const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
    const auto place = [&](uint32_t triangle) {
      const auto c = mesh_->corners(triangle);
      return std::min(c[0][axis], std::min(c[1][axis], c[2][axis])) +
             std::max(c[0][axis], std::max(c[1][axis], c[2][axis]));
    };
    // By the median: the depth is the logarithm of the count, whatever the triangles.
    const uint32_t middle = first + (last - first) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                     [&](uint32_t a, uint32_t b) {
                       const double pa = place(a), pb = place(b);
                       return pa != pb ? pa < pb : a < b;
                     });
    build(first, middle);
    build(middle, last);
  }
  nodes_[self].end = static_cast<uint32_t>(nodes_.size());
}

template <typename Visit>
void ClosedMesh::visit_near(const Ray& ray, const Visit& visit) const {
  const LineInverse inverse(ray.direction);
  for (uint32_t i = 0; i < nodes_.size();) {
    const Node& node = nodes_[i];
    if (line_range(node.bounds, ray, inverse).empty()) {
      i = node.end;
      continue;
    }
    for (uint32_t k = 0; k < node.count; ++k) visit(order_[node.first + k]);
    ++i;
  }
}

bool ClosedMesh::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  const TriangleRay frame(ray);
  if (!frame.valid()) return false;
  bool found = false;
  visit_near(ray, [&](uint32_t triangle) {
    ++counters.primitive_tests;
    const auto [a, b, c] = mesh_->corners(triangle);
    TriangleHit at;
    if (!intersect_triangle(frame, a, b, c, at)) return;
    if (at.t > hit.t || (at.t == hit.t && triangle >= hit.primitive)) return;
    hit = {at.t, at.u, at.v, hit.instance, triangle};
    found = true;
  });
  return found;
}

LocalSurface ClosedMesh::surface(const Ray&, const Hit& hit) const {
  LocalSurface s = triangle_surface(*mesh_, hit.primitive, hit.u, hit.v);
  if (inside_out_) s.geometric_normal = -s.geometric_normal, s.shading_normal = -s.shading_normal;
  return s;
}

void ClosedMesh::crossings(const Ray& ray, const RayError& error,
                           std::vector<SolidEvent>& events) const {
  const TriangleRay frame(ray);
  if (!frame.valid()) return;
  const size_t begin = events.size();
  visit_near(ray, [&](uint32_t triangle) {
    const auto [a, b, c] = mesh_->corners(triangle);
    const ProjectedVertex pa = project(frame, a), pb = project(frame, b), pc = project(frame, c);
    const int side = edge_side(pa, pb);
    if (side == 0 || edge_side(pb, pc) != side || edge_side(pc, pa) != side) return;
    SolidEvent e = crossing_of(frame, sheared(pa, pb, pc));
    const Vec3 n = cross(b - a, c - a);
    const double lean = std::abs(dot(n, ray.direction));
    if (lean > 0) e.error += crossing_depth(n, e.t, error, 0) / lean;
    e.entering = (side > 0) != inside_out_;
    e.primitive = triangle;
    events.push_back(e);
  });
  // Coordinates out of range may leave a t that is not a number, which has its place too.
  std::sort(events.begin() + static_cast<std::ptrdiff_t>(begin), events.end(),
            [](const SolidEvent& x, const SolidEvent& y) {
              const std::weak_ordering order = std::weak_order(x.t, y.t);
              return order != 0 ? order < 0 : x.primitive < y.primitive;
            });
}

}  // namespace tessera
