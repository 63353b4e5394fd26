#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/language_placement.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/x3d_edit.h"
#include "scenes/edit/x3d_rotation.h"
#include "scenes/edit/x3d_units.h"

namespace tessera::edit {

namespace {

/// The name that the reader gives the camera.
std::string name_of_camera(const Entity& entity) {
  if (!entity.name.empty()) return entity.name;
  const std::string description = written_text(entity, "description");
  return description.empty() ? "Viewpoint" : description;
}

Triple divided(const Triple& t, double by) { return {t[0] / by, t[1] / by, t[2] / by}; }

/// The pose with its lengths in the document's unit.
CameraPose in_lengths(CameraPose pose, double unit) {
  pose.eye = divided(pose.eye, unit);
  pose.target = divided(pose.target, unit);
  if (pose.orthographic) *pose.orthographic /= unit;
  return pose;
}

/// The window of an OrthoViewpoint, as the view has it.
std::string window_of(double height) {
  constexpr double kShare = 1e-6;
  const std::string half = shortest_number(height / 2, height * kShare);
  return fmt::format("-{0} -{0} {0} {0}", half);
}

}  // namespace

Change write_xml_camera(const Outline& outline, std::string_view name, const CameraPose& asked) {
  const X3dUnits units = x3d_units(outline);
  const CameraPose pose = in_lengths(asked, units.length);
  int camera = find_camera(outline, name, name_of_camera).value_or(-1);
  if (camera < 0 && !name.empty())
    return refuse(fmt::format("no Viewpoint '{}'", name), "a Viewpoint's name");
  const bool is_window =
      camera >= 0 && outline.entities()[static_cast<size_t>(camera)].type == "OrthoViewpoint";
  if (pose.orthographic && !is_window)
    return refuse("an orthographic camera", "a perspective one, as a Viewpoint is");
  if (!pose.orthographic && is_window)
    return refuse("a perspective camera", "an orthographic one, as an OrthoViewpoint is");
  if (!is_window && !pose.axis.empty() && pose.axis != "smaller")
    return refuse(fmt::format("a field of view over the {} axis", pose.axis),
                  "the smaller one, as X3D has it");
  EditSequence sequence(outline);
  if (camera < 0) {
    sequence.apply(add_xml(outline, {"camera", "Viewpoint", {}}));
    camera = find_camera(sequence.now(), "").value_or(-1);
    if (camera < 0) return sequence.finish();
  }
  sequence.keep(camera);
  const Entity& there = sequence.now().entities()[static_cast<size_t>(camera)];
  if (!is_window && there.type != "Viewpoint")
    return refuse(fmt::format("the camera of {}", there.type), "a Viewpoint", there.range);
  for (int above = there.parent; above > 0;
       above = sequence.now().entities()[static_cast<size_t>(above)].parent)
    if (sequence.now().entities()[static_cast<size_t>(above)].type == "Transform")
      return refuse("a Viewpoint inside of a Transform", "one that stands in the scene itself",
                    there.range);
  const auto set = [&](std::string_view field, const std::string& value) {
    sequence.then([&](const Outline& now) { return set_xml_field(now, camera, field, value); });
  };
  const WrittenCamera written{
      read_triple(written_text(there, "position", "0 0 10")).value_or(Triple{NAN, NAN, NAN}),
      pose.target, pose.up};
  const auto turn = read_axis_angle(written_text(there, "orientation", "0 0 1 0"), units.angle);
  const auto number = typed_number(written_text(there, "fieldOfView"));
  const CameraNumbers numbers = camera_numbers(pose, written, true);
  if (numbers.eye) set("position", *numbers.eye);
  const auto point = [](const Triple& t) { return Point3{t[0], t[1], t[2]}; };
  const Affine wanted =
      look_at(point(pose.eye), point(pose.target), {pose.up[0], pose.up[1], pose.up[2]});
  if (!turn || rotation_difference(wanted, rotation_of(*turn)) > kSameRotation)
    set("orientation", written_axis_angle(axis_angle(wanted), units.angle));
  if (pose.orthographic) {
    set("fieldOfView", window_of(*pose.orthographic));
  } else if (pose.field_of_view) {
    constexpr double kSame = 1e-8, kUsual = 0.7854;
    const double radians = portable::radians(*pose.field_of_view);
    const double old = number ? *number * units.angle : kUsual;
    if (std::abs(radians - old) > kSame)
      set("fieldOfView", shortest_number(radians / units.angle, kSame / units.angle));
  }
  return sequence.finish();
}

}  // namespace tessera::edit
