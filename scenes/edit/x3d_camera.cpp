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
#include "scenes/formats/x3d/document/x3d_nodes.h"

namespace tessera::edit {

namespace {

/// The name that the reader gives the camera.
std::string name_of_camera(const Entity& entity) {
  if (!entity.name.empty()) return entity.name;
  const std::string description = written_text(entity, "description");
  return description.empty() ? "Viewpoint" : description;
}

/// The matrix of a node that places what it holds: T C R SR S -SR -C, as the reader has it. Nothing
/// where a field has no numbers.
std::optional<Affine> placement_of(const Entity& node, double angle_unit) {
  const auto vector = [&](std::string_view field, std::string_view otherwise) {
    return read_triple(written_text(node, field, otherwise));
  };
  const auto turn = [&](std::string_view field) {
    return read_axis_angle(written_text(node, field, "0 0 1 0"), angle_unit);
  };
  const auto shift = vector("translation", "0 0 0"), center = vector("center", "0 0 0");
  const auto scale = vector("scale", "1 1 1");
  const auto rotation = turn("rotation"), scale_rotation = turn("scaleOrientation");
  if (!shift || !center || !scale || !rotation || !scale_rotation) return {};
  const Affine scale_axes = rotation_of(*scale_rotation);
  return translation(to_vec(*shift) + to_vec(*center)) * rotation_of(*rotation) * scale_axes *
         scaling(to_vec(*scale)) * inverse(scale_axes) * translation(-to_vec(*center));
}

/// What leads from the axes that the camera's numbers are in to the world's.
struct CameraAxes {
  Affine to_world;
  std::optional<Refusal> refusal;
};

CameraAxes axes_around(const Outline& outline, const Entity& camera, const X3dUnits& units) {
  CameraAxes axes;
  for (int above = camera.parent; above > 0;) {
    const Entity& holder = outline.entities()[static_cast<size_t>(above)];
    above = holder.parent;
    if (holder.type == "PROTO" || holder.type == "ProtoDeclare")
      return {{}, Refusal{"a Viewpoint of a prototype", "one of the scene itself", camera.range}};
    if (!has_x3d_transform(holder.type)) continue;
    const auto placement = placement_of(holder, units.angle);
    if (!placement)
      return {{},
              Refusal{"a Transform around the Viewpoint that cannot be read",
                      "three numbers, or four of a rotation", holder.range}};
    axes.to_world = *placement * axes.to_world;
  }
  axes.to_world = scaling(Vec3{1, 1, 1} * units.length) * axes.to_world;
  if (!is_invertible(axes.to_world))
    axes.refusal =
        Refusal{"a Viewpoint in a flat Transform", "one that can be inverted", camera.range};
  else if (axes.to_world.determinant() < 0)
    axes.refusal = Refusal{"a Viewpoint in a Transform that mirrors, as its picture would be",
                           "one without an odd number of negative scales", camera.range};
  return axes;
}

/// The window of an OrthoViewpoint, as the view has it, in units of `unit` metres.
std::string window_of(double height, double unit) {
  constexpr double kShare = 1e-6;
  const std::string half = shortest_number(height / unit / 2, height / unit * kShare);
  return fmt::format("-{0} -{0} {0} {0}", half);
}

}  // namespace

Change write_xml_camera(const Outline& outline, std::string_view name, const CameraPose& pose) {
  const X3dUnits units = x3d_units(outline);
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
  const Entity there = sequence.now().entities()[static_cast<size_t>(camera)];
  if (!is_window && there.type != "Viewpoint")
    return refuse(fmt::format("the camera of {}", there.type), "a Viewpoint", there.range);
  const CameraAxes axes = axes_around(sequence.now(), there, units);
  if (axes.refusal) return refuse(axes.refusal->found, axes.refusal->expected, axes.refusal->range);
  const auto set = [&](std::string_view field, const std::string& value) {
    sequence.then([&](const Outline& now) { return set_xml_field(now, camera, field, value); });
  };
  const auto position = read_triple(written_text(there, "position", "0 0 10"));
  if (const auto eye = written_eye(pose, axes.to_world, position.value_or(Triple{NAN, NAN, NAN})))
    set("position", *eye);
  // What leads from the axes around the camera turns its view and its up; both lengths and the
  // angle between the two are the renderer's own.
  const Affine wanted =
      look_at(Point3{} + to_vec(pose.eye), Point3{} + to_vec(pose.target), to_vec(pose.up));
  const Affine local = seen_from(inverse(axes.to_world) * wanted);
  const auto is_wanted = [&](const std::string& orientation) {
    const auto turn = read_axis_angle(orientation, units.angle);
    return turn && rotation_difference(wanted, seen_from(axes.to_world * rotation_of(*turn))) <=
                       kSameRotation;
  };
  if (!is_wanted(written_text(there, "orientation", "0 0 1 0")))
    set("orientation", written_axis_angle(axis_angle(local), units.angle, is_wanted));
  if (pose.orthographic) {
    set("fieldOfView", window_of(*pose.orthographic, std::cbrt(axes.to_world.determinant())));
  } else if (pose.field_of_view) {
    constexpr double kSame = 1e-8, kUsual = 0.7854;
    const double radians = portable::radians(*pose.field_of_view);
    const auto number = typed_number(written_text(there, "fieldOfView"));
    const double old = number ? *number * units.angle : kUsual;
    if (std::abs(radians - old) > kSame)
      set("fieldOfView", shortest_number(radians / units.angle, kSame / units.angle));
  }
  const std::string view_all = written_text(there, "viewAll");
  if (view_all == "true" || view_all == "TRUE")
    sequence.then([&](const Outline& now) { return reset_xml_field(now, camera, "viewAll"); });
  return sequence.finish();
}

}  // namespace tessera::edit
