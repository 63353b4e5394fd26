#include "renderer/scene/read_transform.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "renderer/math/elementary.h"

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

struct Quaternion {
  double w;
  Vec3 v;
};

Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), a.w * b.v + b.w * a.v + cross(a.v, b.v)};
}

Quaternion to_quaternion(const Where& where, const v1::AxisAngle& rotate) {
  const Vec3 axis = checked_direction(where, "rotate.axis", rotate.axis());
  const double half =
      portable::radians(std::fmod(checked(where, "rotate.angle", rotate.angle()), 720.0)) / 2;
  return {portable::cos(half), axis * portable::sin(half)};
}

/// Constant speed about one axis: by angle where both keys share it, else along the shorter arc
/// (Shoemake 1985).
Affine mix_rotations(const Where& where, const v1::AxisAngle& a, const v1::AxisAngle& b, double s) {
  const Vec3 axis_a = checked_direction(where, "rotate.axis", a.axis());
  const Vec3 axis_b = checked_direction(where, "rotate.axis", b.axis());
  if (axis_a == axis_b || a.angle() == 0 || b.angle() == 0) {
    v1::AxisAngle mixed = a.angle() == 0 ? b : a;
    mixed.set_angle(a.angle() + s * (b.angle() - a.angle()));
    return read_rotation(where, mixed);
  }
  const Quaternion from = to_quaternion(where, a);
  Quaternion turn = Quaternion{from.w, -from.v} * to_quaternion(where, b);
  if (turn.w < 0) turn = {-turn.w, -turn.v};
  const double sine = length(turn.v);
  if (sine == 0) return read_rotation(where, a);
  const double angle = 2 * portable::atan2(sine, turn.w);
  return read_rotation(where, a) * rotation(turn.v, s * angle);
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
      mix(*mixed.mutable_look_at()->mutable_eye(), b.look_at().eye(), s);
      mix(*mixed.mutable_look_at()->mutable_target(), b.look_at().target(), s);
      break;
    case Step::kMatrix:
      read_step(where, a);
      for (int i = 0; i < 12; ++i) {
        const double value = a.matrix().rows(i);
        mixed.mutable_matrix()->set_rows(i, value + s * (b.matrix().rows(i) - value));
      }
      break;
    default:
      break;
  }
  return read_step(where, mixed);
}

Affine checked_product(const Where& where, const Affine& product) {
  for (const auto& row : product.m) {
    for (const double value : row) {
      if (!std::isfinite(value)) {
        fail_value(where, "transform", "too large", "finite numbers in its product");
      }
    }
  }
  return product;
}

Affine mix_keys(const Where& where, const v1::TransformKey& a, const v1::TransformKey& b,
                double time) {
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
  const double s = (time - a.time()) / (b.time() - a.time());
  Affine product;
  for (int i = 0; i < count; ++i) {
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
  }
  if (time <= keys[0].time()) return read_transform(where, keys[0].transform());
  for (int i = 1; i < keys.size(); ++i) {
    if (time < keys[i].time()) return mix_keys(where, keys[i - 1], keys[i], time);
  }
  return read_transform(where, keys[keys.size() - 1].transform());
}

bool is_invertible(const Affine& affine) {
  const double determinant = affine.determinant();
  if (!std::isfinite(determinant) || determinant == 0 || !std::isfinite(1 / determinant)) {
    return false;
  }
  const Affine inverted = inverse(affine);
  for (const auto& row : inverted.m) {
    for (const double value : row) {
      if (!std::isfinite(value)) return false;
    }
  }
  // Beyond, nothing but rounding is left of where it leads: it was flat before it was multiplied.
  constexpr double kLargestCondition = 0x1p46;
  return condition(affine, inverted) <= kLargestCondition;
}

}  // namespace tessera
