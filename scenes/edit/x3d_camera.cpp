#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/x3d_edit.h"
#include "scenes/edit/x3d_rotation.h"

namespace tessera::edit {

Change write_xml_camera(const Outline& outline, std::string_view name, const CameraPose& pose) {
  int camera = find_camera(outline, name).value_or(-1);
  if (pose.orthographic) return refuse("an orthographic camera", "a perspective one");
  if (!pose.axis.empty() && pose.axis != "smaller")
    return refuse(fmt::format("a field of view over the {} axis", pose.axis),
                  "the smaller one, as X3D has it");
  if (camera < 0 && !name.empty())
    return refuse(fmt::format("no Viewpoint '{}'", name), "a Viewpoint's name");
  EditSequence sequence(outline);
  if (camera < 0) {
    sequence.apply(add_xml(outline, {"camera", "Viewpoint", {}}));
    for (size_t i = 0; i < sequence.now().entities().size(); ++i)
      if (sequence.now().entities()[i].type == "Viewpoint") camera = static_cast<int>(i);
    if (camera < 0) return sequence.finish();
  }
  sequence.keep(camera);
  const Entity& asked = sequence.now().entities()[static_cast<size_t>(camera)];
  if (asked.type != "Viewpoint")
    return refuse(fmt::format("the camera of {}", asked.type), "a Viewpoint", asked.range);
  for (int above = asked.parent; above > 0;
       above = sequence.now().entities()[static_cast<size_t>(above)].parent)
    if (sequence.now().entities()[static_cast<size_t>(above)].type == "Transform")
      return refuse("a Viewpoint inside of a Transform", "one that stands in the scene itself",
                    asked.range);
  AxisAngle there{0, 0, 1, 0};
  WrittenCamera written{{0, 0, 10}, pose.target, pose.up};
  double angle = 0.7854;
  for (const Field& field : asked.fields) {
    if (field.name == "position") written.eye = read_triple(field.text).value_or(written.eye);
    if (field.name == "orientation") there = read_axis_angle(field.text).value_or(there);
    if (field.name == "fieldOfView") angle = typed_number(field.text).value_or(angle);
  }
  const auto set = [&](std::string_view field, const std::string& value) {
    sequence.then([&](const Outline& now) { return set_xml_field(now, camera, field, value); });
  };
  const CameraNumbers numbers = camera_numbers(pose, written, true);
  if (numbers.eye) set("position", *numbers.eye);
  const auto point = [](const Triple& t) { return Point3{t[0], t[1], t[2]}; };
  const Affine wanted =
      look_at(point(pose.eye), point(pose.target), {pose.up[0], pose.up[1], pose.up[2]});
  if (rotation_difference(wanted, rotation_of(there)) > kSameRotation)
    set("orientation", written_axis_angle(axis_angle(wanted)));
  constexpr double kSame = 1e-8;
  const double radians = portable::radians(pose.field_of_view.value_or(45));
  if (pose.field_of_view && std::abs(radians - angle) > kSame)
    set("fieldOfView", shortest_number(radians, kSame));
  return sequence.finish();
}

}  // namespace tessera::edit
