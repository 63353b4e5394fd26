#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "scenes/edit/language_placement.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_outline.h"
#include "scenes/edit/message_path.h"

namespace tessera::edit {
namespace {

/// The steps of a placement, in their order in a transform.
enum StepKind { move_step, turn_x_step, turn_y_step, turn_z_step, scale_step, kStepKinds };

/// Which of an include's transform's steps is which; -1: it has none of these.
struct MessageSteps {
  std::array<int, kStepKinds> index{-1, -1, -1, -1, -1};
  int count = 0;
  bool is_placement = true;
};

/// The fields of an entity's part as the text has them, "0" where it has none.
std::string text_at(const Outline& outline, int entity, std::string_view path) {
  const auto node = static_cast<int32_t>(outline.entities()[static_cast<size_t>(entity)].syntax);
  const MessagePath found = find_field(outline.tree(), node, path);
  return found.refusal || found.leaf < 0 ? ""
                                         : shown_value(outline.text(), outline.tree(), found.leaf);
}

bool has_at(const Outline& outline, int entity, const std::string& path) {
  const auto node = static_cast<int32_t>(outline.entities()[static_cast<size_t>(entity)].syntax);
  const MessagePath found = find_field(outline.tree(), node, path);
  return !found.refusal && found.leaf >= 0;
}

std::string step_path(int index) { return fmt::format("transform.steps[{}]", index); }

TypedTriple triple_at(const Outline& outline, int entity, const std::string& path) {
  const std::vector<std::string> parts = typed_parts(text_at(outline, entity, path));
  TypedTriple triple{"0", "0", "0"};
  for (size_t i = 0; i < std::min<size_t>(parts.size(), 3); ++i) triple[i] = parts[i];
  return triple;
}

/// The axis of a rotation about one of the three, from 0; nothing for any other.
std::optional<int> axis_at(const Outline& outline, int entity, const std::string& path) {
  const TypedTriple axis = triple_at(outline, entity, path);
  std::optional<int> found;
  for (int i = 0; i < 3; ++i) {
    const auto part = typed_number(axis[static_cast<size_t>(i)]);
    if (!part || *part < 0 || (*part > 0 && found)) return {};
    if (*part > 0) found = i;
  }
  return found;
}

std::optional<StepKind> kind_of_step(const Outline& outline, int entity, int index) {
  const std::string path = step_path(index);
  if (has_at(outline, entity, path + ".translate")) return move_step;
  if (has_at(outline, entity, path + ".scale")) return scale_step;
  if (!has_at(outline, entity, path + ".rotate")) return {};
  const auto axis = axis_at(outline, entity, path + ".rotate.axis");
  return axis ? std::optional(static_cast<StepKind>(turn_x_step + *axis)) : std::nullopt;
}

MessageSteps message_steps(const Outline& outline, int entity) {
  MessageSteps steps;
  int last = -1;
  for (; has_at(outline, entity, step_path(steps.count)); ++steps.count) {
    const auto kind = kind_of_step(outline, entity, steps.count);
    if (!kind || *kind <= last) {
      steps.is_placement = false;
      return steps;
    }
    last = *kind;
    steps.index[*kind] = steps.count;
  }
  return steps;
}

/// The value of a step, and what it is where there is none.
TypedTriple message_value(const Placement& placement, int kind) {
  if (kind == move_step) return placement.position;
  if (kind == scale_step) return signed_scale(placement);
  return {placement.rotation[static_cast<size_t>(kind - turn_x_step)], "0", "0"};
}

EntityTemplate made_step(int kind, const TypedTriple& value) {
  EntityTemplate made{"step", "transform.steps", {}};
  const std::string numbers = fmt::format("{}", fmt::join(value, " "));
  if (kind == move_step) {
    made.fields = {{"translate", numbers}};
  } else if (kind == scale_step) {
    made.fields = {{"scale", numbers}};
  } else {
    TypedTriple axis{"0", "0", "0"};
    axis[static_cast<size_t>(kind - turn_x_step)] = "1";
    made.fields = {{"rotate.axis", fmt::format("{}", fmt::join(axis, " "))},
                   {"rotate.angle", value[0]}};
  }
  return made;
}

}  // namespace

void read_message_placement(const Outline& outline, int entity, WrittenPlacement& read) {
  Placement& placement = read.placement;
  const MessageSteps steps = message_steps(outline, entity);
  if (!steps.is_placement) {
    read.locked =
        "its transform is another than translate, rotations about x, y and z, and scale, in this "
        "order";
    return;
  }
  const auto path = [&](int kind) { return step_path(steps.index[static_cast<size_t>(kind)]); };
  if (steps.index[move_step] >= 0)
    placement.position = triple_at(outline, entity, path(move_step) + ".translate");
  for (int axis = 0; axis < 3; ++axis) {
    const int kind = turn_x_step + axis;
    if (steps.index[static_cast<size_t>(kind)] < 0) continue;
    const std::string angle = text_at(outline, entity, path(kind) + ".rotate.angle");
    placement.rotation[static_cast<size_t>(axis)] = angle.empty() ? "0" : angle;
  }
  if (steps.index[scale_step] >= 0)
    set_signed_scale(placement, triple_at(outline, entity, path(scale_step) + ".scale"));
}

void set_message_placement(EditSequence& sequence, int entity, const Placement& there,
                           const Placement& wanted) {
  const MessageSteps steps = message_steps(sequence.now(), entity);
  const auto is_wanted = [&](int kind) {
    return !is_same(message_value(wanted, kind), message_value(Placement{}, kind));
  };
  // A step that others follow cannot be added behind the last one.
  int last = -1;
  for (int kind = 0; kind < kStepKinds; ++kind)
    if (steps.index[static_cast<size_t>(kind)] >= 0) last = kind;
  bool is_anew = false;
  for (int kind = 0; kind < last; ++kind)
    is_anew = is_anew || (steps.index[static_cast<size_t>(kind)] < 0 && is_wanted(kind));
  if (is_anew)
    sequence.then([&](const Outline& now) { return reset_field(now, entity, "transform"); });
  for (int kind = 0; kind < kStepKinds; ++kind) {
    const int index = is_anew ? -1 : steps.index[static_cast<size_t>(kind)];
    const TypedTriple value = message_value(wanted, kind), before = message_value(there, kind);
    if (index < 0 && is_wanted(kind)) {
      sequence.then([&](const Outline& now) { return add(now, entity, made_step(kind, value)); });
    } else if (index >= 0 && !is_same(before, value)) {
      const bool is_turn = kind != move_step && kind != scale_step;
      const std::string path = step_path(index) + (kind == move_step    ? ".translate"
                                                   : kind == scale_step ? ".scale"
                                                                        : ".rotate.angle");
      sequence.then([&](const Outline& now) {
        return set_field(now, entity, path, is_turn ? value[0] : respelled(before, value));
      });
    }
  }
}

}  // namespace tessera::edit
