#include <fmt/format.h>

#include <cmath>

#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/message_outline.h"
#include "scenes/edit/message_path.h"

namespace tessera::edit {
namespace {

constexpr std::string_view kLook = "world_from_camera.steps[0].look_at.";
constexpr double kSameAngle = 1e-6;

std::optional<std::string> value_of(const Outline& outline, int entity, std::string_view path) {
  const auto node = static_cast<int32_t>(outline.entities()[static_cast<size_t>(entity)].syntax);
  const MessagePath found = find_field(outline.tree(), node, path);
  if (found.refusal || found.leaf < 0) return {};
  return shown_value(outline.text(), outline.tree(), found.leaf);
}

bool has(const Outline& outline, int entity, std::string_view path) {
  const auto node = static_cast<int32_t>(outline.entities()[static_cast<size_t>(entity)].syntax);
  const MessagePath found = find_field(outline.tree(), node, path);
  return !found.refusal && found.leaf >= 0;
}

/// Writes one camera; each step is a change of the text that the last one made.
class CameraWriter {
 public:
  CameraWriter(const Outline& outline, int camera, const CameraPose& pose)
      : sequence_(outline), camera_(camera), pose_(pose) {
    sequence_.keep(camera);
  }

  Change write() {
    place();
    if (pose_.orthographic) {
      window();
    } else {
      angle();
    }
    if (value("frame_all") == "true") reset("frame_all");
    return sequence_.finish();
  }

 private:
  std::optional<std::string> value(std::string_view path) const {
    return value_of(sequence_.now(), camera_, path);
  }
  void set(const std::string& path, const std::string& text) {
    sequence_.then([&](const Outline& now) { return set_message_field(now, camera_, path, text); });
  }
  void reset(std::string_view path) {
    sequence_.then([&](const Outline& now) { return reset_message_field(now, camera_, path); });
  }

  void place() {
    const bool is_plain = has(sequence_.now(), camera_, "world_from_camera.steps[0].look_at") &&
                          !has(sequence_.now(), camera_, "world_from_camera.steps[1]");
    if (!is_plain) reset("world_from_camera");
    WrittenCamera there;
    const auto read = [&](std::string_view part, Triple& into) {
      if (const auto text = value(std::string(kLook) + std::string(part)))
        into = read_triple(*text).value_or(Triple{NAN, NAN, NAN});
    };
    read("eye", there.eye);
    read("target", there.target);
    read("up", there.up);
    const CameraNumbers numbers = camera_numbers(pose_, there, true);
    const std::string look(kLook);
    if (numbers.eye) set(look + "eye", *numbers.eye);
    if (numbers.target) set(look + "target", *numbers.target);
    if (numbers.up) set(look + "up", *numbers.up);
    // A camera without a step stands at (0, 0, 0) and looks along -z: what was kept is said anyway.
    if (!is_plain && !numbers.eye && !numbers.target) set(look + "target", "0 0 0");
  }

  void number(const std::string& path, double wanted, double fallback) {
    const auto written = value(path);
    const auto there = written ? typed_number(*written) : fallback;
    if (there && std::abs(*there - wanted) <= kSameAngle) return;
    set(path, shortest_number(wanted, kSameAngle));
  }

  void angle() {
    if (has(sequence_.now(), camera_, "orthographic")) reset("orthographic");
    if (!pose_.field_of_view) return;
    for (const char* const panorama : {"spherical", "cylindrical"})
      if (has(sequence_.now(), camera_, panorama)) return;
    number("perspective.field_of_view", *pose_.field_of_view, 45);
    if (pose_.axis.empty()) return;
    std::string axis = pose_.axis;
    for (char& c : axis)
      if ('a' <= c && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    if (value("perspective.axis").value_or("SMALLER") != axis) set("perspective.axis", axis);
  }

  void window() {
    for (const char* const other : {"perspective", "spherical", "cylindrical"})
      if (has(sequence_.now(), camera_, other)) reset(other);
    const double half = *pose_.orthographic / 2;
    number("orthographic.min_x", -half, -1);
    number("orthographic.min_y", -half, -1);
    number("orthographic.max_x", half, 1);
    number("orthographic.max_y", half, 1);
    if (!has(sequence_.now(), camera_, "orthographic"))
      set("orthographic.max_y", shortest_number(half, kSameAngle));
  }

  EditSequence sequence_;
  int camera_;
  const CameraPose& pose_;
};

}  // namespace

Change write_message_camera(const Outline& outline, std::string_view name, const CameraPose& pose) {
  auto camera = find_camera(outline, name);
  if (!camera && !name.empty())
    return refuse(fmt::format("no camera '{}'", name), "a camera's name");
  if (!camera) {
    EditSequence inserted(outline);
    inserted.apply(add_message(outline, 0, {"camera", "cameras", {}}));
    camera = find_camera(inserted.now(), "");
    if (!camera) return inserted.finish();
    inserted.keep(*camera);
    inserted.apply(write_message_camera(inserted.now(), "", pose));
    return inserted.finish();
  }
  if (has(outline, *camera, "keys[0]"))
    return refuse("a camera that moves by keys", "a camera that stands still",
                  outline.entities()[static_cast<size_t>(*camera)].range);
  return CameraWriter(outline, *camera, pose).write();
}

}  // namespace tessera::edit
