#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "renderer/shapes/box.h"
#include "renderer/shapes/csg_shape.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/sphere.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {

/// A solid with its quad-precision twin. Coordinates are small multiples of 1/2, so that faces of
/// several solids coincide often and exactly.
struct OracleSolid {
  enum Kind { box, ball, cylinder } kind = box;
  Bounds3 extent;  ///< box
  Point3 center;   ///< ball, and cylinder along y
  double radius = 1, height = 2;
  Affine extra;  ///< not known to the oracle

  std::shared_ptr<const Shape> shape() const {
    if (kind == box) return std::make_shared<Box>(extent);
    if (kind == ball) return std::make_shared<Sphere>(center, radius);
    return std::make_shared<Cylinder>(radius, height);
  }
  Transform place() const {
    if (kind != cylinder) return Transform(extra);
    return Transform(translation(center - Point3{}));
  }
  bool inside(const QuadVec& p) const {
    if (kind == box)
      return p.x > extent.min.x && p.x < extent.max.x && p.y > extent.min.y && p.y < extent.max.y &&
             p.z > extent.min.z && p.z < extent.max.z;
    const QuadVec f = p - QuadVec(center);
    if (kind == ball) return dot(f, f) < Quad(radius) * radius;
    return fabsq(f.y) < height / 2 && f.x * f.x + f.z * f.z < Quad(radius) * radius;
  }
  void roots(const Ray& ray, std::vector<Quad>& t) const {
    const QuadVec o(ray.origin), d(ray.direction);
    const auto slab = [&](Quad from, Quad along, Quad side) {
      if (along != 0) t.push_back((side - from) / along);
    };
    if (kind == box) {
      slab(o.x, d.x, extent.min.x), slab(o.x, d.x, extent.max.x);
      slab(o.y, d.y, extent.min.y), slab(o.y, d.y, extent.max.y);
      slab(o.z, d.z, extent.min.z), slab(o.z, d.z, extent.max.z);
      return;
    }
    QuadVec f = o - QuadVec(center), e = d;
    if (kind == cylinder) {
      slab(f.y, d.y, -Quad(height) / 2), slab(f.y, d.y, Quad(height) / 2);
      f.y = e.y = 0;
    }
    const Quad a = dot(e, e), b = dot(e, f), c = dot(f, f) - Quad(radius) * radius;
    const Quad disc = b * b - a * c;
    if (a == 0 || disc <= 0) return;
    t.push_back((-b - sqrtq(disc)) / a);
    t.push_back((-b + sqrtq(disc)) / a);
  }
};

/// An expression over solids, with operands by number.
struct Expression {
  bool leaf = true;
  CsgOperation operation = CsgOperation::join;
  OracleSolid solid;
  std::vector<Expression> operands;

  bool inside(const QuadVec& p) const {
    if (leaf) return solid.inside(p);
    bool value = operands[0].inside(p);
    for (size_t i = 1; i < operands.size(); ++i) {
      const bool other = operands[i].inside(p);
      if (operation == CsgOperation::join) value = value || other;
      if (operation == CsgOperation::intersect) value = value && other;
      if (operation == CsgOperation::subtract) value = value && !other;
    }
    return value;
  }
  void roots(const Ray& ray, std::vector<Quad>& t) const {
    if (leaf) solid.roots(ray, t);
    for (const Expression& e : operands) e.roots(ray, t);
  }
  CsgTree::Node add_to(CsgTree& tree, const Transform& world = {}) const {
    if (leaf) return tree.add(solid.shape(), Transform(world.matrix() * solid.place().matrix()));
    std::vector<CsgTree::Node> nodes;
    for (const Expression& e : operands) nodes.push_back(e.add_to(tree, world));
    return tree.combine(operation, nodes);
  }
  CsgShape shape(const Transform& world = {}) const {
    CsgTree tree;
    const CsgTree::Node root = add_to(tree, world);
    return CsgShape(tree, root);
  }
};

/// Where the line truly changes sides, and how near two different places come to each other.
struct Truth {
  std::vector<Quad> changes;
  bool starts_inside = false;  ///< just after t = 0
  bool doubtful = false;       ///< two places nearer than `gap`, or a tangent
};

inline Truth truth_of(const Expression& e, const Ray& ray, double gap) {
  Truth truth;
  std::vector<Quad> t{-1000, 1000};
  e.roots(ray, t);
  std::sort(t.begin(), t.end());
  std::vector<Quad> places{t[0]};
  for (const Quad x : t) {
    const Quad step = x - places.back();
    if (step < 1e-25) continue;
    if (step < gap) truth.doubtful = true;
    places.push_back(x);
  }
  bool inside = false;
  for (size_t i = 0; i + 1 < places.size(); ++i) {
    const Quad middle = (places[i] + places[i + 1]) / 2;
    const bool now = e.inside(QuadVec(ray.origin) + QuadVec(ray.direction) * middle);
    if (now != inside && places[i] > 0) truth.changes.push_back(places[i]);
    if (places[i] <= 0) truth.starts_inside = now;
    inside = now;
  }
  return truth;
}

inline double half_steps(Random& random, int low, int high) {
  return 0.5 * (low + random.below(high - low + 1));
}

inline OracleSolid random_solid(Random& random, bool boxes_only) {
  OracleSolid s;
  s.kind = boxes_only ? OracleSolid::box : OracleSolid::Kind(random.below(3));
  s.center = {half_steps(random, -2, 2), half_steps(random, -2, 2), half_steps(random, -2, 2)};
  s.radius = half_steps(random, 1, 3);
  s.height = half_steps(random, 1, 3) * 2;
  for (int a = 0; a < 3; ++a) {
    s.extent.min[a] = half_steps(random, -3, 1);
    s.extent.max[a] = s.extent.min[a] + half_steps(random, 1, 4);
  }
  return s;
}

inline Expression random_expression(Random& random, int depth, bool boxes_only) {
  Expression e;
  if (depth == 0) {
    e.solid = random_solid(random, boxes_only);
    return e;
  }
  e.leaf = false;
  e.operation = CsgOperation(random.below(3));
  const int n = 2 + random.below(2);
  for (int i = 0; i < n; ++i)
    e.operands.push_back(random_expression(
        random, i == 0 ? depth - 1 : random.below(std::min(depth, 3)), boxes_only));
  return e;
}

inline Ray random_ray(Random& random, bool from_inside) {
  const double far = from_inside ? 1.5 : 6;
  const Point3 from = Point3{} + random.direction() * (far * random.uniform(0.2, 1));
  const Point3 to{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
  return {from, to - from};
}

}  // namespace tessera::numerics
