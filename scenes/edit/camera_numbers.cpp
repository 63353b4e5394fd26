#include "scenes/edit/camera_numbers.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scenes/edit/literal.h"

namespace tessera::edit {
namespace {

Affine frame(const WrittenCamera& camera) {
  return look_at(Point3{} + to_vec(camera.eye), Point3{} + to_vec(camera.target),
                 to_vec(camera.up));
}

double reach(const WrittenCamera& camera) {
  return length(to_vec(camera.target) - to_vec(camera.eye));
}

}  // namespace

Triple shortened(const Triple& wanted, const Triple& there, double tolerance, std::string& text) {
  Triple made;
  text.clear();
  for (size_t i = 0; i < 3; ++i) {
    const bool keeps = std::abs(wanted[i] - there[i]) <= tolerance;
    const std::string number = shortest_number(keeps ? there[i] : wanted[i], keeps ? 0 : tolerance);
    made[i] = typed_number(number).value_or(wanted[i]);
    text += (i > 0 ? " " : "") + number;
  }
  return made;
}

double frame_distance(const WrittenCamera& a, const WrittenCamera& b) {
  const Affine fa = frame(a), fb = frame(b);
  const double unit = std::max(1.0, reach(a));
  double most = 0;
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(fa.m[r][c] - fb.m[r][c]));
    most = std::max(most, std::abs(fa.m[r][3] - fb.m[r][3]) / unit);
  }
  return std::isfinite(most) ? most : 2;
}

std::optional<Refusal> check_pose(const CameraPose& pose) {
  for (const Triple& t : {pose.eye, pose.target, pose.up})
    for (const double x : t)
      if (!std::isfinite(x)) return Refusal{"a number that is not finite", "finite numbers", {}};
  if (pose.eye == pose.target)
    return Refusal{"a camera that looks at itself", "another target", {}};
  if (pose.up == Triple{}) return Refusal{"up is 0 0 0", "a direction", {}};
  const double angle = pose.field_of_view.value_or(45);
  if (!(angle > 0 && angle < 360))
    return Refusal{"a field of view of " + shortest_number(angle, 0), "above 0 and below 180", {}};
  if (pose.orthographic && !(*pose.orthographic > 0 && std::isfinite(*pose.orthographic)))
    return Refusal{"an orthographic height that is not above 0", "a height above 0", {}};
  return {};
}

CameraNumbers camera_numbers(const CameraPose& pose, const WrittenCamera& there, bool has_up) {
  const WrittenCamera wanted{pose.eye, pose.target, has_up ? pose.up : there.up};
  const double unit = std::min(1.0, reach(wanted));
  WrittenCamera made;
  std::string eye, target, up;
  double tolerance = kSameFrame * unit;
  for (int i = 0; i < 12; ++i, tolerance /= 8) {
    made.eye = shortened(wanted.eye, there.eye, tolerance, eye);
    made.target = shortened(wanted.target, there.target, tolerance, target);
    made.up = there.up;
    if (has_up && frame_distance(wanted, made) > kSameFrame)
      made.up = shortened(wanted.up, there.up, tolerance * length(to_vec(wanted.up)) / unit, up);
    if (frame_distance(wanted, made) <= kSameFrame) break;
  }
  CameraNumbers numbers;
  if (made.eye != there.eye) numbers.eye = eye;
  if (made.target != there.target) numbers.target = target;
  if (made.up != there.up) numbers.up = up;
  return numbers;
}

Affine seen_from(const Affine& frame) {
  const Point3 eye = frame(Point3{});
  return look_at(eye, eye - frame(Vec3{0, 0, 1}), frame(Vec3{0, 1, 0}));
}

std::optional<std::string> written_eye(const CameraPose& pose, const Affine& to_world,
                                       const Triple& there) {
  const Point3 eye = Point3{} + to_vec(pose.eye);
  const double reach = length(to_vec(pose.target) - to_vec(pose.eye));
  const double most = kSameFrame * std::max(1.0, reach);
  const Point3 local = inverse(to_world)(eye);
  double tolerance =
      kSameFrame * std::min(1.0, reach) / std::cbrt(std::abs(to_world.determinant()));
  Triple made;
  std::string text;
  for (int i = 0; i < 12; ++i, tolerance /= 8) {
    made = shortened({local.x, local.y, local.z}, there, tolerance, text);
    if (length(to_world(Point3{} + to_vec(made)) - eye) <= most) break;
  }
  return made == there ? std::nullopt : std::optional(text);
}

std::optional<int> find_camera(const Outline& outline, std::string_view name,
                               std::string (*name_of)(const Entity&)) {
  std::vector<int> cameras;
  for (size_t i = 0; i < outline.entities().size(); ++i) {
    const Entity& entity = outline.entities()[i];
    if (entity.kind != EntityKind::camera) continue;
    if (name.empty() || (name_of ? name_of(entity) : entity.name) == name)
      return static_cast<int>(i);
    cameras.push_back(static_cast<int>(i));
  }
  const double number = typed_number(name).value_or(0);
  for (size_t i = 0; i < cameras.size(); ++i)
    if (static_cast<double>(i + 1) == number) return cameras[i];
  return {};
}

std::optional<Triple> read_triple(std::string_view text) {
  const auto parts = typed_parts(text);
  if (parts.size() != 3) return {};
  Triple made;
  for (size_t i = 0; i < 3; ++i) {
    const auto number = typed_number(parts[i]);
    if (!number) return {};
    made[i] = *number;
  }
  return made;
}

}  // namespace tessera::edit
