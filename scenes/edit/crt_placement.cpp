#include <fmt/format.h>

#include <optional>

#include "scenes/edit/crt_edit.h"
#include "scenes/edit/crt_outline.h"
#include "scenes/edit/crt_syntax.h"
#include "scenes/edit/language_placement.h"
#include "scenes/edit/literal.h"

namespace tessera::edit {
namespace {

using P = CrtPart;

/// The modifiers of a placement, in the order in which a script applies them.
constexpr std::array<std::string_view, 3> kStepWords{"scale", "rotate", "translate"};
constexpr size_t kScaleStep = 0, kRotateStep = 1;

/// Which entities are the steps of a Mesh; -1: it has none of that kind.
struct CrtSteps {
  std::array<int, 3> entity{-1, -1, -1};
  bool is_placement = true;
};

CrtSteps crt_steps(const Outline& outline, int mesh) {
  CrtSteps steps;
  size_t next = 0;
  const auto& entities = outline.entities();
  for (size_t i = static_cast<size_t>(mesh) + 1; i < entities.size(); ++i) {
    if (entities[i].parent != mesh || entities[i].kind != EntityKind::step) continue;
    while (next < kStepWords.size() && kStepWords[next] != entities[i].type) ++next;
    if (next == kStepWords.size()) {
      steps.is_placement = false;
      return steps;
    }
    steps.entity[next++] = static_cast<int>(i);
  }
  return steps;
}

/// Reads the values of steps.
class StepReader {
 public:
  explicit StepReader(const Outline& outline)
      : outline_(outline),
        tree_(outline.tree()),
        variables_(crt_variables(outline.text(), outline.tree())) {}

  /// The numbers of a step; nothing where one of them is computed, or comes from a variable that
  /// has other uses, which would change with it.
  std::optional<TypedTriple> numbers(int step, bool is_scale) const {
    const auto& fields = outline_.entities()[static_cast<size_t>(step)].fields;
    if (fields.empty()) return {};
    const int32_t literal = own_literal(fields.front().syntax);
    if (literal < 0) return {};
    if (is_scale && is_number(literal))
      return TypedTriple{word(literal), word(literal), word(literal)};
    if (!is_crt_vector(outline_.text(), tree_[literal]) ||
        text_of(outline_.text(), tree_[literal].name) != "vec3")
      return {};
    TypedTriple triple;
    size_t count = 0;
    for (int32_t k = tree_[literal].first_child; k >= 0; k = tree_[k].next, ++count) {
      const int32_t part = own_literal(k);
      if (count == triple.size() || part < 0 || !is_number(part)) return {};
      triple[count] = word(part);
    }
    return count == triple.size() ? std::optional(triple) : std::nullopt;
  }

  /// Whether a change of the Mesh would show in several places: in a loop, or as a part of what a
  /// variable holds that is used several times, such as a macro.
  bool is_repeated(int mesh) const {
    auto node = static_cast<int32_t>(outline_.entities()[static_cast<size_t>(mesh)].syntax);
    for (; node > 0; node = tree_[node].parent) {
      if (crt_part(tree_[node]) == P::loop) return true;
      if (crt_part(tree_[node]) != P::assignment) continue;
      const auto variable = variables_.find(text_of(outline_.text(), tree_[node].name));
      if (variable != variables_.end() && variable->second.uses > 1) return true;
    }
    return false;
  }

 private:
  std::string word(int32_t node) const {
    return std::string(text_of(outline_.text(), tree_[node].range));
  }
  bool is_number(int32_t node) const {
    const P part = crt_part(tree_[node]);
    return (part == P::integer || part == P::real) && typed_number(word(node));
  }

  /// The literal that no value but the one at `node` comes from; -1: there is none.
  int32_t own_literal(int32_t node) const {
    const int32_t literal = crt_literal(outline_.text(), tree_, variables_, node);
    while (literal >= 0 && node != literal) {
      const CrtVariable& variable = variables_.at(text_of(outline_.text(), tree_[node].range));
      if (variable.uses > 1) return -1;
      node = variable.value;
    }
    return literal;
  }

  const Outline& outline_;
  const SyntaxTree& tree_;
  CrtVariables variables_;
};

bool is_even(const TypedTriple& scale) { return is_same(scale, {scale[0], scale[0], scale[0]}); }

/// The value of a step as it is written anew: one number for a scale that is even.
std::string new_value(size_t kind, const TypedTriple& numbers) {
  if (kind == kScaleStep && is_even(numbers)) return crt_number(numbers[0], "");
  return fmt::format("vec3({}, {}, {})", crt_number(numbers[0], ""), crt_number(numbers[1], ""),
                     crt_number(numbers[2], ""));
}

Change insert_step(const Outline& outline, int mesh, size_t kind, const TypedTriple& numbers) {
  const CrtSteps steps = crt_steps(outline, mesh);
  const auto& entities = outline.entities();
  const std::string made = fmt::format("{} {}", kStepWords[kind], new_value(kind, numbers));
  int before = -1, behind = -1;
  for (size_t i = 0; i < kStepWords.size(); ++i) {
    if (steps.entity[i] < 0) continue;
    if (i < kind) before = steps.entity[i];
    if (i > kind && behind < 0) behind = steps.entity[i];
  }
  TextEdit edit;
  uint32_t at = 0;
  if (before >= 0) {
    at = entities[static_cast<size_t>(before)].range.end;
    edit.text = ", " + made;
  } else if (behind >= 0) {
    at = entities[static_cast<size_t>(behind)].range.begin;
    edit.text = made + ", ";
  } else {
    at = outline.tree()[static_cast<int32_t>(entities[static_cast<size_t>(mesh)].syntax)].range.end;
    edit.text = fmt::format(" <{}>", made);
  }
  edit.range = {at, at};
  Change change;
  change.edits.push_back(std::move(edit));
  return change;
}

Change set_step(const Outline& outline, int step, const TypedTriple& there,
                const TypedTriple& wanted) {
  const Field& field = outline.entities()[static_cast<size_t>(step)].fields.front();
  if (field.kind == ValueKind::vector)
    return set_crt_field(outline, step, field.name, respelled(there, wanted));
  if (is_even(wanted)) return set_crt_field(outline, step, field.name, wanted[0]);
  Change change;
  change.edits.push_back({field.value, new_value(kScaleStep, wanted)});
  return change;
}

TypedTriple crt_value(const Placement& placement, size_t kind) {
  return kind == kScaleStep    ? signed_scale(placement)
         : kind == kRotateStep ? placement.rotation
                               : placement.position;
}

}  // namespace

void read_crt_placement(const Outline& outline, int entity, WrittenPlacement& read) {
  const Entity& mesh = outline.entities()[static_cast<size_t>(entity)];
  const SyntaxNode& object = outline.tree()[static_cast<int32_t>(mesh.syntax)];
  const CrtSteps steps = crt_steps(outline, entity);
  const StepReader reader(outline);
  if (!steps.is_placement) {
    read.locked = "its modifiers are others than scale, rotate and translate, in this order";
  } else if (reader.is_repeated(entity)) {
    read.locked = "the script places it several times, and all of them would change";
  } else if (!object.is_closed || object.body.begin < object.name.end) {
    read.locked = "its braces are not there or not closed";
  }
  for (size_t kind = 0; kind < kStepWords.size() && steps.is_placement; ++kind) {
    if (steps.entity[kind] < 0) continue;
    const auto numbers = reader.numbers(steps.entity[kind], kind == kScaleStep);
    if (!numbers) {
      read.locked = fmt::format("its {} is computed, or comes from a variable that has other uses",
                                kStepWords[kind]);
    } else if (kind == kScaleStep) {
      set_signed_scale(read.placement, *numbers);
    } else {
      (kind == kRotateStep ? read.placement.rotation : read.placement.position) = *numbers;
    }
  }
}

void set_crt_placement(EditSequence& sequence, int entity, const Placement& there,
                       const Placement& wanted) {
  for (size_t kind = 0; kind < kStepWords.size(); ++kind) {
    const TypedTriple before = crt_value(there, kind), after = crt_value(wanted, kind);
    if (is_same(before, after)) continue;
    sequence.then([&](const Outline& now) {
      const int step = crt_steps(now, entity).entity[kind];
      return step < 0 ? insert_step(now, entity, kind, after) : set_step(now, step, before, after);
    });
  }
}

}  // namespace tessera::edit
