#include "scenes/import/to_affine.h"

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

Vec3 to_vec(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }

Affine to_affine(const v1::Transform::Step& step) {
  switch (step.kind_case()) {
    case v1::Transform::Step::kTranslate:
      return translation(to_vec(step.translate()));
    case v1::Transform::Step::kScale:
      return scaling(to_vec(step.scale()));
    case v1::Transform::Step::kRotate: {
      const Vec3 axis = to_vec(step.rotate().axis());
      const double angle = portable::radians(step.rotate().angle());
      return axis == Vec3{} ? Affine{} : rotation(axis, angle);
    }
    case v1::Transform::Step::kLookAt: {
      const v1::LookAt& look = step.look_at();
      const Vec3 up = look.has_up() ? to_vec(look.up()) : Vec3{0, 1, 0};
      return look_at(Point3{} + to_vec(look.eye()), Point3{} + to_vec(look.target()),
                     up == Vec3{} ? up : normalize(up));
    }
    case v1::Transform::Step::kMatrix: {
      Affine out;
      if (step.matrix().rows_size() != 12) return out;
      for (int i = 0; i < 12; ++i)
        out.m[static_cast<size_t>(i / 4)][static_cast<size_t>(i % 4)] = step.matrix().rows(i);
      return out;
    }
    case v1::Transform::Step::KIND_NOT_SET:
      break;
  }
  return {};
}

}  // namespace

Affine to_affine(const v1::Transform& transform) {
  Affine out;
  for (const v1::Transform::Step& step : transform.steps()) out = out * to_affine(step);
  return out;
}

}  // namespace tessera
