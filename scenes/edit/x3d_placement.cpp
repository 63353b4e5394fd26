#include <fmt/format.h>

#include <algorithm>

#include "scenes/edit/language_placement.h"
#include "scenes/edit/layout.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/x3d_edit.h"
#include "scenes/edit/x3d_rotation.h"
#include "scenes/edit/x3d_units.h"
#include "scenes/edit/x3d_words.h"
#include "scenes/edit/xml_syntax.h"

namespace tessera::edit {
namespace {

constexpr std::string_view kTranslation = "translation", kRotation = "rotation", kScaling = "scale";

const Entity& entity_at(const Outline& outline, int entity) {
  return outline.entities()[static_cast<size_t>(entity)];
}

/// The Transform that holds the Inline alone and so is its placement; -1: there is none. One that
/// moves the centre or the axes of its scale is none: the Inline gets its own inside of it.
int placing_transform(const Outline& outline, int entity) {
  const int above = entity_at(outline, entity).parent;
  if (above < 0) return -1;
  const Entity& holder = entity_at(outline, above);
  if (holder.type != "Transform" || written_field(holder, "center") ||
      written_field(holder, "scaleOrientation"))
    return -1;
  const SyntaxTree& tree = outline.tree();
  int held = 0;
  for (int32_t k = tree[static_cast<int32_t>(holder.syntax)].first_child; k >= 0; k = tree[k].next)
    if (xml_part(tree[k]) != XmlPart::attribute) ++held;
  return held == 1 ? above : -1;
}

/// What holds the Inline and is used elsewhere, too, where any change inside of it would show. A
/// use of the Inline itself is a place of its own, with another Transform around it.
const Entity* shared_holder(const Outline& outline, int entity) {
  for (int above = entity_at(outline, entity).parent; above >= 0;
       above = entity_at(outline, above).parent) {
    const Field* const name = written_field(entity_at(outline, above), "DEF");
    if (name && name->uses > 1) return &entity_at(outline, above);
  }
  return nullptr;
}

std::optional<TypedTriple> three_numbers(const std::string& text) {
  const auto words = number_words(text, {0, static_cast<uint32_t>(text.size())});
  TypedTriple triple;
  if (words.size() != triple.size()) return {};
  for (size_t i = 0; i < triple.size(); ++i) {
    triple[i] = text_of(text, words[i]);
    if (!typed_number(triple[i])) return {};
  }
  return triple;
}

/// Puts a Transform around the Inline, which keeps its bytes, on lines of its own where the Inline
/// has them.
Change wrap(const Outline& outline, int entity) {
  const Entity& asked = entity_at(outline, entity);
  const SyntaxTree& tree = outline.tree();
  const SyntaxNode& node = tree[static_cast<int32_t>(asked.syntax)];
  if (!node.is_closed) return refuse("an Inline that is never closed", "its end", asked.range);
  const std::string& text = outline.text();
  const bool is_classic = outline.language() == Language::classic_x3d;
  SourceRange place = asked.range;
  // In the classic encoding the field that holds the Inline stays before the Transform.
  if (xml_part(node) == XmlPart::held) {
    place.begin = node.name.begin;
    if (const Field* const name = written_field(asked, "DEF")) place.begin = name->range.begin;
  }
  std::string before, inside, behind;
  if (Layout(text, is_classic ? "#" : "").has_own_lines(asked.range)) {
    behind = fmt::format("{}{}", line_ending(text, place.begin), indentation(text, place.begin));
    before = inside = behind + indentation_unit(text, "  ");
    place.end = line_end(text, place.end);
  } else if (is_classic) {
    inside = behind = " ";
  }
  Change change;
  change.edits.push_back(
      {{place.begin, place.begin},
       is_classic ? "Transform {" + inside + "children " : "<Transform>" + inside});
  change.edits.push_back({{place.end, place.end}, behind + (is_classic ? "}" : "</Transform>")});
  return change;
}

/// Why the placement cannot be set; empty where it can.
std::string lock_of(const Outline& outline, int entity) {
  if (const Entity* const shared = shared_holder(outline, entity))
    return fmt::format("'{}' around it is used in other places, which would change, too",
                       shared->name);
  if (x3d_units(outline).angle != 1) return "the document has a unit of its own for angles";
  return "";
}

}  // namespace

void read_x3d_placement(const Outline& outline, int entity, WrittenPlacement& read) {
  const Entity& asked = entity_at(outline, entity);
  Placement& placement = read.placement;
  read.locked = lock_of(outline, entity);
  // A use of an Inline has the file of its definition.
  if (written_field(asked, "USE")) {
    if (const auto defined = outline.entity_named(EntityKind::include, asked.name))
      placement.file = written_text(entity_at(outline, *defined), "url");
  }
  const int transform = placing_transform(outline, entity);
  if (transform < 0) return;
  const Entity& holder = entity_at(outline, transform);
  const auto take = [&](std::string_view field, const std::optional<TypedTriple>& numbers) {
    if (!numbers) read.locked = fmt::format("the {} of its Transform cannot be read", field);
    return numbers.value_or(TypedTriple{"1", "1", "1"});
  };
  placement.position =
      take(kTranslation, three_numbers(written_text(holder, kTranslation, "0 0 0")));
  placement.rotation = take(kRotation, shown_degrees(written_text(holder, kRotation, "0 0 1 0")));
  set_signed_scale(placement,
                   take(kScaling, three_numbers(written_text(holder, kScaling, "1 1 1"))));
}

void set_x3d_placement(EditSequence& sequence, int entity, const Placement& there,
                       const Placement& wanted) {
  std::vector<std::pair<std::string_view, std::string>> values;
  if (!is_same(there.position, wanted.position))
    values.emplace_back(kTranslation, respelled(there.position, wanted.position));
  if (!is_same_rotation(there.rotation, wanted.rotation))
    values.emplace_back(kRotation, written_degrees(wanted.rotation));
  const TypedTriple scale = signed_scale(there), wanted_scale = signed_scale(wanted);
  if (!is_same(scale, wanted_scale)) values.emplace_back(kScaling, respelled(scale, wanted_scale));
  if (values.empty()) return;
  int transform = placing_transform(sequence.now(), entity);
  if (transform < 0) {
    sequence.then([&](const Outline& now) { return wrap(now, entity); });
    transform = entity;  // stands before the Inline, which comes one later
  }
  for (const auto& each : values) {
    sequence.then(
        [&](const Outline& now) { return set_xml_field(now, transform, each.first, each.second); });
  }
}

}  // namespace tessera::edit
