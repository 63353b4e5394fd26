#include "scenes/formats/crt/crt_parts.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "renderer/math/bounds.h"

namespace tessera {
namespace {

/// Pairs are compared: more operands stay together.
constexpr size_t kMostOperands = 1000;

Vec3 vector_of(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// Of a sphere, a box, or what is carved of one, where it stands unmoved.
std::optional<Bounds3> box_of(const CrtEntity& entity) {
  const CrtEntity* solid = &entity;
  while (solid->kind == CrtEntity::Kind::set_operation && solid->modifiers.steps_size() == 0 &&
         solid->operation != v1::Csg::UNION) {
    solid = solid->left;
  }
  if (solid->kind != CrtEntity::Kind::shape || solid->modifiers.steps_size() > 0)
    return std::nullopt;
  Bounds3 box;
  if (solid->shape.has_sphere()) {
    const Vec3 center = vector_of(solid->shape.sphere().center());
    const double radius = solid->shape.sphere().radius();
    box.extend(Point3{} + (center - Vec3{radius, radius, radius}));
    box.extend(Point3{} + (center + Vec3{radius, radius, radius}));
  } else if (solid->shape.has_box()) {
    box.extend(Point3{} + vector_of(solid->shape.box().min()));
    box.extend(Point3{} + vector_of(solid->shape.box().max()));
  } else {
    return std::nullopt;
  }
  return box;
}

bool keep_clear(const Bounds3& a, const Bounds3& b) {
  constexpr double kClearly = 1e-9;  // far above the rounding of a hit
  for (int axis = 0; axis < 3; ++axis) {
    const double gap = std::max(a.min[axis] - b.max[axis], b.min[axis] - a.max[axis]);
    const double reach = std::max({std::abs(a.min[axis]), std::abs(a.max[axis]),
                                   std::abs(b.min[axis]), std::abs(b.max[axis])});
    if (gap > kClearly * reach) return true;
  }
  return false;
}

}  // namespace

CrtParts parts_apart(const std::vector<const CrtEntity*>& operands) {
  std::vector<Bounds3> boxes;
  for (const CrtEntity* operand : operands) {
    const auto box = box_of(*operand);
    if (!box || boxes.size() >= kMostOperands) return {operands};
    boxes.push_back(*box);
  }
  std::vector<size_t> part(operands.size());  // the number of its first operand
  std::iota(part.begin(), part.end(), size_t{0});
  for (size_t i = 1; i < operands.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (part[i] == part[j] || keep_clear(boxes[i], boxes[j])) continue;
      const auto [first, second] = std::minmax(part[i], part[j]);
      std::replace(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(i) + 1, second, first);
    }
  }
  CrtParts parts;
  for (size_t first = 0; first < operands.size(); ++first) {
    if (part[first] != first) continue;
    parts.emplace_back();
    for (size_t i = first; i < operands.size(); ++i)
      if (part[i] == first) parts.back().push_back(operands[i]);
  }
  return parts;
}

}  // namespace tessera
