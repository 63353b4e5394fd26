#include "renderer/scene/read_transform.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "renderer/math/mix_transforms.h"

namespace tessera {

namespace {

using Step = v1::Transform::Step;
using Keys = google::protobuf::RepeatedPtrField<v1::TransformKey>;

Affine read_matrix(const Where& where, const v1::Matrix& matrix) {
  if (matrix.rows_size() != 12) {
    fail_value(where, "matrix.rows", fmt::format("{} numbers", matrix.rows_size()), "12 numbers");
  }
  Affine affine;
  for (int i = 0; i < 12; ++i) {
    affine.m[static_cast<size_t>(i) / 4][static_cast<size_t>(i) % 4] =
        checked(where, "matrix.rows", matrix.rows(i));
  }
  return affine;
}

Affine read_look_at(const Where& where, const v1::LookAt& look) {
  const Point3 eye = checked_point(where, "look_at.eye", look.eye());
  const Point3 target = checked_point(where, "look_at.target", look.target());
  if (eye == target) fail_value(where, "look_at.target", "the eye itself", "another point");
  const Vec3 up = look.has_up() ? checked_direction(where, "look_at.up", look.up()) : Vec3{0, 1, 0};
  return look_at(eye, target, up);
}

Affine read_rotation(const Where& where, const v1::AxisAngle& rotate) {
  const Vec3 axis = checked_direction(where, "rotate.axis", rotate.axis());
  // Whole turns are taken off first, which is exact, so that the sine is inside its range.
  const double angle = std::fmod(checked(where, "rotate.angle", rotate.angle()), 360.0);
  return angle == 0 ? Affine{} : rotation(axis, portable::radians(angle));
}

Affine read_step(const Where& where, const Step& step) {
  switch (step.kind_case()) {
    case Step::kTranslate:
      return translation(checked(where, "translate", step.translate()));
    case Step::kRotate:
      return read_rotation(where, step.rotate());
    case Step::kScale:
      return scaling(checked(where, "scale", step.scale()));
    case Step::kMatrix:
      return read_matrix(where, step.matrix());
    case Step::kLookAt:
      return read_look_at(where, step.look_at());
    case Step::KIND_NOT_SET:
      break;
  }
  fail_value(where, "a transform step", "empty", "translate, rotate, scale, matrix or look_at");
}

void mix(v1::Vec3& a, const v1::Vec3& b, double s) {
  a.set_x(a.x() + s * (b.x() - a.x()));
  a.set_y(a.y() + s * (b.y() - a.y()));
  a.set_z(a.z() + s * (b.z() - a.z()));
}

/// An axis that keys share may be written with other digits in each.
constexpr double kRounding = 1e-6;

/// Constant speed about one axis: by angle where both keys share it, even over several turns, else
/// along the shorter arc.
Affine mix_rotations(const Where& where, const v1::AxisAngle& a, const v1::AxisAngle& b, double s) {
  const Vec3 axis_a = checked_direction(where, "rotate.axis", a.axis());
  Vec3 axis_b = checked_direction(where, "rotate.axis", b.axis());
  const double angle_a = checked(where, "rotate.angle", a.angle());
  double angle_b = checked(where, "rotate.angle", b.angle());
  const auto turned = [](const Vec3& axis, double degrees) {
    const double angle = std::fmod(degrees, 360.0);
    return angle == 0 ? Affine{} : rotation(axis, portable::radians(angle));
  };
  if (std::abs(angle_a) <= kRounding) return turned(axis_b, angle_a + s * (angle_b - angle_a));
  if (std::abs(angle_b) <= kRounding) return turned(axis_a, angle_a + s * (angle_b - angle_a));
  if (length(cross(axis_a, axis_b)) <= kRounding) {
    if (dot(axis_a, axis_b) < 0) axis_b = -axis_b, angle_b = -angle_b;
    return turned(axis_a + s * (axis_b - axis_a), angle_a + s * (angle_b - angle_a));
  }
  return mix_turns(turned(axis_a, angle_a), turned(axis_b, angle_b), s);
}

/// Of two views of one target, which stays in sight: the eye and the direction of up are mixed;
/// between an up and its opposite it turns about the view.
v1::LookAt mix_eyes(const v1::LookAt& a, const v1::LookAt& b, double s) {
  v1::LookAt mixed = a;
  mix(*mixed.mutable_eye(), b.eye(), s);
  if (!a.has_up() && !b.has_up()) return mixed;
  const auto up_of = [](const v1::LookAt& look) {
    const Vec3 up =
        look.has_up() ? Vec3{look.up().x(), look.up().y(), look.up().z()} : Vec3{0, 1, 0};
    // No direction is an error that reading it tells.
    return length_squared(up) > 0 ? normalize(up) : up;
  };
  const Vec3 from = up_of(a), to = up_of(b);
  Vec3 up = from + s * (to - from);
  const bool is_opposite =
      dot(from, to) < 0 && length(cross(from, to)) <= kRounding * length(from) * length(to);
  if (is_opposite) {
    const Vec3 backward{mixed.eye().x() - mixed.target().x(), mixed.eye().y() - mixed.target().y(),
                        mixed.eye().z() - mixed.target().z()};
    // No view is an error that reading it tells.
    up = length_squared(backward) > 0 ? rotation(backward, s * portable::kPi)(from) : from;
  }
  mixed.mutable_up()->set_x(up.x);
  mixed.mutable_up()->set_y(up.y);
  mixed.mutable_up()->set_z(up.z);
  return mixed;
}

bool is_same(const v1::Vec3& a, const v1::Vec3& b) {
  return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}

Affine mix_steps(const Where& where, const Step& a, const Step& b, double s) {
  if (a.kind_case() == Step::kRotate) return mix_rotations(where, a.rotate(), b.rotate(), s);
  read_step(where, b);  // only for its checks
  Step mixed = a;
  switch (mixed.kind_case()) {
    case Step::kTranslate:
      mix(*mixed.mutable_translate(), b.translate(), s);
      break;
    case Step::kScale:
      mix(*mixed.mutable_scale(), b.scale(), s);
      break;
    case Step::kLookAt:
      // From one target to another the view turns as a matrix does, however far.
      if (!is_same(a.look_at().target(), b.look_at().target()))
        return mix_matrices(read_step(where, a), read_step(where, b), s);
      read_step(where, a);
      *mixed.mutable_look_at() = mix_eyes(a.look_at(), b.look_at(), s);
      break;
    case Step::kMatrix:
      return mix_matrices(read_step(where, a), read_step(where, b), s);
    default:
      break;
  }
  return read_step(where, mixed);
}

Affine checked_product(const Where& where, const Affine& product) {
  if (!is_finite(product))
    fail_value(where, "transform", "too large", "finite numbers in its product");
  return product;
}

void check_alike(const Where& where, const v1::TransformKey& a, const v1::TransformKey& b) {
  const int count = a.transform().steps_size();
  bool alike = count == b.transform().steps_size();
  for (int i = 0; alike && i < count; ++i) {
    alike = a.transform().steps(i).kind_case() == b.transform().steps(i).kind_case();
  }
  if (!alike) {
    fail_value(where, "keys",
               fmt::format("of different steps at {} s and {} s", a.time(), b.time()),
               "the same kinds of steps in every key");
  }
}

Affine mix_keys(const Where& where, const v1::TransformKey& a, const v1::TransformKey& b,
                double time) {
  const double s = (time - a.time()) / (b.time() - a.time());
  Affine product;
  for (int i = 0; i < a.transform().steps_size(); ++i) {
    product = product * mix_steps(where, a.transform().steps(i), b.transform().steps(i), s);
  }
  return checked_product(where, product);
}

}  // namespace

Affine read_transform(const Where& where, const v1::Transform& transform) {
  Affine product;
  for (const Step& step : transform.steps()) product = product * read_step(where, step);
  return checked_product(where, product);
}

Affine read_transform(const Where& where, const v1::Transform& transform, const Keys& keys,
                      double time) {
  if (keys.empty()) return read_transform(where, transform);
  for (int i = 0; i < keys.size(); ++i) {
    checked(where, "keys.time", keys[i].time());
    if (i > 0 && keys[i].time() <= keys[i - 1].time()) {
      fail_value(where, "keys.time", fmt::format("{} after {}", keys[i].time(), keys[i - 1].time()),
                 "increasing times");
    }
    // At whatever time: what is wrong with a later frame is told before the first one.
    if (i > 0) check_alike(where, keys[i - 1], keys[i]);
    read_transform(where, keys[i].transform());
  }
  if (time <= keys[0].time()) return read_transform(where, keys[0].transform());
  for (int i = 1; i < keys.size(); ++i) {
    if (time < keys[i].time()) return mix_keys(where, keys[i - 1], keys[i], time);
  }
  return read_transform(where, keys[keys.size() - 1].transform());
}

}  // namespace tessera
